"""Fields from curves, boundaries and whole faces."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import geodesic

import geodesicd
from geodesicd import Boundary, Curve, Faces


def test_all_sources_that_are_no_points(plane: geodesicd.Mesh) -> None:
    positions, _ = plane.geometry()
    x, y = positions[:, 0], positions[:, 1]
    from_boundary = plane.distance(Boundary(), method="exact")
    assert np.allclose(from_boundary, np.minimum.reduce([x, y, 99 - x, 99 - y]), atol=1e-9)
    assert np.array_equal(plane.distance(Boundary(0), method="exact"), from_boundary)
    assert np.array_equal(plane.distance("boundary", method="exact"), from_boundary)
    # From (10, 10) to (90, 10).
    aside = np.maximum.reduce([10 - x, x - 90, 0 * x])
    expected = np.hypot(aside, y - 10)
    curves: list[Any] = [
        Curve([1010, 1090]),
        Curve(np.array([1010, 1090])),
        "curve:v:1010;v:1090",
        {"curve": {"points": ["v:1010", {"vertex": 1090}]}},
    ]
    for curve in curves:
        assert np.allclose(plane.distance(curve, method="exact"), expected, atol=1e-9)
    field = plane.distance([Faces(np.array([0, 1])), 9999], method="exact")
    assert field[0] == field[101] == field[9999] == 0
    assert math.isclose(field[303], 2 * math.sqrt(2))


def test_loops_of_the_boundary_are_listed(plane: geodesicd.Mesh) -> None:
    assert plane.boundaries == (geodesicd.BoundaryLoop(396.0, 396, True, 0),)
    loop = plane.path(Boundary(0), 303).source
    assert loop.length == plane.boundaries[0].length


def test_paths_from_a_curve_begin_on_it(plane: geodesicd.Mesh) -> None:
    curve = Curve([(10.0, 10.0, 0.0), (90.0, 10.0, 0.0)])
    path = plane.path(curve, (40.25, 3.0, 0.0), method="exact")
    assert math.isclose(path.length, 7)
    assert path.source.kind == "curve"
    assert path.source.length is not None and math.isclose(path.source.length, 80)
    assert np.allclose(path.points[0], (40.25, 10, 0))


def test_signed_distances_are_below_0_inside(
    server: geodesicd.LocalServer, plane: geodesicd.Mesh
) -> None:
    x, y = plane.geometry()[0][:, :2].T
    # From (20, 30) to (60, 50).
    square = Curve([3020, 3060, 5060, 5020], closed=True)
    across, up = np.maximum(20 - x, x - 60), np.maximum(30 - y, y - 50)
    expected = np.where(
        np.maximum(across, up) < 0,
        np.maximum(across, up),
        np.hypot(np.maximum(across, 0), np.maximum(up, 0)),
    )
    field = plane.distance(square, signed=True, method="exact")
    assert np.allclose(field, expected, atol=1e-9)
    at = plane.distance_at(square, [(40.5, 40.5, 0.0), 0], signed=True, method="exact")
    assert np.allclose(at, [-9.5, math.hypot(20, 30)], atol=1e-9)
    with pytest.raises(geodesicd.GeodesicError, match="only the distances of one closed curve"):
        plane.distance(0, signed=True)
    told = geodesic(
        server, "distance", plane.id, "--from", "curve:closed;v:3020;v:3060;v:5060;v:5020",
        "--signed", "--at", "4040", "--method", "exact",
    ).stdout  # fmt: skip
    assert math.isclose(float(told), -10)


def test_rows_and_columns_of_tables_are_lines_too(
    server: geodesicd.LocalServer, plane: geodesicd.Mesh, tmp_path: Path
) -> None:
    rows: list[Any] = [Boundary(), Curve([1010, 1090]), Faces(np.array([0, 1])), 0]
    columns = [303, 5050]
    diagonal = math.sqrt(2)
    expected: list[list[float]] = [
        [3, 49],
        [7 * diagonal, 40],
        [2 * diagonal, 49 * diagonal],
        [3 * diagonal, 50 * diagonal],
    ]
    found = plane.table(rows, columns, method="exact")
    assert np.allclose(found, expected, atol=1e-9)
    for row, source in enumerate(rows):
        assert np.array_equal(found[row], plane.distance(source, method="exact")[columns])
    file = plane.table_file(tmp_path / "rows.npy", rows, columns, method="exact")
    assert np.array_equal(file, found)
    near = plane.sparse_table(rows, columns, max=5, method="exact")
    assert near.indptr.tolist() == [0, 1, 1, 2, 3]
    turned = plane.table(columns, rows, method="exact")
    assert np.array_equal(turned, found.T)
    square = plane.table(rows, method="exact")
    assert np.array_equal(square, square.T)
    expected = [[0, 9, 0, 0], [9, 0, 9 * diagonal, 10 * diagonal], [0, 9 * diagonal, 0, 0]]
    assert np.allclose(square[:3], expected, atol=1e-9)
    file = plane.table_file(tmp_path / "square.npy", rows, method="exact")
    assert np.array_equal(file, square)
    near = plane.sparse_table(rows, max=5, method="exact")
    assert near.indptr.tolist() == [0, 3, 4, 7, 10]
    told = geodesic(
        server, "table", plane.id, "--from", "boundary:0", "--from", "curve:v:1010;v:1090",
        "--to", "5050", "--method", "exact",
    ).stdout  # fmt: skip
    rows_told = [line.split(",") for line in told.splitlines()]
    assert [row[0] for row in rows_told] == ["", "boundary:0", "curve:v:1010;v:1090"]
    assert np.allclose([float(row[1]) for row in rows_told[1:]], [49, 40], atol=1e-9)


def test_sites_of_cells_are_lines_too(server: geodesicd.LocalServer, plane: geodesicd.Mesh) -> None:
    # Across the plane at y = 10 and y = 40.
    sites = [Curve([1000, 1099]), Curve([4000, 4099])]
    found = plane.voronoi(sites, method="exact")
    assert np.allclose(found.areas, [99 * 25, 99 * 74], atol=1e-6)
    assert [site.kind for site in found.sites] == ["curve", "curve"]
    assert np.allclose(found.bisectors[0].points[:, 1], 25, atol=1e-9)
    halves = plane.voronoi([Faces({"box": {"min": [0, 0, -1], "max": [40, 99, 1]}}), 9999])
    assert halves.areas[0] > 40 * 99
    with pytest.raises(geodesicd.GeodesicError, match="leave relax out"):
        plane.voronoi(sites, relax=1)
    told = geodesic(
        server, "voronoi", plane.id, "--from", "curve:v:1000;v:1099", "--from", "boundary",
        "--method", "exact",
    )  # fmt: skip
    areas = [float(line.split(",")[4]) for line in told.stdout.splitlines()[1:]]
    assert math.isclose(sum(areas), 9801)


def test_curves_that_are_none_are_refused_at_once() -> None:
    with pytest.raises(ValueError, match="has 2 points"):
        Curve([5])
    with pytest.raises(ValueError, match="has 3 points"):
        Curve([5, 6], closed=True)
    assert Curve([1, 2, 3], closed=True).text() == "curve:closed;v:1;v:2;v:3"
    assert Curve([1, geodesicd.Xyz((0, 0, 0), max_snap=1)]).text() is None
    assert Boundary(2).json() == {"boundary": 2}
    assert Faces({"part": 2}).text() == "part:2"


def test_the_command_takes_them_as_text(
    server: geodesicd.LocalServer, plane: geodesicd.Mesh
) -> None:
    asked = ["--from", "boundary", "--method", "exact", "--at", "303"]
    told = geodesic(server, "distance", plane.id, *asked).stdout
    assert math.isclose(float(told), 3)
