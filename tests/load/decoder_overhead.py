#!/usr/bin/env python3
"""decoder_overhead.py BUILD: what it costs to decode files in processes of their own.

Uploads small and large files by turns to two servers, one with --decoder process and one with
--decoder in-process, each file another one, and compares how long uploads take: for the
small ones in milliseconds, for the large ones in per cent. Exit status 1 if a bound is missed."""

import argparse
import http.client
import json
import pathlib
import statistics
import struct
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

from service import Checks, Service  # noqa: E402

SMALL_MS, LARGE_PERCENT = 3.0, 15.0


def grid(side, height):
    """A GLB of a wavy plane of side x side vertices; another one for each `height`."""
    positions = bytearray()
    for row in range(side):
        for column in range(side):
            z = height * ((row * 7 + column * 13) % 10)
            positions += struct.pack("<3f", column, row, z)
    indices = bytearray()
    for row in range(side - 1):
        first = row * side
        indices += b"".join(
            struct.pack("<6I", at, at + 1, at + side, at + 1, at + side + 1, at + side)
            for at in range(first, first + side - 1)
        )
    count = side * side
    document = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": len(positions) + len(indices)}],
        "bufferViews": [
            {"buffer": 0, "byteLength": len(positions)},
            {"buffer": 0, "byteOffset": len(positions), "byteLength": len(indices)},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3",
             "min": [0, 0, 0], "max": [side - 1, side - 1, 9 * height]},
            {"bufferView": 1, "componentType": 5125, "count": 6 * (side - 1) ** 2,
             "type": "SCALAR"},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
    }  # fmt: skip
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    body = struct.pack("<2I", len(text), 0x4E4F534A) + text
    binary = bytes(positions + indices)
    body += struct.pack("<2I", len(binary), 0x004E4942) + binary
    return struct.pack("<3I", 0x46546C67, 2, 12 + len(body)) + body


def upload_ms(connection, file):
    """Milliseconds until the reply is there."""
    begun = time.perf_counter()
    connection.request("POST", "/v1/meshes", file)
    reply = connection.getresponse()
    text = reply.read()
    took = 1000 * (time.perf_counter() - begun)
    if reply.status != 201:
        raise RuntimeError(f"{reply.status}: {text[:500]!r}")
    return took


def compare(servers, side, rounds, height):
    """The median time of an upload to each server, the files taken by turns."""
    connections = [http.client.HTTPConnection("127.0.0.1", one.port) for one in servers]
    times = [[] for _ in servers]
    for turn in range(rounds):
        for which in range(len(servers)):
            file = grid(side, height + 1e-4 * (2 * turn + which))
            # Who goes first alternates.
            at = (which + turn) % 2
            times[at].append(upload_ms(connections[at], file))
    return [statistics.median(some) for some in times]


def main():
    """Prints a line a size."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--rounds", type=int, default=40)
    parser.add_argument("--large", type=int, default=1000, help="side of the large plane")
    parser.add_argument("--slack", type=float, default=1, help="bounds times this")
    args = parser.parse_args()
    with Service(args.build, "--decoder", "process") as apart:
        with Service(args.build, "--decoder", "in-process") as inside:
            compare((apart, inside), 12, 5, 0.5)
            small = compare((apart, inside), 12, args.rounds, 0.1)
            large = compare((apart, inside), args.large, max(3, args.rounds // 8), 0.1)
    print(f"144 vertices: {small[0]:.2f} ms, {small[1]:.2f} in-process")
    print(f"{args.large**2} vertices: {large[0]:.0f} ms, {large[1]:.0f} in-process")
    checks = Checks(args.slack)
    checks.at_most("more for a small file", small[0] - small[1], SMALL_MS)
    checks.at_most("more for a large one", 100 * (large[0] / large[1] - 1), LARGE_PERCENT, "%")
    sys.exit(1 if checks.failed else 0)


if __name__ == "__main__":
    main()
