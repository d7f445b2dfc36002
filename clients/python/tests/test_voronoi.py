"""Cells of the nearest site: by the client, and by the command."""

from __future__ import annotations

import asyncio
import json
from pathlib import Path

import numpy as np
import pytest
from command import geodesic
from numpy.typing import NDArray
from test_measure import areas_of_glb

import geodesicd

Float64 = NDArray[np.float64]


def half_plane(polygon: Float64, near: Float64, far: Float64) -> Float64:
    """What of a convex polygon is nearer to one point than to another."""
    excess = (polygon - (near + far) / 2) @ (far - near)
    kept = []
    for p, q, a, b in zip(
        polygon, np.roll(polygon, -1, 0), excess, np.roll(excess, -1), strict=True
    ):
        if a <= 0:
            kept.append(p)
        if (a <= 0) != (b <= 0):
            kept.append(p + a / (a - b) * (q - p))
    return np.array(kept).reshape(-1, 2)


def planar_cells(side: float, sites: Float64) -> list[Float64]:
    """The cells of a square, by half-planes cut off one after the other."""
    cells = []
    for i, site in enumerate(sites):
        cell = side * np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
        for other in np.delete(sites, i, 0):
            cell = half_plane(cell, site, other)
        cells.append(cell)
    return cells


def cross(a: Float64, b: Float64) -> Float64:
    product: Float64 = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return product


def test_on_a_plane_cells_are_those_of_half_planes(plane: geodesicd.Mesh) -> None:
    random = np.random.default_rng()
    sites = random.uniform(0, 99, (15, 3)) * [1, 1, 0]
    found = plane.voronoi(sites, method="exact")
    np.testing.assert_allclose(found.points, sites, atol=1e-9)
    for i, cell in enumerate(planar_cells(99, sites[:, :2])):
        corners = cross(cell, np.roll(cell, -1, 0)) / 2
        assert found.areas[i] == pytest.approx(corners.sum(), abs=1e-6)
        centroid = (corners[:, None] * (cell + np.roll(cell, -1, 0))).sum(0) / 3 / corners.sum()
        np.testing.assert_allclose(found.centroids[i, :2], centroid, atol=1e-6)
        outline = np.linalg.norm(np.roll(cell, -1, 0) - cell, axis=1).sum()
        assert found.perimeters[i] + found.boundaries[i] == pytest.approx(outline, abs=1e-4)
    from_sites = np.linalg.norm(found.corners[:, None] - sites[found.triangles], axis=2)
    np.testing.assert_allclose(from_sites, found.distances[:, None] * np.ones(3), atol=1e-6)
    for line in found.bisectors:
        a, b = (np.linalg.norm(line.polyline - sites[cell], axis=1) for cell in line.cells)
        np.testing.assert_allclose(a, b, atol=1e-6)
    for pair, length in zip(found.neighbors, found.lengths, strict=True):
        own = sum(line.length for line in found.bisectors if line.cells == tuple(pair))
        assert own == pytest.approx(length)
    assert found.vertices.sum() == plane.vertices
    for floats in (found.areas, found.perimeters, found.boundaries, found.lengths):
        assert floats.dtype == np.float64
    for counts in (found.vertices, found.neighbors, found.triangles):
        assert counts.dtype == np.int64


def test_cells_and_regions_are_the_same(holes: geodesicd.Mesh) -> None:
    sites = holes.samples(12).vertices
    found = holes.voronoi(sites)
    assert len(found) == 12
    assert found.areas.sum() == pytest.approx(holes.area)
    labels = holes.regions(sites)[1]
    # But for vertices that are as far from two.
    counts = np.bincount(labels[labels >= 0], minlength=12)
    assert np.abs(found.vertices - counts).max() < 30


def test_relaxed_sites_are_points_again(terrain: geodesicd.Mesh) -> None:
    found = terrain.voronoi([0, 1, 2, 3, 4], relax=30)
    assert found.areas.min() > terrain.area / 12
    again = terrain.voronoi(found.sites)
    np.testing.assert_allclose(again.areas, found.areas, rtol=1e-6)
    # Two sites in one place: the second has nothing.
    double = terrain.voronoi([7, 7])
    assert double.areas[1] == 0
    assert np.isnan(double.centroids[1]).all()
    assert double.neighbors.shape == (0, 2)
    assert double.triangles.shape == double.corners.shape == (0, 3)
    with pytest.raises(geodesicd.GeodesicError) as caught:
        terrain.voronoi(0, relax=101)
    assert (caught.value.code, caught.value.parameter) == ("too_large", "relax")


def test_in_a_batch_and_asynchronously(
    server: geodesicd.LocalServer, plane: geodesicd.Mesh
) -> None:
    found = plane.voronoi([0, 99, 5050], relax=1)
    (reply,) = plane.batch([{"query": "voronoi", "from": [0, 99, 5050], "relax": 1}])
    assert reply.reply is not None
    assert [cell["area"] for cell in reply.reply["cells"]] == found.areas.tolist()

    async def ask() -> geodesicd.Voronoi:
        async with geodesicd.AsyncClient(server.url) as client:
            mesh = await client.mesh(plane.id)
            told: list[float] = []
            answer = await mesh.voronoi([0, 99, 5050], relax=1, progress=told.append)
            assert told == sorted(told)
            assert told[-1] == 1
            return answer

    np.testing.assert_array_equal(asyncio.run(ask()).areas, found.areas)


def test_the_command(server: geodesicd.LocalServer, plane: geodesicd.Mesh, tmp_path: Path) -> None:
    found = plane.voronoi([0, 99, 9900], relax=2)
    asked = (plane.id, "--from", "0", "--from", "v:99", "--from", "9900", "--relax", "2")
    run = geodesic(server, "voronoi", *asked)
    assert "3 cells of 9801 in all, 3 pairs of neighbors, 1 triangles" in run.stderr
    for ending in ("csv", "json", "glb", "png"):
        assert not geodesic(server, "voronoi", *asked, "-o", tmp_path / f"cells.{ending}").stdout
    assert (tmp_path / "cells.csv").read_text() == run.stdout
    rows = np.loadtxt(run.stdout.splitlines(), delimiter=",", skiprows=1)
    np.testing.assert_allclose(rows[:, 1:4], found.points, rtol=1e-6)
    np.testing.assert_allclose(rows[:, 4], found.areas, rtol=1e-6)
    np.testing.assert_array_equal(rows[:, 7], found.vertices)
    document = json.loads((tmp_path / "cells.json").read_text())
    assert [cell["area"] for cell in document["cells"]] == found.areas.tolist()
    cells = areas_of_glb((tmp_path / "cells.glb").read_bytes())
    assert list(cells) == ["cell 0", "cell 1", "cell 2"]
    for said, drawn in cells.values():
        assert said == pytest.approx(drawn, rel=1e-5)
    assert (tmp_path / "cells.png").read_bytes().startswith(b"\x89PNG")
    part = ("--part", "delaunay", "-o", tmp_path / "delaunay.glb")
    geodesic(server, "voronoi", *asked, *part)
    assert b'"delaunay"' in (tmp_path / "delaunay.glb").read_bytes()
    wrong = geodesic(server, "voronoi", *asked, "--part", "cells", status=2)
    assert "--part is for" in wrong.stderr
    wrong = geodesic(server, "voronoi", *asked, "-o", tmp_path / "cells.obj", status=2)
    assert "should end with" in wrong.stderr
