#!/usr/bin/env python3
"""Runs a distance solver that is not ours, on one mesh, for geodesic_bench.

    peer_worker.py SOLVER FOLDER SOURCE

Reads FOLDER/positions.f64 (n x 3) and FOLDER/faces.u32 (m x 3). Answers on stdout,
one line each:

    ready VERSION MS    once prepared, which took so long
    (a line `solve`)    ->  MS, the time of one distance field from vertex SOURCE
    (a line `save`)     ->  saved, the last field in FOLDER/distance.f64
    failed REASON       and ends, when something cannot be done
"""

import importlib.metadata
import os
import pathlib
import sys
import time

# What libraries print must not be taken for an answer.
ANSWERS = os.fdopen(os.dup(1), "w", buffering=1)
SILENCE = os.open(os.devnull, os.O_WRONLY)
os.dup2(SILENCE, 1)
os.dup2(SILENCE, 2)


def potpourri3d_heat(positions, faces, source):
    """The heat method, on an intrinsic Delaunay triangulation."""
    import potpourri3d

    solver = potpourri3d.MeshHeatMethodDistanceSolver(positions, faces)
    return lambda: solver.compute_distance(source)


def potpourri3d_fast_marching(positions, faces, source):
    """Fast marching."""
    import potpourri3d

    solver = potpourri3d.MeshFastMarchingDistanceSolver(positions, faces)
    return lambda: solver.compute_distance([[(source, [])]])


def pygeodesic_exact(positions, faces, source):
    """Kirsanov's code of Mitchell, Mount and Papadimitriou."""
    import numpy
    from pygeodesic import geodesic

    solver = geodesic.PyGeodesicAlgorithmExact(positions, faces)
    sources = numpy.array([source])
    return lambda: solver.geodesicDistances(sources)[0]


def gdist_exact(positions, faces, source):
    """The same code in another wrapping, which prepares the mesh in each call."""
    import gdist
    import numpy

    faces = faces.astype(numpy.int32)
    sources = numpy.array([source], numpy.int32)
    return lambda: gdist.compute_gdist(positions, faces, source_indices=sources)


def libigl_exact(positions, faces, source):
    """The same code once more, which prepares the mesh in each call."""
    import igl
    import numpy

    sources = numpy.array([source])
    targets = numpy.arange(len(positions))
    none = numpy.array([], numpy.int64)
    return lambda: igl.exact_geodesic(positions, faces, sources, none, targets, none)


def libigl_heat(positions, faces, source):
    """The heat method."""
    import igl
    import numpy

    data = igl.HeatGeodesicsData()
    igl.heat_geodesics_precompute(positions, faces, data)
    sources = numpy.array([source])
    return lambda: igl.heat_geodesics_solve(data, sources)


def main():
    """Prepares, then answers until stdin ends."""
    import numpy

    name, folder, source = sys.argv[1], pathlib.Path(sys.argv[2]), int(sys.argv[3])
    positions = numpy.fromfile(folder / "positions.f64").reshape(-1, 3)
    faces = numpy.fromfile(folder / "faces.u32", "<u4").reshape(-1, 3).astype(numpy.int64)
    prepare = globals()[name]
    package = name.split("_")[0]
    __import__({"libigl": "igl"}.get(package, package))
    start = time.perf_counter()
    solve = prepare(positions, faces, source)
    took = 1000 * (time.perf_counter() - start)
    print("ready", importlib.metadata.version(package), took, file=ANSWERS)
    distance = None
    for line in sys.stdin:
        if line == "solve\n":
            start = time.perf_counter()
            distance = solve()
            print(1000 * (time.perf_counter() - start), file=ANSWERS)
        elif line == "save\n":
            values = numpy.asarray(distance, "<f8").reshape(-1)
            if len(values) != len(positions):
                raise ValueError(f"{len(values)} distances for {len(positions)} vertices")
            values.tofile(folder / "distance.f64")
            print("saved", file=ANSWERS)


if __name__ == "__main__":
    try:
        main()
    except Exception as error:  # whatever a library raises
        print("failed", type(error).__name__, str(error).replace("\n", " "), file=ANSWERS)
        sys.exit(1)
