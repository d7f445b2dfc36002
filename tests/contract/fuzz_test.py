#!/usr/bin/env python3
"""fuzz_test.py BUILD: schemathesis against a running server: requests made from the
contract, right ones and wrong ones, always the same; every reply has to be described.

Runs in the environment of scripts/fetch_contract_tools."""

import os
import pathlib
import subprocess
import sys

from server import Server
from walk import samples

HERE = pathlib.Path(__file__).resolve().parent


def main():
    """Runs schemathesis, and hands on what it finds."""
    build = sys.argv[1]
    with Server(build, "--body-timeout-seconds", 10) as server:
        mesh = server.upload(samples(build)["plane.glb"])
        command = [str(pathlib.Path(sys.executable).parent / "schemathesis")]
        command += ["--config-file", str(HERE / "schemathesis.toml"), "run"]
        command += [f"http://127.0.0.1:{server.port}/openapi.json"]
        # No chance is involved.
        command += ["--max-examples", "3", "--generation-deterministic"]
        command += ["--phases", "examples,coverage,fuzzing"]
        command += ["--request-timeout", "60", "--max-failures", "20", "--continue-on-failure"]
        command += ["--warnings", "off"]
        # It would delete the mesh that all others ask about; walk_test.py deletes one.
        command += ["--exclude-operation-id", "deleteMesh", "--no-color", *sys.argv[2:]]
        environment = {**os.environ, "CONTRACT_MESH": mesh, "SCHEMATHESIS_HOOKS": "hooks"}
        environment["PYTHONPATH"] = str(HERE)
        # It leaves files where it runs.
        status = subprocess.run(command, cwd=server.folder, env=environment, check=False).returncode
        alive = server.process.poll() is None and server.ask("GET", "/v1/status").status == 200
    if not alive:
        print(f"FAILED: the server is gone: {server.log()}")
    sys.exit(status or (0 if alive else 1))


if __name__ == "__main__":
    main()
