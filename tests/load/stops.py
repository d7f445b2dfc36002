#!/usr/bin/env python3
"""stops.py BUILD: how much a server still computes for a client that has hung up.

Each kind of work is begun (kinds_of_work.py), many on a terrain of a million vertices, and its
client closes the connection at some moment. The script then measures the processor time that the
server and its decoders still take until they rest. That is what a stop costs others, and it does
not depend on who else uses the machine. An upload that had finished before its client left is
counted separately. Exit status 1 if any took more than 50 ms."""

import argparse
import http.client
import json
import pathlib
import random
import select
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

from kinds_of_work import kinds_of_work  # noqa: E402
from service import Checks, Service, describe  # noqa: E402

BOUND_MS = 50.0
REST = 0.1  # seconds without work that count as rest


def begin(port, method, target, body=None):
    """Sends a request and leaves its reply alone."""
    connection = http.client.HTTPConnection("127.0.0.1", port)
    connection.request(method, target, body)
    return connection


def until_at_rest(service):
    """The processor time that is taken until there is a while without any."""
    begun = last = service.processor_seconds()
    resting_since = time.monotonic()
    while time.monotonic() - resting_since < REST:
        time.sleep(0.01)
        now = service.processor_seconds()
        if now - last > 2e-4:  # more than idle threads take when they poll
            resting_since = time.monotonic()
        last = now
    return last - begun


def stored(service):
    """How many meshes there are."""
    return service.get("/v1/meshes?limit=1000").count(b'"id":"')


def reply_began(connection):
    """Whether there is some of the reply already, and that it is none that refuses."""
    if not select.select([connection.sock], [], [], 0)[0]:
        return False
    head = connection.sock.recv(4096)
    if int(head.split(b" ", 2)[1]) >= 400:
        raise RuntimeError(repr(head))
    return True


def stops(service, work, rounds, longest):
    """Processor times by when it was hung up: moments spread over `longest` seconds. And how
    often a mesh had been stored, and a reply had begun."""
    times = {}
    finished = begun = 0
    meshes = stored(service)
    for turn in range(rounds):
        method, target, body = work(turn)
        connection = begin(service.port, method, target, body)
        moment = longest * (turn + random.random()) / rounds
        time.sleep(moment)
        begun += reply_began(connection)
        connection.close()
        taken = until_at_rest(service)
        before, meshes = meshes, stored(service)
        if meshes > before:
            finished += 1
        else:
            times[moment] = taken
    return times, finished, begun


def took(service, work):
    """How long the whole work takes when nobody hangs up."""
    method, target, body = work(-1)
    begun = time.perf_counter()
    connection = begin(service.port, method, target, body)
    reply = connection.getresponse()
    text = reply.read()
    if reply.status >= 400:
        raise RuntimeError(f"{target}: {reply.status}: {text[:500]!r}")
    return time.perf_counter() - begun


def main():
    """Prints a line a kind of work."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--rounds", type=int, default=12)
    parser.add_argument("--side", type=int, default=1000, help="side of the terrain")
    parser.add_argument("--only", help="one kind of work")
    parser.add_argument("--within", type=float, help="seconds, in place of the whole work's")
    args = parser.parse_args()
    random.seed(4)
    checks = Checks()
    with Service(args.build, "--field-cache-bytes", "0") as service:

        def upload(file):
            return json.load(begin(service.port, "POST", "/v1/meshes", file).getresponse())["id"]

        for name, work in kinds_of_work(upload, args.side):
            if args.only not in (None, name):
                continue
            longest = args.within or took(service, work)
            times, finished, begun = stops(service, work, args.rounds, longest)
            print(f"{name}, hung up within {longest:.2f} s: {describe(list(times.values()))}")
            if finished or begun:
                print(f"  {finished} had been stored, {begun} replies had begun")
            if not times:
                continue
            worst = max(times, key=times.get)
            checks.at_most(f"  at most, after {worst:.3f} s", 1000 * times[worst], BOUND_MS)
    sys.exit(1 if checks.failed else 0)


if __name__ == "__main__":
    main()
