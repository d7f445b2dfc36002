#!/usr/bin/env python3
"""A real disk that is full, then read-only: the server says so and goes on.

    disk_test.py GEODESICD

The store is on a small tmpfs of its own, which needs root or a kernel that lets users
have namespaces; otherwise the test is skipped.
"""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

from service import Service, digest, files_below, mesh

PARTS = ["tmp", "objects", "meta"]

failures = 0


def mount(*arguments):
    """mount(8), which must succeed."""
    subprocess.run(["mount", *map(str, arguments)], check=True)


def expect(what, is_so, *details):
    """Prints a line about one thing that must be so."""
    global failures
    failures += not is_so
    print(("ok: " if is_so else "FAILED: ") + what, *(() if is_so else details))


def run(program, store, folder):
    """The whole story on one disk of 2 MB."""
    service = Service(program, ["--store", str(store)], folder / "log")
    resident = mesh(20, 1)
    query = f"/v1/meshes/{digest(resident)}/distance?from=v:"
    expect("an empty disk takes a mesh", service.ask("POST", "/v1/meshes", resident)[0] == 201)
    expect("a query on it is answered", service.ask("GET", f"{query}0")[0] == 200)

    stored, refusal = [], None
    for seed in range(100):
        data = mesh(60, seed)  # 128 kB
        status, _, body = service.ask("POST", "/v1/meshes", data)
        if status != 201:
            refusal = (status, json.loads(body))
            break
        stored.append(digest(data))
    expect("the disk takes some more", len(stored) > 5, len(stored))
    expect("a full disk is answered 507 store_full",
           refusal is not None and refusal[0] == 507 and refusal[1]["code"] == "store_full", refusal)
    expect("the answer names no path", str(store) not in json.dumps(refusal))
    expect("nothing half written is left", not files_below(store / "tmp"))
    expect("what was stored is there and nothing else",
           sorted(service.ids()) == sorted([*stored, digest(resident)]))
    expect("queries go on", service.ask("GET", f"{query}1")[0] == 200)
    expect("what was stored can be read",
           digest(service.ask("GET", f"/v1/meshes/{stored[0]}/source")[2]) == stored[0])
    expect("a mesh can be removed", service.ask("DELETE", f"/v1/meshes/{stored[0]}")[0] == 204)
    expect("and another stored", service.ask("POST", "/v1/meshes", mesh(50, 1))[0] == 201)

    # The server holds its lock open for writing, which keeps the whole from it.
    for part in PARTS:
        mount("--bind", store / part, store / part)
        mount("-o", "remount,bind,ro", store / part)
    status, _, body = service.ask("POST", "/v1/meshes", mesh(10, 7))
    expect("a read-only disk is answered 500 store_failed",
           status == 500 and json.loads(body)["code"] == "store_failed", status, body)
    status, _, body = service.ask("DELETE", f"/v1/meshes/{stored[1]}")
    expect("a mesh cannot be removed then", status == 500, status, body)
    expect("queries on what is in memory go on", service.ask("GET", f"{query}2")[0] == 200)
    expect("sources can be read",
           digest(service.ask("GET", f"/v1/meshes/{stored[1]}/source")[2]) == stored[1])
    for _ in range(100):
        status = service.ask("GET", "/readyz")[0]
        if status == 503:
            break
        time.sleep(0.1)
    expect("the server is not ready", status == 503, status)
    expect("but alive", service.ask("GET", "/livez")[0] == 200)

    for part in PARTS:
        subprocess.run(["umount", str(store / part)], check=True)
    expect("a disk that can be written to again is written to",
           service.ask("POST", "/v1/meshes", mesh(10, 7))[0] == 201)
    for _ in range(100):
        status = service.ask("GET", "/readyz")[0]
        if status == 200:
            break
        time.sleep(0.1)
    expect("and the server ready again", status == 200, status)
    expect("it stops in order", service.stop() == 0)


def main():
    program = os.path.abspath(sys.argv[1])
    if "GEODESIC_DISK_TEST" not in os.environ:
        # Once more, in a namespace where a disk can be mounted.
        user = [] if os.geteuid() == 0 else ["--user", "--map-root-user"]
        space = ["unshare", *user, "--mount"]
        trial = subprocess.run([*space, "mount", "-t", "tmpfs", "none", "/mnt"],
                               capture_output=True, check=False)
        if trial.returncode != 0:
            print("skipped: no tmpfs can be mounted here, so no real disk can be full")
            return 77
        again = subprocess.run([*space, sys.executable, __file__, program], check=False,
                               env={**os.environ, "GEODESIC_DISK_TEST": "1"})
        return again.returncode
    with tempfile.TemporaryDirectory(prefix="disk_test_") as name:
        folder = pathlib.Path(name)
        store = folder / "store"
        store.mkdir()
        mount("-t", "tmpfs", "-o", "size=2m", "none", store)
        try:
            run(program, store, folder)
        finally:
            subprocess.run(["umount", "--lazy", str(store)], check=False)
        if failures:
            for line in (folder / "log").read_text(errors="replace").splitlines()[-20:]:
                print(f"  server: {line}")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
