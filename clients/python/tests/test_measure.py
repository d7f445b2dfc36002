"""What geodesic discs measure: by the client, and by the command."""

from __future__ import annotations

import asyncio
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import geodesic
from numpy.typing import NDArray

import geodesicd


def test_on_a_plane_discs_are_circles(plane: geodesicd.Mesh) -> None:
    radii = np.array([30.0, 10.0, 20.0])
    found = plane.measure(5050, radii, method="exact")
    assert found.radii.tolist() == [10, 20, 30]
    r = found.radii
    np.testing.assert_allclose(found.areas, np.pi * r**2, rtol=0.004)
    np.testing.assert_allclose(found.perimeters, 2 * np.pi * r, rtol=0.004)
    np.testing.assert_allclose(found.means, 2 * r / 3, rtol=0.004)
    assert found.boundaries.tolist() == [0, 0, 0]
    assert found.lines.tolist() == found.euler.tolist() == [1, 1, 1]
    assert not found.whole.any()
    assert found.area == pytest.approx(99 * 99)
    field = plane.distance(5050, method="exact")
    assert found.max == field.max()
    assert found.farthest == field.argmax()
    assert found.vertices.tolist() == [(field <= radius).sum() for radius in r]
    for lengths in (found.areas, found.means, found.perimeters, found.boundaries):
        assert lengths.dtype == np.float64
    for counts in (found.lines, found.vertices, found.euler):
        assert counts.dtype == np.int64
    assert found.whole.dtype == np.bool_


def test_round_holes_discs_are_those_of_the_isolines(holes: geodesicd.Mesh) -> None:
    found = holes.measure([0, 99], [20, 60, 1000])
    lines = holes.isolines([0, 99], levels=[20, 60, 1000])
    for radius, perimeter, count in zip(found.radii, found.perimeters, found.lines, strict=True):
        own = [line.length for line in lines if line.level == radius]
        assert len(own) == count
        assert perimeter == pytest.approx(sum(own))
    # A plane with three holes.
    assert found.euler[2] == -2
    assert found.whole.tolist() == [False, False, True]
    assert found.areas[2] == pytest.approx(holes.area)


def test_without_radii_and_with_one(terrain: geodesicd.Mesh) -> None:
    whole = terrain.measure(9000)
    assert len(whole) == 0
    assert whole.radii.shape == (0,)
    assert whole.area == pytest.approx(terrain.area)
    near = terrain.measure(9000, 5, max=8)
    assert near.radii.tolist() == [5]
    assert near.area < whole.area
    assert near.max <= 8
    assert terrain.measure(9000, 5, max=np.inf).max == whole.max
    with pytest.raises(geodesicd.GeodesicError) as caught:
        terrain.measure(9000, [5, 9], max=8)
    assert (caught.value.code, caught.value.parameter) == ("value_out_of_range", "radii[1]")


def test_in_a_batch_and_asynchronously(
    server: geodesicd.LocalServer, plane: geodesicd.Mesh
) -> None:
    found = plane.measure(5050, [3, 5])
    (reply,) = plane.batch([{"query": "measure", "from": (50.0, 50.0, 0.0), "radii": [3, 5]}])
    assert reply.reply is not None
    assert [disc["area"] for disc in reply.reply["discs"]] == found.areas.tolist()

    async def ask() -> geodesicd.Measure:
        async with geodesicd.AsyncClient(server.url) as client:
            mesh = await client.mesh(plane.id)
            told: list[float] = []
            answer = await mesh.measure(5050, [3, 5], progress=told.append)
            assert told[-1] == 1
            return answer

    np.testing.assert_array_equal(asyncio.run(ask()).areas, found.areas)


def areas_of_glb(data: bytes) -> dict[str, tuple[float, float]]:
    """Of each node of a .glb file the area that it says, and that of its triangles."""
    (length,) = struct.unpack_from("<I", data, 12)
    document = json.loads(data[20 : 20 + length])

    def array(index: int, dtype: str) -> NDArray[Any]:
        accessor = document["accessors"][index]
        width = {"VEC3": 3, "SCALAR": 1}[accessor["type"]]
        begin = document["bufferViews"][accessor["bufferView"]].get("byteOffset", 0)
        flat = np.frombuffer(data, dtype, width * accessor["count"], 28 + length + begin)
        return flat.reshape(-1, 3)

    found = {}
    for node in document["nodes"]:
        (primitive,) = document["meshes"][node["mesh"]]["primitives"]
        positions = array(primitive["attributes"]["POSITION"], "<f4").astype(float)
        corners = positions
        if "indices" in primitive:
            corners = positions[array(primitive["indices"], "<u4").ravel()]
        a, b, c = corners.reshape(-1, 3, 3).transpose(1, 0, 2)
        area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
        found[node["name"]] = (node["extras"]["area"], float(area))
    return found


def test_the_command(server: geodesicd.LocalServer, plane: geodesicd.Mesh, tmp_path: Path) -> None:
    found = plane.measure(5050, [5, 10], method="exact")
    asked = (plane.id, "--from", "v:5050", "--radius", "10", "--radius", "5", "--method", "exact")
    run = geodesic(server, "measure", *asked)
    assert f"the farthest vertex is {found.farthest}" in run.stderr
    for ending in ("csv", "json", "glb"):
        assert not geodesic(server, "measure", *asked, "-o", tmp_path / f"discs.{ending}").stdout
    assert (tmp_path / "discs.csv").read_text() == run.stdout
    rows = np.loadtxt(run.stdout.splitlines(), delimiter=",", skiprows=1)
    np.testing.assert_allclose(rows[:, 0], [5, 10])
    np.testing.assert_allclose(rows[:, 1], found.areas, rtol=1e-6)
    np.testing.assert_array_equal(rows[:, 6], found.vertices)
    document = json.loads((tmp_path / "discs.json").read_text())
    assert [disc["area"] for disc in document["discs"]] == found.areas.tolist()
    strips = areas_of_glb((tmp_path / "discs.glb").read_bytes())
    assert list(strips)[:2] == ["strip 0 to 5", "strip 5 to 10"]
    assert strips["strip 0 to 5"][0] == pytest.approx(found.areas[0])
    for said, drawn in strips.values():
        assert said == pytest.approx(drawn, rel=1e-5)
    assert sum(said for said, _ in strips.values()) == pytest.approx(found.area)
    wrong = geodesic(server, "measure", *asked, "-o", tmp_path / "discs.obj", status=2)
    assert "should end with" in wrong.stderr
    refused = geodesic(server, "measure", plane.id, "--from", "0", "--radius", "-1", status=1)
    assert "radii" in refused.stderr
