"""Positions arrive as they are: meshes far from the origin, such as those of surveys, whose edges
float32 cannot tell apart."""

from __future__ import annotations

import asyncio
import os
import random
import warnings
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import geodesicd

Grid = tuple[NDArray[np.float64], NDArray[np.int64]]


def grid(side: int, spacing: float, origin: tuple[float, float, float]) -> Grid:
    """``side`` x ``side`` vertices in the plane z = origin[2]."""
    x, y = np.meshgrid(np.arange(side) * spacing, np.arange(side) * spacing, indexing="ij")
    vertices = np.column_stack([x.ravel(), y.ravel(), np.zeros(side * side)]) + origin
    corner = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    one = np.column_stack([corner, corner + 1, corner + side + 1])
    two = np.column_stack([corner, corner + side + 1, corner + side])
    return vertices, np.concatenate([one, two]).astype(np.int64)


@pytest.fixture
def chance() -> random.Random:
    """Numbers from $GEODESICD_SEED or, without it, others each time; a failure prints the seed."""
    seed = int(os.environ.get("GEODESICD_SEED") or random.SystemRandom().getrandbits(31))
    print(f"GEODESICD_SEED={seed}")
    return random.Random(seed)


def of_trimesh(vertices: Any, faces: Any) -> Any:
    import trimesh

    return trimesh.Trimesh(vertices, faces, process=False)


def of_pyvista(vertices: Any, faces: Any) -> Any:
    import pyvista

    return pyvista.PolyData.from_regular_faces(vertices, faces)


def of_meshio(vertices: Any, faces: Any) -> Any:
    import meshio

    return meshio.Mesh(vertices, [("triangle", faces)])


@pytest.mark.parametrize(
    "made", [lambda *arrays: arrays, of_trimesh, of_pyvista, of_meshio],
    ids=["arrays", "trimesh", "pyvista", "meshio"],
)  # fmt: skip
def test_far_from_the_origin_distances_are_euclids(
    client: geodesicd.Client, chance: random.Random, made: Any
) -> None:
    for _ in range(4):
        spacing = 10 ** chance.uniform(-3, 0)
        origin = tuple(chance.uniform(-1, 1) * 10 ** chance.uniform(3, 7) for _ in range(3))
        vertices, faces = grid(30, spacing, (origin[0], origin[1], origin[2]))
        source = chance.randrange(len(vertices))
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            mesh = client.upload(made(vertices, faces))
        assert mesh.welded_vertices == mesh.vertices == len(vertices)
        field = mesh.distance(source, method="exact")
        straight = np.linalg.norm(vertices - vertices[source], axis=1)
        np.testing.assert_allclose(field, straight, rtol=1e-9, atol=0)
        np.testing.assert_array_equal(mesh.geometry().positions, vertices)
        mesh.delete()


def test_a_survey_in_centimetres(client: geodesicd.Client) -> None:
    vertices, faces = grid(50, 0.01, (500000, 5400000, 0))
    mesh = client.upload((vertices, faces))
    assert mesh.welded_vertices == 2500
    path = mesh.path(0, 2499, method="exact", refine="shortest")
    assert path.length == pytest.approx(np.linalg.norm(vertices[-1] - vertices[0]), rel=1e-9)
    # What was rounded before it came cannot be mended, but is said.
    with pytest.warns(geodesicd.PrecisionWarning, match="make them float64") as caught:
        client.upload((vertices.astype(np.float32), faces))
    assert caught[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        coarse, faces = grid(20, 30, (500000, 5400000, 0))
        client.upload(coarse.astype(np.float32), faces)  # whole metres: as they were


def test_the_numbers_are_those_of_the_arrays(client: geodesicd.Client) -> None:
    """Also of vertices in no face, of faces without area, and of those that are there twice."""
    vertices = np.array(
        [
            [9, 9, 9],
            [0, 0, 0],
            [1, 0, 0],
            [0, 1, 0],
            [1, 1, 0],
            [1, 0, 0],
            [-0.0, 0, 0],
            [2.0, 0, 0],
        ]
    )
    vertices += (1e6 + 1e-3, 0, 0)
    faces = np.array([[1, 2, 3], [2, 2, 4], [3, 2, 4], [1, 5, 7], [1, 2, 3], [5, 7, 4]])
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # what is there twice in the arrays may be welded
        mesh = client.upload((vertices, faces))
    assert (mesh.vertices, mesh.faces, mesh.welded_vertices) == (8, 6, 6)
    found = mesh.geometry()
    np.testing.assert_array_equal(found.positions, vertices)
    np.testing.assert_array_equal(found.positions[found.triangles], vertices[faces])
    field = mesh.distance(1, method="exact")
    reached = np.array([np.inf, 0, 1, 1, 2**0.5, 1, 0, 2])
    np.testing.assert_allclose(field, reached, atol=1e-9)


def test_vertices_that_the_server_joins_are_told(client: geodesicd.Client) -> None:
    vertices, faces = grid(4, 1, (0, 0, 0))
    vertices[1] = vertices[0] + [0, 1e-300, 0]  # closer than a square of a double can say
    with pytest.warns(geodesicd.PrecisionWarning, match="joined 1 of 16 vertices.*weld='off'"):
        client.upload((vertices, faces))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        asked = client.upload((vertices, faces), weld=1e-6)  # who asks for it gets it
    assert {finding.code: finding.count for finding in asked.report}["vertices_welded"] == 1
    with pytest.warns(geodesicd.PrecisionWarning, match="joined 1 of 16 vertices"):
        client.upload((vertices, faces), weld=0)
    vertices[1] = vertices[0] + [0, 1e-4, 0]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        moved = client.upload((vertices, faces), weld=0.01)
    assert "1 vertices were moved onto others within the tolerance." in moved.warnings

    vertices[1] = vertices[0] + [0, 1e-300, 0]

    async def asynchronously() -> None:
        async with geodesicd.AsyncClient(client.url) as other:
            with pytest.warns(geodesicd.PrecisionWarning) as caught:
                await other.upload((vertices, faces))
            assert caught[0].filename == __file__

    asyncio.run(asynchronously())


def test_float32_stays_a_glb_file(client: geodesicd.Client) -> None:
    vertices, faces = grid(5, 1, (0, 0, 0))
    assert client.upload((vertices.astype(np.float32), faces)).format == "glb"
    for other in (vertices, vertices.astype(np.int32), vertices.tolist()):
        assert client.upload((other, faces.tolist())).format == "ply"
