"""Closed curves: by the client, and by the command."""

from __future__ import annotations

import asyncio
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import geodesic
from numpy.typing import NDArray

import geodesicd


def prism(sides: int, rows: int) -> tuple[NDArray[Any], NDArray[Any]]:
    """An open tube of radius 1 about z, of ``sides`` sides, from 0 to ``rows``."""
    turn = 2 * np.pi * np.arange(sides) / sides
    ring = np.stack([np.cos(turn), np.sin(turn), np.zeros(sides)], axis=1)
    vertices = np.concatenate([ring + np.array([0, 0, row]) for row in range(rows + 1)])
    faces = []
    for row in range(rows):
        for i in range(sides):
            a, b = row * sides + i, row * sides + (i + 1) % sides
            faces += [[a, b, b + sides], [a, b + sides, a + sides]]
    return vertices, np.array(faces)


@pytest.fixture(scope="module")
def tube(client: geodesicd.Client) -> geodesicd.Mesh:
    return client.upload(prism(9, 6))


ROUND = 18 * np.sin(np.pi / 9)  # a ring of that tube


def test_a_band_round_a_prism(tube: geodesicd.Mesh) -> None:
    found = tube.loop(at=29, normal=(0.3, 0.1, 1))
    assert found.length == pytest.approx(ROUND)
    assert found.start_length > found.length
    assert (found.start, found.geodesic, found.hull, found.method) == ("plane", True, False, None)
    assert found.turn is not None
    assert found.turn < 1e-4
    np.testing.assert_array_equal(found.points[0], found.points[-1])
    assert found.along[-1] == pytest.approx(found.length)
    assert [point.vertex for point in found.asked] == [29]
    around = tube.loop(around=[0, 30, 60], method="exact")
    assert around.length == pytest.approx(ROUND)
    assert (around.start, around.geodesic, around.method) == ("around", True, "exact")
    tape = tube.loop(at=29, normal=(0, 0, 1), hull=True)
    assert tape.length == pytest.approx(ROUND)
    assert (tape.hull, tape.turn, tape.geodesic) == (True, None, False)


def test_a_triangle_through_points_of_a_plane(plane: geodesicd.Mesh) -> None:
    found = plane.loop(through=[0, 99, 9900], method="exact")
    assert found.length == pytest.approx(99 * (2 + np.sqrt(2)))
    assert found.length == found.start_length
    assert found.turn == pytest.approx(135)
    assert not found.geodesic
    assert [point.vertex for point in found.asked] == [0, 99, 9900]


def test_what_is_no_loop(plane: geodesicd.Mesh, tube: geodesicd.Mesh) -> None:
    with pytest.raises(geodesicd.GeodesicError, match="contracts to a point") as caught:
        plane.loop(around=[0, 99, 9900])
    assert (caught.value.code, caught.value.parameter) == ("no_loop", "around")
    with pytest.raises(geodesicd.GeodesicError, match="the boundary") as caught:
        tube.loop(at=29, normal=(1, 0, 0))
    assert (caught.value.code, caught.value.parameter) == ("no_loop", "normal")
    with pytest.raises(geodesicd.GeodesicError) as caught:
        plane.loop(through=[0])
    assert (caught.value.code, caught.value.parameter) == ("value_out_of_range", "through")
    with pytest.raises(ValueError, match="normal"):
        tube.loop(at=29, normal=(1, 0))


def test_asynchronously(server: geodesicd.LocalServer, tube: geodesicd.Mesh) -> None:
    async def ask() -> geodesicd.Loop:
        async with geodesicd.AsyncClient(server.url) as client:
            mesh = await client.mesh(tube.id)
            told: list[float] = []
            answer = await mesh.loop(at=29, normal=(0.3, 0.1, 1), progress=told.append)
            assert told[-1] == 1
            return answer

    found = tube.loop(at=29, normal=(0.3, 0.1, 1))
    np.testing.assert_array_equal(asyncio.run(ask()).points, found.points)


def test_the_command(server: geodesicd.LocalServer, tube: geodesicd.Mesh, tmp_path: Path) -> None:
    asked = ("--at", "29", "--normal", "0.3,0.1,1")
    found = tube.loop(at=29, normal=(0.3, 0.1, 1))
    for ending in ("csv", "npy", "json", "glb"):
        file = tmp_path / f"loop.{ending}"
        run = geodesic(server, "loop", tube.id, *asked, "-o", file)
        assert float(run.stdout) == pytest.approx(found.length)
        assert "a closed geodesic; " in run.stderr
    np.testing.assert_array_equal(np.load(tmp_path / "loop.npy"), found.points)
    rows = np.loadtxt(tmp_path / "loop.csv", delimiter=",", skiprows=1)
    np.testing.assert_allclose(rows[:, :3], found.points, atol=1e-9)
    assert json.loads((tmp_path / "loop.json").read_text())["faces"] == found.faces.tolist()
    assert (tmp_path / "loop.glb").read_bytes()[:4] == b"glTF"
    through = ("--through", "0", "--through", "30", "--method", "exact")
    run = geodesic(server, "loop", tube.id, *through)
    assert float(run.stdout) == pytest.approx(tube.loop(through=[0, 30], method="exact").length)
    assert "no closed geodesic, " in run.stderr
    tape = geodesic(server, "loop", tube.id, "--at", "29", "--normal", "0,0,1", "--hull")
    assert float(tape.stdout) == pytest.approx(ROUND)
    refused = geodesic(server, "loop", tube.id, "--at", "29", "--normal", "1,0,0", status=1)
    assert "boundary" in refused.stderr
    wrong = geodesic(server, "loop", tube.id, "--at", "29", "--normal", "up", status=2)
    assert "three numbers" in wrong.stderr
