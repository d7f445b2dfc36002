"""A boolean array of faces is of the mesh's faces, wherever it stands."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import geodesicd
from geodesicd import Costs, Faces, Mesh

Mask = np.ndarray[Any, np.dtype[np.bool_]]


def batch_of(mesh: Mesh, **query: Any) -> None:
    """One line, which has to be answered."""
    [line] = mesh.batch([query])
    assert line.error is None


# By the parameter that has the mask.
PLACES: list[tuple[str, Callable[[Mesh, Mask], Any]]] = [
    ("within", lambda mesh, mask: mesh.distance(0, within=mask)),
    ("forbid", lambda mesh, mask: mesh.distance(9999, forbid=mask)),
    ("forbid", lambda mesh, mask: mesh.distance(9999, forbid=["faces:0", mask])),
    ("forbid", lambda mesh, mask: mesh.distance(9999, forbid={"faces": mask})),
    ("weights", lambda mesh, mask: mesh.path(0, 5, costs=Costs(weights=[(2, mask)]))),
    ("from", lambda mesh, mask: mesh.distance(Faces(mask))),
    ("from", lambda mesh, mask: mesh.distance([9999, Faces({"faces": mask})], labels=True)),
    ("from", lambda mesh, mask: mesh.path(Faces(mask), 9999)),
    ("from", lambda mesh, mask: mesh.table([0, Faces(mask)], [9999])),
    ("to", lambda mesh, mask: mesh.table([9999], [0, Faces(mask)])),
    ("to", lambda mesh, mask: mesh.sparse_table([9999], [Faces(mask)])),
    ("from", lambda mesh, mask: mesh.voronoi([9999, Faces(mask)])),
    ("from", lambda mesh, mask: mesh.cells_glb([9999, Faces(mask)])),
    ("from", lambda mesh, mask: mesh.measure(Faces(mask))),
    ("from", lambda mesh, mask: mesh.isolines(Faces(mask), count=1)),
    ("from", lambda mesh, mask: mesh.samples(2, covered=Faces(mask))),
    ("within", lambda mesh, mask: mesh.distance_at(0, 1, within=mask)),
    ("within", lambda mesh, mask: mesh.nearest(0, within=mask)),
    ("within", lambda mesh, mask: mesh.trace(0, 1, angle=0, within=mask)),
    ("within", lambda mesh, mask: mesh.logmap(0, 1, within=mask)),
    ("within", lambda mesh, mask: mesh.loop(through=[0, 1, 101], within=mask)),
    ("within", lambda mesh, mask: mesh.extent("diameter", fields=1, within=mask)),
    ("within", lambda mesh, mask: mesh.picture(0, within=mask)),
    ("within", lambda mesh, mask: mesh.annotated(0, within=mask)),
    ("within", lambda mesh, mask: mesh.query("distance", {"from": 0, "within": mask})),
    ("from", lambda mesh, mask: mesh.query("distance", {"from": [Faces(mask)]})),
    ("forbid", lambda mesh, mask: mesh.paths([(9999, 9998)], forbid=mask)),
    ("within", lambda mesh, mask: batch_of(mesh, query="distance", **{"from": 0}, within=mask)),
    ("from", lambda mesh, mask: batch_of(mesh, query="distance", **{"from": Faces(mask)})),
]


@pytest.mark.parametrize("place", range(len(PLACES)))
def test_a_mask_has_an_element_for_each_face(plane: Mesh, place: int) -> None:
    name, ask = PLACES[place]
    mask = np.zeros(plane.faces, np.bool_)
    mask[:400] = True
    ask(plane, mask)
    for length in (399, plane.faces - 1, plane.faces + 1):
        with pytest.raises(ValueError, match=rf"^{name}: .*{length} elements.*19602 faces") as told:
            ask(plane, np.resize(mask, length))
        assert "vertices" not in str(told.value)
    with pytest.raises(ValueError, match=rf"^{name}: .* looks like a mask of vertices"):
        ask(plane, np.resize(mask, plane.vertices))


def test_the_way_from_vertices_to_faces_that_is_told(plane: Mesh) -> None:
    of_vertices: Any = plane.geometry().positions[:, 0] < 10.5
    with pytest.raises(ValueError, match=r"mask\[mesh.geometry\(\).triangles\].all\(axis=1\)"):
        plane.measure(0, within=of_vertices)
    of_faces = of_vertices[plane.geometry().triangles].all(axis=1)
    assert plane.measure(0, within=of_faces).area == pytest.approx(10 * 99)


def test_files_are_not_begun_with_wrong_masks(plane: Mesh, tmp_path: Path) -> None:
    wrong = np.ones(plane.vertices, np.bool_)
    with pytest.raises(ValueError, match=r"^to: .* mask of vertices"):
        plane.table_file(tmp_path / "table.npy", [0], [Faces(wrong)])
    assert not list(tmp_path.iterdir())


def test_asynchronously_too(server: geodesicd.LocalServer, plane: Mesh) -> None:
    wrong = np.ones(plane.vertices, np.bool_)

    async def ask() -> None:
        async with geodesicd.AsyncClient(server.url) as client:
            mesh = await client.mesh(plane.id)
            with pytest.raises(ValueError, match=r"^within: .* mask of vertices"):
                await mesh.distance(0, within=wrong)
            with pytest.raises(ValueError, match=r"^weights: .* mask of vertices"):
                await mesh.path(0, 1, costs=Costs(weights=[(2, wrong)]))

    asyncio.run(ask())


def test_faces_without_area_count(client: geodesicd.Client) -> None:
    """Masks are of the faces of the file, whatever becomes of them."""
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], dtype=np.float64)
    mesh = client.upload((vertices, np.array([[0, 1, 2], [1, 1, 2], [1, 3, 2]])))
    assert mesh.measure(0, within=np.array([True, True, False])).area == pytest.approx(0.5)
    with pytest.raises(ValueError, match="2 elements, and the mesh 3 faces"):
        mesh.measure(0, within=np.array([True, False]))
