#!/usr/bin/env python3
"""The store in object storage, against OpenStack Swift's S3 interface.

    s3_test.py GEODESICD S3_STORE_TEST

Starts the server, runs the unit tests against it, then geodesicd itself: everything at
once for some seconds (tests/load/torture.py), a restart, a server that hangs, and one
that is gone. Skipped where python3-swift is not installed
(`scripts/setup s3` installs it).
"""

import json
import os
import pathlib
import signal
import subprocess
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "crash"))

from service import Service, digest, mesh  # noqa: E402
from swift_bucket import BUCKET, KEYS, bucket  # noqa: E402

failures = 0


def expect(what, is_so, *details):
    """Prints a line about one thing that must be so."""
    global failures
    failures += not is_so
    print(("ok: " if is_so else "FAILED: ") + what, *(() if is_so else details), flush=True)


def code_of(reply):
    """The status and the error code of a reply."""
    return reply[0], json.loads(reply[2] or b"{}").get("code")


def run_service(program, folder, endpoint, proxy):
    """geodesicd with its store in a bucket."""
    url = f"s3://{BUCKET}/service?endpoint={endpoint}&timeout=1"

    def start():
        return Service(program, ["--store", url], folder / "log", KEYS)

    service = start()
    resident, other = mesh(10, 1), mesh(11, 2)
    query = f"/v1/meshes/{digest(resident)}/distance?from=v:"
    for data in (resident, other):
        expect("an upload is answered 201", service.ask("POST", "/v1/meshes", data)[0] == 201)
    service.kill()

    service = start()
    expect("after kill -9 both meshes are listed",
           sorted(service.ids()) == sorted([digest(resident), digest(other)]))
    expect("a query brings one back into memory", service.ask("GET", f"{query}0")[0] == 200)
    expect("the source is the file",
           service.ask("GET", f"/v1/meshes/{digest(resident)}/source")[2] == resident)

    os.kill(proxy, signal.SIGSTOP)
    try:
        expect("a query on a mesh in memory goes on while S3 hangs",
               service.ask("GET", f"{query}1")[0] == 200)
        far = f"/v1/meshes/{digest(other)}/distance?from=v:0"
        reply = service.ask("GET", far)
        expect("one on another mesh is answered 503 store_unavailable",
               code_of(reply) == (503, "store_unavailable"), reply)
        expect("with Retry-After", "retry-after" in reply[1], reply[1])
        expect("and names no host", b"127.0.0.1" not in reply[2], reply[2])
        reply = service.ask("POST", "/v1/meshes", mesh(12, 3))
        expect("so is an upload", code_of(reply) == (503, "store_unavailable"), reply)
        for _ in range(150):
            status = service.ask("GET", "/readyz")[0]
            if status == 503:
                break
            time.sleep(0.1)
        expect("the server is not ready", status == 503, status)
        expect("but alive", service.ask("GET", "/livez")[0] == 200)
    finally:
        os.kill(proxy, signal.SIGCONT)
    for _ in range(150):
        status = service.ask("GET", far)[0]
        if status == 200:
            break
        time.sleep(0.1)
    expect("when S3 is back, so is the other mesh", status == 200, status)
    expect("an upload is stored again",
           service.ask("POST", "/v1/meshes", mesh(12, 3))[0] == 201)
    expect("a mesh can be removed",
           service.ask("DELETE", f"/v1/meshes/{digest(other)}")[0] == 204)
    return service


def main():
    program, unit_tests = sys.argv[1:]
    with bucket() as there:
        if there is None:
            return 77
        folder, endpoint = there.folder, there.endpoint
        environment = {**os.environ, **KEYS, "GEODESIC_TEST_S3": endpoint,
                       "GEODESIC_TEST_S3_PID": str(there.proxy), "GEODESIC_TEST_S3_BUCKET": BUCKET}
        unit = subprocess.run([unit_tests], env=environment, check=False)
        expect("the unit tests pass", unit.returncode == 0)
        torture = subprocess.run(
            [sys.executable, str(HERE.parent / "load" / "torture.py"), str(pathlib.Path(program).parent),
             "--seconds", "20", "--clients", "4",
             "--store", f"s3://{BUCKET}/torture?endpoint={endpoint}"],
            env={**os.environ, **KEYS}, check=False)
        expect("what is asked at random is answered right", torture.returncode == 0)
        service = run_service(program, folder, endpoint, there.proxy)
        there.stop()
        reply = service.ask("POST", "/v1/meshes", mesh(13, 4))
        expect("without S3 an upload is answered 503",
               code_of(reply) == (503, "store_unavailable"), reply)
        query = f"/v1/meshes/{digest(mesh(10, 1))}/distance?from=v:2"
        expect("and a query on a mesh in memory 200", service.ask("GET", query)[0] == 200)
        expect("the server stops in order", service.stop() == 0)
        if failures and (folder / "log").exists():
            for line in (folder / "log").read_text(errors="replace").splitlines()[-30:]:
                print(f"  server: {line}")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
