#!/usr/bin/env python3
"""docs/operating/handbook.md: each alert has its section and leads to it, and a back-up made as the page says, while
clients upload and delete, brings everything back.

    handbook_test.py GEODESICD

GEODESICD_SEED=NUMBER sets the meshes; it is printed.
"""

import json
import os
import pathlib
import random
import re
import secrets
import subprocess
import sys
import tempfile
import threading
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(HERE.parent / "crash"))

import yaml  # noqa: E402
from service import Service, digest, mesh  # noqa: E402

PAGE = ROOT / "docs" / "operating" / "handbook.md"
MESHES = 40
BACKUPS = 10  # the last one is restored
# tar's status 1: bytes do not change, but folders and times of use do.
MEANWHILE = re.compile(r"(tar: \S+: (file changed as we read it|File removed before we read it)\n)+")
failures = 0


def expect(what, is_so, *details):
    """Prints a line about one thing that must be so."""
    global failures
    failures += not is_so
    print(("ok: " if is_so else "FAILED: ") + what, *(() if is_so else details), flush=True)


def alerts_have_sections(text):
    """Alerts and sections, both ways."""
    rules = yaml.safe_load((ROOT / "deploy/prometheus/alerts.yml").read_text(encoding="utf-8"))
    alerts = {rule["alert"]: rule["annotations"] for group in rules["groups"] for rule in group["rules"]}
    sections = dict(re.findall(r"^### (\w+)\n(.*?)(?=^##|\Z)", text[text.index("\n## Alerts\n"):], re.S | re.M))
    expect("each alert has its section, and each section its alert", set(alerts) == set(sections) and len(alerts) >= 12,
           set(alerts) ^ set(sections))
    short = [name for name, section in sections.items() if len(re.findall(r"^\d\. ", section, re.M)) < 2]
    expect("each says at least two things to do", not short, short)
    site = PAGE.relative_to(ROOT).with_suffix("")
    wrong = {name: said.get("runbook_url") for name, said in alerts.items()
             if said.get("runbook_url") != f"https://geodesic.example.org/{site}/#{name.lower()}"}
    expect("each alert leads to its section", not wrong, wrong)


def commands(text, first, folder):
    """The page's block of commands that begins so, as it is in a store in `folder`."""
    [block] = [each for each in re.findall(r"^```sh\n(.*?)^```$", text, re.S | re.M) if each.startswith(first)]
    return block.replace("/var/lib/geodesicd", str(folder))


def run(block, folder):
    """What bash prints of it, and its exit status."""
    done = subprocess.run(["bash", "-c", block], cwd=folder, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout + done.stderr


class Clients(threading.Thread):
    """Somebody who uploads and deletes while the back-up is made."""

    def __init__(self, service, random_):
        super().__init__()
        self._service, self._random, self._ending = service, random_, threading.Event()
        self.count = 0
        self.start()

    def run(self):
        while not self._ending.is_set():
            data = mesh(self._random.randrange(8, 30), self._random.random())
            self._service.ask("POST", "/v1/meshes?name=meanwhile", data)
            if self._random.random() < 0.5:
                self._service.ask("DELETE", f"/v1/meshes/{digest(data)}")
            self.count += 1

    def stop(self):
        """Waits for what was begun."""
        self._ending.set()
        self.join()


def one_comes_back(service, text, folder, id_):
    """A mesh that was read with scale=2, out of the back-up, and gone from it afterwards."""
    service.ask("DELETE", f"/v1/meshes/{id_}")
    [extract] = re.findall(r"^tar --extract --file .*$", text, re.M)
    [delete] = re.findall(r"`(tar --delete [^`]*)`", text)
    extract, delete = (command.replace("/ab/ID", f"/{id_[:2]}/{id_}") for command in (extract, delete))
    status, said = run(extract, folder)
    data = (folder / "objects" / id_[:2] / id_).read_bytes()
    put = [service.ask("PUT", f"/v1/meshes/{id_}?name=again{more}", data)[0] for more in ("", "&scale=3", "&scale=2")]
    expect("one mesh comes back by itself, if it is read as before", (status, put) == (0, [422, 422, 201]), said, put)
    done, gone = run(delete.replace("\n", " "), folder), run(extract, folder)
    expect("and can be taken out of the back-up", done == (0, "") and gone[0] != 0, done, gone)


def comes_back(program, text, folder, random_):
    """Backs a store up and restores it."""
    store, restored = folder / "store", folder / "restored"
    restored.mkdir()
    flags = ["--log-level", "warn", "--store"]
    service = Service(program, [*flags, store], folder / "log")
    meshes = {digest(data): data for data in (mesh(random_.randrange(8, 30), random_.random()) for _ in range(MESHES))}
    for name, data in meshes.items():
        service.ask("POST", f"/v1/meshes?name={name[:8]}", data)
    # Read in another way, it is another mesh.
    data = mesh(9, random_.random())
    status, _, body = service.ask("POST", f"/v1/meshes?scale=2&name={digest(data)[:8]}", data)
    scaled = json.loads(body)["id"]
    meshes[scaled] = data
    expect("one mesh is read with options of its own", status == 201 and f"{digest(data)}~" in body.decode(), body)
    clients = Clients(service, random_)
    while clients.count < 3:
        time.sleep(0.01)
    before = clients.count
    made = [run(commands(text, "tar --create", store), folder) for _ in range(BACKUPS)]
    wrong = [each for each in made if each != (0, "") and not (each[0] == 1 and MEANWHILE.fullmatch(each[1]))]
    expect(f"tar backs the store up {BACKUPS} times", not wrong, wrong)
    expect("while clients upload and delete", clients.count > before, before, clients.count)
    clients.stop()
    service.stop()

    status, said = run(commands(text, "tar --extract --preserve", restored), folder)
    expect("tar restores it", status == 0 and not said, said)
    checked = commands(text, "find ", restored)
    expect("no file of it is damaged", run(checked, folder) == (0, ""), run(checked, folder))
    described = {path.stem for path in (restored / "meta").rglob("*.json")}
    kept = {path.name for path in (restored / "objects").rglob("*") if path.is_file()}
    # What was deleted between the two folders has lost its bytes alone.
    expect("all that was there is described and has its bytes", set(meshes) <= described & kept)

    service = Service(program, [*flags, restored], folder / "log")
    wrong = []
    for name, data in meshes.items():
        status, about = service.get_json(f"/v1/meshes/{name}")
        source = service.ask("GET", f"/v1/meshes/{name}/source")
        if (status, about.get("name"), source[0], source[2]) != (200, name[:8], 200, data):
            wrong.append((name, status, about, source[0]))
    expect(f"{len(meshes)} meshes have their names and bytes again", not wrong, wrong)
    listed = service.ids()
    lost = [each for each in listed if service.ask("GET", f"/v1/meshes/{each}/distance?from=v:0&at=v:1")[0] != 200]
    expect("whatever is listed can be asked about", set(meshes) <= set(listed) and not lost, lost)
    one_comes_back(service, text, folder, scaled)
    service.stop()

    damaged = restored / "objects" / listed[0][:2] / listed[0]
    data = bytearray(damaged.read_bytes())
    data[random_.randrange(len(data))] ^= 1 << random_.randrange(8)
    damaged.write_bytes(data)
    expect("the check finds a bit that has changed", run(checked, folder) == (0, f"{damaged}\n"), run(checked, folder))


def main():
    """The whole test."""
    seed = int(os.environ.get("GEODESICD_SEED") or secrets.randbelow(2**31))
    print(f"GEODESICD_SEED={seed}")
    text = PAGE.read_text(encoding="utf-8")
    alerts_have_sections(text)
    with tempfile.TemporaryDirectory(prefix="handbook_test_") as name:
        comes_back(os.path.abspath(sys.argv[1]), text, pathlib.Path(name), random.Random(seed))
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
