#!/usr/bin/env python3
"""curl_cases.py GEODESICD SAMPLES: the rows of contract_cases.json that the curl scripts can ask, by
these scripts, and the names of files. The scripts have one way to upload a file, to save a field and
to print a path, and points as URLs say them; they print an error's code."""

import json
import os
import pathlib
import re
import struct
import subprocess
import sys
import tempfile
import urllib.request

ROOT = pathlib.Path(__file__).resolve().parents[2]
TABLE = json.loads((ROOT / "tests/clients/contract_cases.json").read_text(encoding="utf-8"))
# A file system's names have at most so many bytes.
LONGEST_NAME = 255


def text_of(point):
    """A point as the scripts take it; None where it cannot be said so."""
    if isinstance(point, str):
        return point
    return f"v:{point['vertex']}" if list(point) == ["vertex"] else None


def words_of(row):
    """The row's words for its script, the mesh apart; None where no script can ask it."""
    if "steps" in row or row.get("job") or "token" in row or row.get("server") == "tokens":
        return None
    given = dict(row.get("arguments", {}))
    if row["call"] == "upload":
        return None if given else []
    if row["call"] == "distance" and given.pop("format", "f32") == "f32":
        points = given.pop("from", [])
        words = [text_of(point) for point in points] if len(points) == 1 else [None]
    elif row["call"] == "path" and {"from", "to"} <= set(given):
        words = [text_of(given.pop("from")), text_of(given.pop("to"))]
    else:
        return None
    return None if given or None in words else words


def script(name, *words):
    return subprocess.run([ROOT / "clients/curl" / name, *words], capture_output=True, text=True,
                          check=False)


def close(number, wanted):
    return abs(float(number) - wanted) <= 1e-6 * max(1, abs(wanted))


def check_field(field, printed, expect):
    values = struct.unpack(f"<{len(field) // 4}f", field)
    assert f"count {len(values)}\n" in printed, printed
    for wanted in expect.get("arrays", {}).values():
        assert len(values) == wanted["shape"][0]
        for index, value in wanted.get("values", {}).items():
            assert close(values[int(index)], value), (index, value)
        assert all(values[index] == float("inf") for index in wanted.get("unreached", []))
    greatest = max(value for value in values if value != float("inf"))
    assert close(re.search(r"^max (.*)$", printed, re.M)[1], greatest)


def check_path(printed, expect):
    length, count, *points = printed.splitlines()
    wanted = expect["json"]
    if wanted.get("length") is not None:
        assert close(length.removeprefix("length "), wanted["length"])
    else:
        assert wanted.get("length", "") == "" or length == "length inf"
    assert count == f"points {len(points)}"
    for path, value in wanted.items():
        if path == "points":
            assert len(points) == value["count"]
        elif found := re.fullmatch(r"points\[(\d+)\]\.xyz", path):
            assert all(map(close, points[int(found[1])].split(), value))


class Servers:
    """A server for each name in the table, started when a row first needs it."""

    def __init__(self, binary, folder):
        self._binary, self._folder, self._running = binary, folder, {}

    def url(self, name):
        if name not in self._running:
            process = subprocess.Popen(
                [self._binary, "--listen", "127.0.0.1:0", "--store", self._folder / name,
                 "--log-level", "error", *TABLE["servers"][name]["flags"]],
                stdout=subprocess.PIPE, text=True)
            line = process.stdout.readline()
            self._running[name] = (process, re.search(r"http://\S+", line)[0])
        return self._running[name][1]

    def stop(self):
        for process, _ in self._running.values():
            process.kill()
            process.communicate()


def run(row, words, servers, samples, folder):
    url = servers.url(row.get("server", "plain"))
    mesh, expect = row["mesh"], row["expect"]
    file = samples / mesh if isinstance(mesh, str) else None
    if isinstance(mesh, str) and mesh in TABLE["meshes"]:
        file = folder / "mesh"
        file.write_bytes(TABLE["meshes"][mesh]["text"].encode())
    uploaded = script("upload.sh", file, url) if file else None
    id = uploaded.stdout.strip() if file else mesh["id"]
    field = folder / "field.f32"
    field.unlink(missing_ok=True)
    if row["call"] == "upload":
        said = uploaded
    elif row["call"] == "distance":
        said = script("field.sh", id, *words, field, url)
    else:
        said = script("path.sh", id, *words, url)
    if expect["status"] >= 400:
        assert said.returncode == 1
        assert f" {expect['code']}: " in said.stderr, said.stderr
        assert not said.stdout
        return
    assert said.returncode == 0, said.stderr
    if row["call"] == "distance":
        check_field(field.read_bytes(), said.stdout, expect)
    elif row["call"] == "path":
        check_path(said.stdout, expect)
    elif "id" in expect.get("json", {}):
        assert id == expect["json"]["id"]


def check_names(url, folder):
    """What the mesh of a file is called, for every row of `file_names`."""
    names = TABLE["file_names"]
    refused = "".join(one for one in names["refused"] if one != "\0")
    rows = [*names["rows"], [f"a{refused}b.glb", "ab.glb"],
            *([f"a{one}.glb", f"a{one}.glb"] for one in names["taken"] if one not in "/\0")]
    rows.append(["gr\udcf6\udcdfe.glb", "gr\ufffd\ufffde.glb"])  # bytes that are no UTF-8
    checked = 0
    for name, called in rows:
        if "/" in name or len(os.fsencode(name)) > LONGEST_NAME:
            continue
        file = folder / name
        file.write_bytes(TABLE["meshes"]["triangle"]["text"].encode())
        said = script("upload.sh", file, url)
        assert said.returncode == 0, (name, said.stderr)
        mesh = f"{url}/v1/meshes/{said.stdout.strip()}"
        with urllib.request.urlopen(mesh) as reply:
            assert json.load(reply).get("name") == called, name
        urllib.request.urlopen(urllib.request.Request(mesh, method="DELETE")).close()
        file.unlink()
        checked += 1
    return checked


def main():
    binary, samples = map(pathlib.Path, sys.argv[1:])
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        servers = Servers(binary, folder)
        try:
            names = check_names(servers.url("plain"), folder)
            asked = 0
            for row in TABLE["cases"]:
                words = words_of(row)
                if words is None:
                    continue
                try:
                    run(row, words, servers, samples, folder)
                except AssertionError as error:
                    sys.exit(f"FAILED: {row['name']}: {error}")
                asked += 1
        finally:
            servers.stop()
    assert asked >= 20 and names >= 10, (asked, names)
    print(f"ok: {asked} cases of the contract, {names} names of files")


main()
