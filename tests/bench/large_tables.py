#!/usr/bin/env python3
"""A table of thousands of points on a scan, against loops over other libraries.

    large_tables.py BUILD [--peers FOLDER] [--mesh FILE] [--points N] [--peer-sources N]

A server streams the whole table to a client that keeps nothing. The others, from scripts/fetch_peers,
compute the fields of some of the sources, one after the other on one core, as a loop over them
does, and their time is scaled to all; so are their preparations, which count once. Errors are those
at the table's points, relative to exact distances that the server computes, over some of the rows.
Memory is the most that the server has had. Prints Markdown. It measures time, so it is no test.
"""

import argparse
import array
import json
import math
import os
import pathlib
import random
import subprocess
import sys
import tempfile
import time
import urllib.request

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "load"))
from service import Service

# Run in a peer's environment. Prints a line of JSON.
PEER = r"""
import json, sys, time
import numpy
sys.path.insert(0, sys.argv[1])
import peer_worker
name, folder, sources, targets = sys.argv[2], sys.argv[3], json.loads(sys.argv[4]), sys.argv[5]
try:
    positions = numpy.fromfile(folder + "/positions.f64").reshape(-1, 3)
    faces = numpy.fromfile(folder + "/faces.u32", numpy.uint32).reshape(-1, 3).astype(numpy.int64)
    targets = numpy.fromfile(targets, numpy.int64)
    # By the clock, and of processors.
    now = lambda: numpy.array([time.perf_counter(), time.process_time()])
    begin = now()
    if name == "potpourri3d_heat":
        import potpourri3d
        solver = potpourri3d.MeshHeatMethodDistanceSolver(positions, faces)
        field = solver.compute_distance
    else:
        from pygeodesic import geodesic
        solver = geodesic.PyGeodesicAlgorithmExact(positions, faces)
        field = lambda source: solver.geodesicDistances(numpy.array([source]))[0]
    field(sources[0])
    ready = now()
    rows = [numpy.asarray(field(source))[targets].tolist() for source in sources]
    end = now()
    peer_worker.ANSWERS.write(json.dumps([list(zip(ready - begin, end - ready)), rows]) + "\n")
except Exception as error:  # what a library cannot do is told
    peer_worker.ANSWERS.write(json.dumps({"failed": str(error)}) + "\n")
"""


def bumpy_sphere(rows=141, around=284):
    """Positions and faces of some 40,000 vertices, with bumps of several sizes."""
    positions, faces = [], []

    def at(polar, turn):
        size = 1 + 0.06 * math.sin(7 * polar) * math.cos(5 * turn)
        size += 0.015 * math.sin(29 * polar + 1) * math.sin(31 * turn)
        ring = size * math.sin(polar)
        return (ring * math.cos(turn), ring * math.sin(turn), size * math.cos(polar))

    for i in range(1, rows):
        for j in range(around):
            positions.append(at(math.pi * i / rows, 2 * math.pi * (j + 0.5 * (i % 2)) / around))
    for i in range(rows - 2):
        for j in range(around):
            a, b = i * around + j, i * around + (j + 1) % around
            c, d = a + around, b + around
            faces += [(a, c, b), (b, c, d)] if i % 2 else [(a, c, d), (a, d, b)]
    for begin, pole, turn in ((0, at(0, 0), False), ((rows - 2) * around, at(math.pi, 0), True)):
        for j in range(around):
            a, b = begin + j, begin + (j + 1) % around
            faces.append((len(positions), b, a) if turn else (len(positions), a, b))
        positions.append(pole)
    return positions, faces


def obj_of(positions, faces):
    """Bytes of a file."""
    lines = [f"v {x!r} {y!r} {z!r}\n" for x, y, z in positions]
    lines += [f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in faces]
    return "".join(lines).encode()


def most_memory(pid):
    """The most bytes that a process has had."""
    status = pathlib.Path(f"/proc/{pid}/status").read_text(encoding="utf-8")
    return (
        int(next(line for line in status.splitlines() if line.startswith("VmHWM")).split()[1]) << 10
    )


def processor_seconds(pid):
    """That a process has used."""
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def posted(service, target, body):
    """An open reply."""
    request = urllib.request.Request(
        service.url(target), json.dumps(body).encode(), {"Content-Type": "application/json"}
    )
    return urllib.request.urlopen(request)


def first_rows(service, mesh, asked, count):
    """The first rows of a table, as lists."""
    asked = {**asked, "rows": f"0-{count - 1}"}
    with posted(service, f"/v1/meshes/{mesh}/table", asked) as reply:
        numbers = array.array("d", reply.read())
    width = len(numbers) // count
    return [numbers[width * row : width * (row + 1)] for row in range(count)]


def errors_of(rows, exact):
    """Relative errors in percent, of what is not at the source: their mean, the 99th percentile and
    the greatest, in columns."""
    errors = sorted(
        100 * abs(a / b - 1)
        for ra, rb in zip(rows, exact)
        for a, b in zip(ra, rb)
        if 0 < b < math.inf
    )
    mean = sum(errors) / len(errors)
    return f"{mean:.3f} | {errors[len(errors) * 99 // 100]:.2f} | {errors[-1]:.1f}"


def main():
    """Measures and prints."""
    parser = argparse.ArgumentParser()
    parser.add_argument("build")
    parser.add_argument("--peers", default="build/peers")
    parser.add_argument("--mesh", help="a mesh file; else a bumpy sphere of 40,000 vertices")
    parser.add_argument("--points", type=int, default=2000)
    parser.add_argument("--peer-sources", type=int, default=12)
    parser.add_argument(
        "--methods",
        default="auto,wavefront,fast_marching,dijkstra,auto/100,wavefront/100,wavefront/150",
        help="each may have a number of landmarks behind it",
    )
    options = parser.parse_args()
    data = pathlib.Path(options.mesh).read_bytes() if options.mesh else obj_of(*bumpy_sphere())
    with Service(options.build) as service, tempfile.TemporaryDirectory() as folder:
        with urllib.request.urlopen(
            urllib.request.Request(service.url("/v1/meshes"), data)
        ) as reply:
            mesh = json.load(reply)
        with urllib.request.urlopen(
            service.url(f"/v1/meshes/{mesh['id']}/geometry?format=frame")
        ) as reply:
            frame = reply.read()
        about = json.loads(frame[24 : 24 + int.from_bytes(frame[8:12], "little")])
        for entry in about["arrays"]:
            raw = frame[entry["offset"] : entry["offset"] + entry["nbytes"]]
            if entry["name"] == "positions":
                numbers = array.array("f" if entry["dtype"] == "<f4" else "d", raw)
                pathlib.Path(f"{folder}/positions.f64").write_bytes(array.array("d", numbers))
            elif entry["name"] == "triangles":
                pathlib.Path(f"{folder}/faces.u32").write_bytes(raw)
        points = random.Random(7).sample(range(mesh["vertices"]), options.points)
        pathlib.Path(f"{folder}/points.i64").write_bytes(array.array("q", points))
        asked = {"from": [f"v:{v}" for v in points], "stream": True, "format": "f64"}
        urllib.request.urlopen(service.url(f"/v1/meshes/{mesh['id']}/distance?from=v:0&at=v:9"))
        rest = most_memory(service.pid)
        some = min(options.peer_sources, len(points))
        exact = first_rows(service, mesh["id"], {**asked, "method": "exact"}, some)
        print(f"{options.points} x {options.points} distances on {mesh['vertices']} vertices:\n")
        print(
            "| | seconds | of processors | error, %: mean | 99th percentile | greatest "
            "| quicker than potpourri3d, pygeodesic |"
        )
        print("|---|---|---|---|---|---|---|")
        others, goals = [], {}
        for name, library in (
            ("potpourri3d_heat", "potpourri3d"),
            ("pygeodesic_exact", "pygeodesic"),
        ):
            python = pathlib.Path(options.peers) / library / "bin" / "python"
            if not python.exists():
                print(f"| {library} | not there | | | | | |")
                continue
            sources = json.dumps([points[i] for i in range(some)])
            here = str(pathlib.Path(__file__).resolve().parent)
            command = [str(python), "-c", PEER, here, name, folder, sources, f"{folder}/points.i64"]
            run = subprocess.run(command, check=True, capture_output=True, text=True)
            answer = json.loads(run.stdout.splitlines()[-1])
            if isinstance(answer, dict):
                print(f"| {library} | {answer['failed']} | | | | | |")
                continue
            times, rows = answer
            whole, used = (ready + taken / len(rows) * len(points) for ready, taken in times)
            others.append((whole, used))
            error = errors_of(rows, exact)
            goals[library] = (whole, float(error.split("|")[0]))
            told = f"{whole:.0f} | {used:.0f} | {error}"
            print(f"| {library}, {name.split('_')[1]} | {told} | |")
        ours = []
        for method in options.methods.split(","):
            name, _, landmarks = method.partition("/")
            by_method = {**asked, "method": name}
            if landmarks:
                by_method["landmarks"] = int(landmarks)
            begin, used = time.perf_counter(), processor_seconds(service.pid)
            size = 0
            with posted(service, f"/v1/meshes/{mesh['id']}/table", by_method) as reply:
                while piece := reply.read(1 << 20):
                    size += len(piece)
            assert size == 8 * len(points) ** 2
            seconds, used = time.perf_counter() - begin, processor_seconds(service.pid) - used
            memory = most_memory(service.pid)
            error = errors_of(first_rows(service, mesh["id"], by_method, some), exact)
            ours.append((seconds, float(error.split("|")[0])))
            ratios = ", ".join(f"{whole / seconds:.1f}" for whole, _ in others)
            effort = ", ".join(f"{theirs / used:.1f}" for _, theirs in others)
            told = f"{seconds:.1f} | {used:.1f} | {error} | {ratios} (of processors {effort})"
            named = f"`{name}`, {landmarks} landmarks" if landmarks else f"`{name}`"
            print(f"| geodesicd, {named} | {told} |")
        # Both by a table with less error than the heat method has.
        most = goals.get("potpourri3d", (0, 0))[1]
        good = [seconds for seconds, mean in ours if mean < most]
        for library, times in (("potpourri3d", 20), ("pygeodesic", 100)):
            if library not in goals or not good:
                print(f"\nAt least {times} times as quick as {library}: not known.")
                continue
            best = goals[library][0] / min(good)
            verdict = "yes" if best >= times else "no"
            print(f"\nAt least {times} times as quick as {library}: {verdict}, {best:.1f}")
            print(f"at an error below {most:.3f} %.")
        print(f"\nThe server had {memory / 2**20:.0f} MB at most, {rest / 2**20:.0f} MB before,")
        print(f"and each table has {8 * len(points) ** 2 / 2**20:.0f} MB.")


if __name__ == "__main__":
    main()
