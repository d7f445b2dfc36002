#!/usr/bin/env python3
"""Large queries of every kind at once, in little memory: each is answered or refused in a way
that says what to do, the server lives, holds no more than it may, and gives memory back.

    memory_mix.py BUILD [--side 1000] [--seconds 120] [--container-gib 8]

With --container-gib the server has the defaults that it has in a container of that size, and
is in one as far as memory goes (container.py).
"""

import argparse
import contextlib
import json
import math
import pathlib
import random
import struct
import sys
import threading
import time
import urllib.error
import urllib.request

from container import Container
from service import Service

METHODS = ["exact", "exact", "exact", "chen_han", "steiner", "auto", "wavefront", "fast_marching"]
# What a query may end with: an answer, too_much_memory, a deadline, or not now and when.
ALLOWED = {200, 422, 503, 504}
# A slot's idle memory, replies on their way, and what the process is made of.
BESIDES = 300


def bumpy(side):
    """A grid of `side` x `side` vertices over which windows multiply, as binary PLY."""
    step = 10 / (side - 1)
    head = "ply\nformat binary_little_endian 1.0\n"
    head += f"element vertex {side * side}\nproperty float x\nproperty float y\nproperty float z\n"
    head += f"element face {2 * (side - 1) ** 2}\nproperty list uchar uint vertex_indices\n"
    out = bytearray((head + "end_header\n").encode())
    for j in range(side):
        for i in range(side):
            x, y = i * step, j * step
            z = 0.6 * math.sin(3 * x) * math.cos(2 * y) + 0.1 * math.sin(17 * x + 3 * y)
            out += struct.pack("<fff", x, y, z)
    for j in range(side - 1):
        for i in range(side - 1):
            a = j * side + i
            out += struct.pack("<BIII", 3, a, a + 1, a + side + 1)
            out += struct.pack("<BIII", 3, a, a + side + 1, a + side)
    return bytes(out)


def resident_mb(pid):
    """What the process holds now, and the most that it has."""
    status = pathlib.Path(f"/proc/{pid}/status").read_text(encoding="ascii")
    fields = dict(line.split(":", 1) for line in status.splitlines())
    return [int(fields[name].split()[0]) // 1024 for name in ("VmRSS", "VmHWM")]


def ask(url, timeout):
    """The status, the code of a problem, the seconds, and those after which to ask again."""
    begin = time.perf_counter()
    try:
        with urllib.request.urlopen(url, timeout=timeout) as reply:
            while reply.read(1 << 20):
                pass
            return reply.status, "", time.perf_counter() - begin, 0
    except urllib.error.HTTPError as error:
        body = json.load(error)
        if body["code"] == "too_much_memory" and not body["limit"] < body["actual"]:
            return 0, "a limit that was not exceeded", 0, 0
        code = body["code"]
        if "memory" in body["detail"]:
            code += " with memory"
        seconds = time.perf_counter() - begin
        return error.code, code, seconds, float(error.headers.get("Retry-After", 0))


class Mix:
    """Clients that ask at random until the time is over."""

    def __init__(self, service, mesh, arguments, seed):
        self._base = service.url(f"/v1/meshes/{mesh['id']}")
        self._mesh = mesh
        self._end = time.monotonic() + arguments.seconds
        self._deadline = arguments.deadline_ms
        self._seed = seed
        self._lock = threading.Lock()
        self.counts = {}
        self.wrong = []

    def client(self, number):
        """Asks one question after another."""
        draw = random.Random(self._seed + number)
        faces, vertices = self._mesh["faces"], self._mesh["vertices"]
        while time.monotonic() < self._end:
            method = draw.choice(METHODS)
            inside = f"f:{draw.randrange(faces)},0.3,0.3"
            source = draw.choice([inside, f"v:{draw.randrange(vertices)}"])
            target = draw.choice([f"v:{draw.randrange(vertices)}", f"f:{draw.randrange(faces)},0.2,0.5"])
            url = draw.choice(
                [
                    f"/distance?from={source}",
                    f"/distance?from={source}&at={target}",
                    f"/path?from={source}&to={target}",
                    f"/isolines?from={source}&count=20",
                    f"/table?from={source}&to={target}",
                ]
            )
            url += f"&method={method}&deadline_ms={self._deadline}"
            self._ask_until_answered(url)

    def _ask_until_answered(self, url):
        """One question, again whenever the server says so."""
        again = 1
        while again and time.monotonic() < self._end:
            try:
                status, code, seconds, again = ask(self._base + url, 600)
            except OSError as error:
                status, code, seconds, again = 0, str(error), 0, 0
            with self._lock:
                key = (status, code)
                self.counts[key] = self.counts.get(key, 0) + 1
                late = seconds > self._deadline / 1000 + 30
                if status not in ALLOWED or late or (status == 503) != (again > 0):
                    self.wrong.append((url, status, code, round(seconds, 1)))
            time.sleep(again)


def options_of(arguments):
    """The server's: bounds that are asked for; and outside of a container, of all."""
    defaults = (None, None, None) if arguments.container_gib else (1024, 2048, 512)
    query, compute, caches = (
        given or default
        for given, default in zip(
            (arguments.query_mib, arguments.compute_mib, arguments.caches_mib), defaults
        )
    )
    options = []
    if query:
        options += ["--query-memory-bytes", f"{query}MiB"]
    if compute:
        options += ["--compute-memory-bytes", f"{compute}MiB"]
    if caches:
        for cache in ("mesh", "adjacency", "field"):
            options += [f"--{cache}-cache-bytes", f"{caches}MiB"]
        options += ["--reply-cache-bytes", "0"]
    return options


def upload(service, data):
    """What the server says of the mesh."""
    request = urllib.request.Request(service.url("/v1/meshes"), data)
    with urllib.request.urlopen(request) as reply:
        return json.load(reply)


def main():
    """0 if the server did as it should."""
    parser = argparse.ArgumentParser()
    parser.add_argument("build")
    parser.add_argument("--side", type=int, default=1000)
    parser.add_argument("--seconds", type=float, default=120)
    parser.add_argument("--deadline-ms", type=int, default=60000)
    parser.add_argument("--clients", type=int, default=6)
    parser.add_argument("--query-mib", type=int)
    parser.add_argument("--compute-mib", type=int)
    parser.add_argument("--caches-mib", type=int, help="of each of three")
    parser.add_argument("--container-gib", type=float)
    arguments = parser.parse_args()
    seed = random.randrange(1 << 32)
    print(f"GEODESICD_SEED={seed}")
    with contextlib.ExitStack() as stack:
        prefix = ()
        if arguments.container_gib:
            container = stack.enter_context(Container(int(arguments.container_gib * (1 << 30))))
            prefix = container.prefix
        service = stack.enter_context(
            Service(arguments.build, *options_of(arguments), prefix=prefix)
        )
        mesh = upload(service, bumpy(arguments.side))
        before, decoded = resident_mb(service.pid)
        print(f"{mesh['vertices']} vertices; resident {before} MB, while decoding {decoded} MB")
        mix = Mix(service, mesh, arguments, seed)
        threads = [threading.Thread(target=mix.client, args=[i]) for i in range(arguments.clients)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        time.sleep(1)
        after, most = resident_mb(service.pid)
        status = json.loads(service.get("/v1/status"))
        kills = container.kills() if arguments.container_gib else 0
    compute = status["limits"]["compute_memory_bytes"] >> 20
    caches = status["caches"].values()
    may = compute + sum(cache["budget"] >> 20 for cache in caches) + BESIDES
    rest = compute // 4 + sum(cache["bytes"] >> 20 for cache in caches) + BESIDES
    for key, count in sorted(mix.counts.items()):
        print(f"{count:6} {key[0]} {key[1]}")
    print(f"limits: a query {status['limits']['query_memory_bytes'] >> 20} MB, all {compute} MB")
    print(f"resident: most {most} MB (may be {may}), afterwards {after} MB (may be {rest})")
    print(f"computations hold {status['compute']['memory_bytes'] >> 20} MB afterwards")
    for wrong in mix.wrong[:10]:
        print("WRONG:", *wrong)
    if kills:
        print(f"the kernel has killed {kills} processes")
    failed = bool(mix.wrong or kills) or most > may or after > rest or (200, "") not in mix.counts
    print("FAILED" if failed else "ok")
    return failed


if __name__ == "__main__":
    sys.exit(main())
