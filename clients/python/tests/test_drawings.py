"""What the server draws as .glb files, and lines on a picture."""

from __future__ import annotations

import asyncio
import io

import numpy as np
import pytest
from test_measure import areas_of_glb

import geodesicd


def test_cells_are_cut_out_of_the_surface(plane: geodesicd.Mesh) -> None:
    sites = np.random.default_rng().uniform(0, 99, (7, 3)) * [1, 1, 0]
    areas = plane.voronoi(sites, method="exact").areas
    drawn = areas_of_glb(plane.cells_glb(sites, method="exact"))
    assert len(drawn) == 7
    assert sum(made for _, made in drawn.values()) == pytest.approx(9801, rel=1e-5)
    np.testing.assert_allclose(sorted(made for _, made in drawn.values()), sorted(areas), rtol=1e-4)
    relaxed = areas_of_glb(plane.cells_glb(sites, relax=20))
    spread = [max(found.values())[0] - min(found.values())[0] for found in (drawn, relaxed)]
    assert spread[1] < spread[0]
    lines = plane.cells_glb(sites, part="bisectors")
    assert lines.startswith(b"glTF") and lines != plane.cells_glb(sites, part="delaunay")
    with pytest.raises(geodesicd.GeodesicError, match="part"):
        plane.cells_glb(sites, part="sides")


def test_discs_are_strips(plane: geodesicd.Mesh) -> None:
    strips = areas_of_glb(plane.discs_glb("p:49.5,49.5,0", [10, 30], method="exact"))
    made = sorted(area for _, area in strips.values())
    assert made[0] == pytest.approx(np.pi * 100, rel=0.01)
    assert made[1] == pytest.approx(np.pi * 800, rel=0.01)
    one = areas_of_glb(plane.discs_glb("p:49.5,49.5,0", 10, max=10, forbid="box:0,0,-1,49.5,99,1"))
    assert sum(area for _, area in one.values()) == pytest.approx(np.pi * 50, rel=0.1)


def test_a_map_has_texture_coordinates(plane: geodesicd.Mesh) -> None:
    near, far = plane.map_glb(5050, 8), plane.map_glb(5050, 20, angle=1.0)
    for drawn in (near, far):
        assert drawn.startswith(b"glTF") and b"TEXCOORD_0" in drawn
    assert len(near) < len(far)


def test_awaited_they_are_the_same(plane: geodesicd.Mesh, client: geodesicd.Client) -> None:
    async def drawn() -> list[bytes]:
        async with geodesicd.AsyncClient(client.url) as other:
            mesh = await other.mesh(plane.id)
            cells = await mesh.cells_glb([0, 99])
            return [cells, await mesh.discs_glb(0, 9), await mesh.map_glb(0, 9)]

    cells, discs, decal = asyncio.run(drawn())
    assert cells == plane.cells_glb([0, 99])
    assert discs == plane.discs_glb(0, 9)
    assert decal == plane.map_glb(0, 9)


def test_loops_and_borders_are_drawn(plane: geodesicd.Mesh) -> None:
    field = plane.distance([0, 99])
    loop = plane.loop(through=["p:20,20,0", "p:80,20,0", "p:50,80,0"])
    borders = plane.voronoi([0, 99]).bisectors

    def picture(*lines: geodesicd.Loop | geodesicd.Bisector) -> bytes:
        file = io.BytesIO()
        plane.draw(field, size=(3, 2), dpi=50, lines=lines).savefig(file, format="png")
        return file.getvalue()

    bare, looped, all_drawn = picture(), picture(loop), picture(loop, *borders)
    assert len({bare, looped, all_drawn}) == 3
