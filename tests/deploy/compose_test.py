#!/usr/bin/env python3
"""deploy/compose: Docker Compose reads it, and its servers and its nginx do together what it says.

    in_tools.sh compose_test.py GEODESICD

Compose itself resolves the file. No engine runs here, so no image is: the three servers start with the variables
that they have in it, and nginx with its configuration, by the ports that they have here. Each has a folder for the
bucket: several on one are tests/cluster's.

GEODESICD_SEED=NUMBER sets what is drawn; it is printed.
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

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
FOLDER = ROOT / "deploy" / "compose"
sys.path[:0] = [str(HERE), *(str(HERE.parent / name) for name in ("crash", "cluster"))]

from balanced import Balancer, directives, maps_of, shares_out  # noqa: E402
from ports import free_port  # noqa: E402
from service import Service  # noqa: E402

SERVERS = ["one", "two", "three"]
CLEAN = {name: value for name, value in os.environ.items() if not name.startswith("GEODESICD_")}
failures = 0


def expect(what, is_so, *details):
    """Prints a line about one thing that must be so."""
    global failures
    failures += not is_so
    print(("ok: " if is_so else "FAILED: ") + what, *(() if is_so else details), flush=True)


def resolved(secret):
    """What Compose makes of the file; what it complains of."""
    environment = {**CLEAN, "S3_SECRET": secret}
    said = subprocess.run(["docker-compose", "--file", FOLDER / "compose.yaml", "config", "--format", "json"],
                          capture_output=True, text=True, check=False, env=environment)
    return json.loads(said.stdout) if said.returncode == 0 else None, said.stderr


def of_image():
    """The variables of the Dockerfile, but for folders that only the image has."""
    text = (ROOT / "Dockerfile").read_text(encoding="utf-8")
    found = dict(re.findall(r"\b(GEODESICD_\w+)=([^\s\\]+)", text[text.index("\nENV "):]))
    return {name: value for name, value in found.items() if name == "GEODESICD_LISTEN"}


def agrees(services, secret):
    """Names, ports and keys are the same wherever they stand."""
    expect("nginx waits for every server", set(services["nginx"]["depends_on"]) == set(SERVERS))
    published = {name: each["ports"] for name, each in services.items() if each.get("ports")}
    [port] = published["nginx"]
    expect("nothing but nginx is to be reached, and that from this machine alone",
           list(published) == ["nginx"] and port["host_ip"] == "127.0.0.1", published)
    configured = (FOLDER / "nginx.conf").read_text(encoding="utf-8")
    expect("it listens where it is reached", directives(configured, "listen") == [["listen", f"{port['target']};"]])
    listens = of_image()["GEODESICD_LISTEN"].rsplit(":", 1)[1]
    upstream = [words[1] for words in directives(configured, r"server \w+:")]
    expect("it asks the servers", upstream == [f"{name}:{listens}" for name in SERVERS], upstream)
    s3 = services["s3"]
    place = re.fullmatch(r"s3://(\w+)/\w+\?endpoint=http://(\w+)(:\d+)",
                         services["one"]["environment"]["GEODESICD_STORE"])
    command = s3["command"]
    expect("the servers ask the S3 server", place and place[2] == "s3"
           and command[command.index("--port") + 1] == place[3], command)
    expect("the bucket is one of its folders",
           [volume["target"] for volume in s3["volumes"]] == [f"{command[-1]}/{place[1]}"], s3["volumes"])
    keys = [s3["environment"]["ROOT_ACCESS_KEY"], s3["environment"]["ROOT_SECRET_KEY"]]
    expect("and know its keys", keys[1] == secret and all(
        [services[name]["environment"][f"AWS_{key}"] for key in ("ACCESS_KEY_ID", "SECRET_ACCESS_KEY")] == keys
        for name in SERVERS))


def takes(program, name, service):
    """The server reads each variable, and ends within its time."""
    environment = {**CLEAN, **of_image(), **service["environment"]}
    said = subprocess.run([program, "--check-config"], capture_output=True, text=True, check=False, env=environment)
    expect(f"{name} takes its variables", said.returncode == 0, said.stderr)
    said = subprocess.run([program, "--print-config"], capture_output=True, text=True, check=False,
                          env=environment).stdout
    ours = [each for each in environment if each.startswith("GEODESICD_")]
    unread = [each for each in ours if not re.search(rf"\s{each}$", said, re.M)]
    expect("and reads each", not unread and len(ours) >= 10, unread)
    drains = [int(value) for value in re.findall(r'^drain-(?:delay-)?seconds +"(\d+)"', said, re.M)]
    grace = re.fullmatch(r"(\d+)s", service["stop_grace_period"])
    expect("it may take as long as it drains", len(drains) == 2 and int(grace[1]) > sum(drains) + 1, drains, grace)


def works(program, services, folder, random_):
    """The servers and nginx."""
    servers = []
    for name in SERVERS:
        environment = {**services[name]["environment"], "GEODESICD_ADMIN_LISTEN": "127.0.0.1:0",
                       "GEODESICD_STORE": str(folder / name)}
        servers.append(Service(program, ["--log-level", "warn"], folder / "log", environment))
    port = free_port()
    configured = (FOLDER / "nginx.conf").read_text(encoding="utf-8")
    fleet = (ROOT / "deploy/nginx/fleet.conf").read_text(encoding="utf-8")
    expect("its maps are those of fleet.conf", maps_of(configured) == maps_of(fleet) and len(maps_of(fleet)) == 2)
    for name in ("hash", "zone", r"keepalive(?:_\w+)?", "client_max_body_size",
                 r"proxy_(?!cache|no_cache|ignore|buffering)\w+"):
        mine, theirs = ({tuple(words) for words in directives(text, name)} for text in (configured, fleet))
        expect(f"{name} is that of fleet.conf", mine and mine == theirs, mine ^ theirs)
    here = configured.replace("listen 8080;", f"listen 127.0.0.1:{port};")
    for name, server in zip(SERVERS, servers):
        here = here.replace(f" {name}:8080 ", f" 127.0.0.1:{server.port} ")
    balancer = Balancer(folder / "nginx", here, port)
    try:
        shares_out(expect, balancer, servers, random_)
    finally:
        balancer.stop()
        for server in servers:
            server.kill()


def main():
    """The whole test."""
    program = os.path.abspath(sys.argv[1])
    seed = int(os.environ.get("GEODESICD_SEED") or secrets.randbelow(2**31))
    print(f"GEODESICD_SEED={seed}")
    secret = secrets.token_hex(8)
    config, complaints = resolved(secret)
    expect("Compose reads the file and says nothing", config and not complaints, complaints)
    if not config:
        return 1
    expect("it wants a secret", resolved("")[0] is None)
    services = config["services"]
    expect("three servers, nginx and an S3 server", set(services) == {*SERVERS, "nginx", "s3"})
    agrees(services, secret)
    for name in SERVERS:
        takes(program, name, services[name])
    with tempfile.TemporaryDirectory(prefix="compose_test_") as name:
        works(program, services, pathlib.Path(name), random.Random(seed))
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
