#!/usr/bin/env python3
"""Large queries of every kind at once, in little memory: each is answered or refused in a way
that says what to do, the server lives, holds no more than it may, and gives memory back.

    memory_mix.py BUILD [--side 1000] [--seconds 120] [--limit-gib 8]
"""

import argparse
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

from service import Service

METHODS = ["exact", "exact", "exact", "chen_han", "steiner", "auto", "wavefront", "fast_marching"]
# What a query may end with: an answer, too_much_memory, a deadline, or not now.
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
    """The status, the code of a problem and the seconds."""
    begin = time.perf_counter()
    try:
        with urllib.request.urlopen(url, timeout=timeout) as reply:
            while reply.read(1 << 20):
                pass
            return reply.status, "", time.perf_counter() - begin
    except urllib.error.HTTPError as error:
        body = json.load(error)
        if body["code"] == "too_much_memory" and not body["limit"] < body["actual"]:
            return 0, "a limit that was not exceeded", 0
        return error.code, body["code"], time.perf_counter() - begin


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
            try:
                status, code, seconds = ask(self._base + url, 600)
            except OSError as error:
                status, code, seconds = 0, str(error), 0
            with self._lock:
                key = (status, code)
                self.counts[key] = self.counts.get(key, 0) + 1
                late = seconds > self._deadline / 1000 + 30
                if status not in ALLOWED or late:
                    self.wrong.append((url, status, code, round(seconds, 1)))


def main():
    """0 if the server did as it should."""
    parser = argparse.ArgumentParser()
    parser.add_argument("build")
    parser.add_argument("--side", type=int, default=1000)
    parser.add_argument("--seconds", type=float, default=120)
    parser.add_argument("--deadline-ms", type=int, default=60000)
    parser.add_argument("--clients", type=int, default=6)
    parser.add_argument("--query-mib", type=int, default=1024)
    parser.add_argument("--compute-mib", type=int, default=2048)
    parser.add_argument("--caches-mib", type=int, default=512, help="of each of three")
    arguments = parser.parse_args()
    seed = random.randrange(1 << 32)
    print(f"GEODESICD_SEED={seed}")
    options = ["--query-memory-bytes", f"{arguments.query_mib}MiB"]
    options += ["--compute-memory-bytes", f"{arguments.compute_mib}MiB"]
    for cache in ("mesh", "adjacency", "field"):
        options += [f"--{cache}-cache-bytes", f"{arguments.caches_mib}MiB"]
    options += ["--reply-cache-bytes", "0"]
    with Service(arguments.build, *options) as service:
        request = urllib.request.Request(service.url("/v1/meshes"), bumpy(arguments.side))
        with urllib.request.urlopen(request) as reply:
            mesh = json.load(reply)
        print(f"{mesh['vertices']} vertices; resident {resident_mb(service.pid)[0]} MB")
        mix = Mix(service, mesh, arguments, seed)
        threads = [threading.Thread(target=mix.client, args=[i]) for i in range(arguments.clients)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        time.sleep(1)
        after, most = resident_mb(service.pid)
        with urllib.request.urlopen(service.url("/v1/status")) as reply:
            held = json.load(reply)["compute"]["memory_bytes"] >> 20
        for key, count in sorted(mix.counts.items()):
            print(f"{count:6} {key[0]} {key[1]}")
    may = arguments.compute_mib + 3 * arguments.caches_mib + BESIDES
    rest = arguments.compute_mib // 4 + 3 * arguments.caches_mib + BESIDES
    print(f"resident: most {most} MB (may be {may}), afterwards {after} MB (may be {rest})")
    print(f"computations hold {held} MB afterwards")
    for wrong in mix.wrong[:10]:
        print("WRONG:", *wrong)
    failed = bool(mix.wrong) or most > may or after > rest or (200, "") not in mix.counts
    print("FAILED" if failed else "ok")
    return failed


if __name__ == "__main__":
    sys.exit(main())
