#!/usr/bin/env python3
"""How much sooner a server that starts again answers out of prepared files than without them.

    warm_start.py GEODESICD [--vertices N] [--rounds N]

A mesh of a million vertices is uploaded once. Then servers are started on the same store, with and without
--prepared in turn, and each is asked for the distance between two points near each other. Printed is the
median time of that first answer: with the files in the system's memory, and read from the disk (where the
system lets go of them; a virtual disk may still have them). The same question is asked again, to tell
the time of solving from that of loading; and a whole distance field, to see whether mapped arrays are slower.

Where there is an S3 server (OpenStack Swift on this machine, which shares its processors), the same is told of
a new machine, whose directory is empty: the bucket behind it has the prepared mesh.

GEODESICD_SEED=NUMBER sets the mesh; it is printed.
"""

import argparse
import os
import pathlib
import random
import re
import shutil
import statistics
import sys
import tempfile
import time

import numpy as np

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parent.parent / folder) for folder in ("crash", "s3")]

from service import Service, digest, files_below  # noqa: E402
from swift_bucket import BUCKET, KEYS, bucket  # noqa: E402


def terrain(side, seed):
    """A bumpy grid of side x side vertices as a binary PLY."""
    heights = np.random.default_rng(seed).random((side, side), dtype=np.float32)
    rows, columns = np.mgrid[0:side, 0:side].astype(np.float32)
    positions = np.stack([columns, rows, heights], axis=-1).reshape(-1, 3)
    corner = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).reshape(-1)
    triangles = np.concatenate([np.stack([corner, corner + 1, corner + side + 1], axis=1),
                                np.stack([corner, corner + side + 1, corner + side], axis=1)])
    faces = np.empty(len(triangles), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    faces["count"], faces["corners"] = 3, triangles
    head = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(positions)}\n"
            "property float x\nproperty float y\nproperty float z\n"
            f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n")
    return head.encode() + positions.tobytes() + faces.tobytes()


def let_go_of(folder):
    """Has the system forget the files' pages, as far as it will."""
    os.sync()
    for path in files_below(folder):
        with open(path, "rb") as file:
            os.posix_fadvise(file.fileno(), 0, 0, os.POSIX_FADV_DONTNEED)


def timed(server, question):
    """Seconds of an answer, and its body."""
    began = time.perf_counter()
    status, _, body = server.ask("GET", question)
    if status != 200:
        raise RuntimeError(f"{question}: {status}: {body[:300]}")
    return time.perf_counter() - began, body


def wait_until(server, metric):
    """Until a server has counted one."""
    end = time.monotonic() + 120
    while time.monotonic() < end:
        if re.search(rf"^{re.escape(metric)} 1$".encode(), server.ask("GET", "/metrics")[2], re.MULTILINE):
            return
        time.sleep(0.1)
    raise TimeoutError(f"{metric} does not become 1")


def measure_bucket(program, folder, question, rounds, endpoint):
    """First answers of a new machine's server, behind whose directory a bucket has the mesh."""
    url = f"s3://{BUCKET}/warm?endpoint={endpoint}"
    flags = ["--store", f"{folder}/store", "--log-level", "error", "--prepared-bucket", url, "--prepared"]

    def start(files):
        return Service(program, [*flags, f"{folder}/{files}"], f"{folder}/log", environment=KEYS)

    server = start("uploading")
    timed(server, question)
    wait_until(server, 'geodesicd_prepared_bucket_total{outcome="written"}')
    server.stop()
    times, fetched = [], 0
    for at in range(rounds):
        server = start(f"new_{at}")
        times.append(timed(server, question)[0])
        fetched += b'prepared_bucket_total{outcome="read"} 1\n' in server.ask("GET", "/metrics")[2]
        server.stop()
        shutil.rmtree(f"{folder}/new_{at}")
    print(f"out of the bucket, a new machine: first answer {1e3 * statistics.median(times):.0f} ms; "
          f"{fetched} of {rounds} fetched it in time")


def main():
    """Measures, prints; exits with 1 if two answers differ."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("--vertices", type=int, default=1_000_000)
    parser.add_argument("--rounds", type=int, default=5)
    arguments = parser.parse_args()
    seed = int(os.environ.get("GEODESICD_SEED") or random.randrange(1 << 32))
    print(f"GEODESICD_SEED={seed}", flush=True)
    side = max(3, round(arguments.vertices ** 0.5))
    mesh = terrain(side, seed)
    question = f"/v1/meshes/{digest(mesh)}/distance?from=v:{side + 1}&at=v:{side + 3}"
    field = f"/v1/meshes/{digest(mesh)}/distance?from=v:{side + 1}&format=f32"
    with tempfile.TemporaryDirectory() as folder:
        flags = ["--store", f"{folder}/store", "--log-level", "error"]
        kinds = {"afresh": flags, "out of files": [*flags, "--prepared", f"{folder}/files"]}

        def start(kind):
            return Service(arguments.program, kinds[kind], f"{folder}/log")

        server = start("out of files")
        assert server.ask("POST", "/v1/meshes", mesh, timeout=300)[0] == 201
        wait_until(server, 'geodesicd_prepared_writes_total{outcome="written"}')
        server.stop()
        sizes = [sum(path.stat().st_size for path in files_below(f"{folder}/{name}")) for name in ("store", "files")]
        print(f"{side * side} vertices: {sizes[0] / 1e6:.0f} MB uploaded, {sizes[1] / 1e6:.0f} MB prepared")
        answers = set()
        for place in ("in memory", "on the disk"):
            times = {kind: ([], [], []) for kind in kinds}
            for _ in range(arguments.rounds):
                for kind in kinds:
                    if place == "on the disk":
                        let_go_of(folder)
                    server = start(kind)
                    for at, what in enumerate((question, question + "&format=json", field)):
                        seconds, body = timed(server, what)
                        times[kind][at].append(seconds)
                        answers.add((at == 2, body if at == 2 else re.search(rb'"distances":\[[^]]*\]', body)[0]))
                    server.stop()
            medians = {kind: [statistics.median(of) for of in times[kind]] for kind in kinds}
            for kind, (first, again, whole) in medians.items():
                print(f"files {place}, {kind}: first answer {1e3 * first:.0f} ms, again {1e3 * again:.1f} ms, "
                      f"a whole field {1e3 * whole:.0f} ms")
            print(f"files {place}: {medians['afresh'][0] / medians['out of files'][0]:.1f} times sooner")
        with bucket() as there:
            if there is not None:
                measure_bucket(arguments.program, folder, question, arguments.rounds, there.endpoint)
        print("all answers are the same" if len(answers) == 2 else f"FAILED: {len(answers)} different answers")
    return 0 if len(answers) == 2 else 1


if __name__ == "__main__":
    sys.exit(main())
