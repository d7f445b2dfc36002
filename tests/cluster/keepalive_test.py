#!/usr/bin/env python3
"""Of a kept connection between nginx and a server, nginx closes it, and no request is lost.

    keepalive_test.py GEODESICD

nginx runs as deploy/nginx/fleet.conf has it, but for shorter times, and sends nothing again; a relay
before the server notes who closes each connection first. Clients post at once, with pauses about as
long as nginx keeps a connection. All are answered, and the server closes none. With the times the other way
round it is the server that closes: so the relay would see it. Skipped where there is no nginx.

GEODESICD_SEED=NUMBER sets the pauses; it is printed.
"""

import collections
import concurrent.futures
import hashlib
import json
import os
import pathlib
import random
import re
import subprocess
import sys
import tempfile
import threading
import time

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "crash"))

import nginx  # noqa: E402
from balancers import ROOT, Nginx  # noqa: E402
from relay import Relay  # noqa: E402
from service import Service, mesh  # noqa: E402

CLIENTS = 8
SECONDS = 5.0
SHORT, LONG = 1, 30  # seconds a connection may idle

failures = 0


def expect(what, is_so, *details):
    """Prints a line about one thing that must be so."""
    global failures
    failures += not is_so
    print(("ok: " if is_so else "FAILED: ") + what, *(() if is_so else details), flush=True)


def seconds_in(file, name):
    """What a configuration of nginx says of a time."""
    return int(re.search(rf"^\s*{name} (\d+)s?;", (ROOT / file).read_text(encoding="utf-8"), re.M).group(1))


def deployed(program):
    """The numbers that are deployed, against the server's own."""
    printed = subprocess.run([program, "--print-config"], capture_output=True, text=True, check=True).stdout
    idles = int(re.search(r'^keep-alive-seconds +"(\d+)"', printed, re.M).group(1))
    kept = seconds_in("deploy/nginx/fleet.conf", "keepalive_timeout")
    expect("nginx gives a connection up well before the server does", kept + 10 <= idles, kept, idles)


def posts(balancer, path, seed):
    """How often each status came, in rounds of posts at once with pauses about as long as nginx keeps a connection."""
    draw = random.Random(seed)
    statuses = collections.Counter()
    end = time.monotonic() + SECONDS

    def post(vertex):
        body = json.dumps({"from": [f"v:{vertex}"]})
        return balancer.ask("POST", path, body, {"Content-Type": "application/json"})[0]

    with concurrent.futures.ThreadPoolExecutor(CLIENTS) as pool:
        while time.monotonic() < end:
            statuses.update(pool.map(post, [draw.randrange(100) for _ in range(CLIENTS)]))
            time.sleep(SHORT * draw.choice([0, draw.uniform(0.95, 1.05), draw.uniform(0.7, 1.3)]))
    return statuses


def closed(program, folder, of_server, of_nginx, seed):
    """(statuses, closings by side, connections) where either keeps connections for so many seconds."""
    folder.mkdir()
    data = mesh(10, 1)
    flags = ["--store", folder / "store", "--keep-alive-seconds", str(of_server), "--log-level", "off"]
    service = Service(program, flags, folder / "log")
    service.ask("POST", "/v1/meshes", data)
    relay = Relay(service.port)
    balancer = Nginx(folder / "nginx", [relay.port] * 3,
                     [(r"keepalive_timeout 60s", f"keepalive_timeout {of_nginx}s"),
                      (r"proxy_next_upstream [^;]*", "proxy_next_upstream off")])
    try:
        statuses = posts(balancer, f"/v1/meshes/{hashlib.sha256(data).hexdigest()}/distance", seed)
        end = time.monotonic() + LONG - 10
        while relay.open and time.monotonic() < end:
            time.sleep(0.05)
        # Before either is stopped.
        return statuses, relay.closed.copy(), relay.taken
    finally:
        balancer.stop()
        relay.stop()
        service.stop()


def main():
    """Both ways; exits with 1 if something was not so."""
    program = os.path.abspath(sys.argv[1])
    if nginx.program("--known") is None:
        print("skipped: needs nginx (scripts/setup gets it)")
        return 77
    seed = int(os.environ.get("GEODESICD_SEED") or random.SystemRandom().randrange(1 << 31))
    print(f"GEODESICD_SEED={seed}", flush=True)
    deployed(program)
    with tempfile.TemporaryDirectory(prefix="keepalive_") as name:
        found = {}

        def run(way, *times):
            found[way] = closed(program, pathlib.Path(name, way), *times, seed)

        ways = [threading.Thread(target=run, args=("ours", LONG, SHORT)),
                threading.Thread(target=run, args=("reversed", SHORT, LONG))]
        for way in ways:
            way.start()
        for way in ways:
            way.join()
    statuses, sides, taken = found["ours"]
    print(f"{sum(statuses.values())} requests on {taken} connections, closed by {dict(sides)}")
    expect("every request is answered", set(statuses) == {200}, statuses)
    expect("connections are used again", taken < sum(statuses.values()), taken, statuses)
    expect("nginx closes all of them", sides["balancer"] == taken > 0 and sides["server"] == 0, sides, taken)
    _, sides, _ = found["reversed"]
    expect("with less time than nginx, the server would close them", sides["server"] > 0, sides)
    return failures != 0


if __name__ == "__main__":
    sys.exit(main())
