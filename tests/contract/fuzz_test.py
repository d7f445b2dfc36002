#!/usr/bin/env python3
"""fuzz_test.py BUILD: schemathesis against a running server: requests made from the
contract, right ones and wrong ones; every reply has to be described. Which values each
parameter goes through ("coverage") is tried in one of the two ways to ask a query, by GET
or by POST; GEODESICD_SEED repeats a draw.

Runs in the environment of scripts/fetch_contract_tools."""

import os
import pathlib
import random
import subprocess
import sys

import ruamel.yaml
from server import Server
from walk import samples

HERE = pathlib.Path(__file__).resolve().parent
CONTRACT = HERE.parents[1] / "proto" / "openapi.yaml"


def drawn_config(folder):
    """A file in this folder: schemathesis.toml, with the draw."""
    seed = int(os.environ.get("GEODESICD_SEED") or random.randrange(2**32))
    print(f"GEODESICD_SEED={seed}", flush=True)
    draw = random.Random(seed)
    paths = ruamel.yaml.YAML(typ="safe").load(CONTRACT)["paths"]
    both = [path for name, path in paths.items() if "{id}" in name and {"get", "post"} <= path.keys()]
    left = [path[draw.choice(("get", "post"))]["operationId"] for path in both]
    text = (HERE / "schemathesis.toml").read_text()
    for name in left:
        text += f'\n[[operations]]\ninclude-operation-id = "{name}"\n'
        text += "[operations.phases.coverage]\nenabled = false\n"
    config = folder / "schemathesis.toml"
    config.write_text(text)
    return config


def main():
    """Runs schemathesis, and hands on what it finds."""
    build = sys.argv[1]
    with Server(build, "--body-timeout-seconds", 10) as server:
        mesh = server.upload(samples(build)["plane.glb"])
        command = [str(pathlib.Path(sys.executable).parent / "schemathesis")]
        command += ["--config-file", str(drawn_config(server.folder)), "run"]
        command += [f"http://127.0.0.1:{server.port}/openapi.json"]
        # No chance beside that is involved.
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
