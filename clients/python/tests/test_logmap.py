"""The surface round a point laid into the plane: by the client, and by the command."""

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
from geodesicd.bench.mixes import hills
from geodesicd.points import PointLike


def plane_of(pairs: NDArray[Any]) -> NDArray[Any]:
    """Places in a plane, (n, 2), as complex numbers: what turns all of them multiplies them."""
    return np.asarray(pairs[:, 0] + 1j * pairs[:, 1])


@pytest.mark.parametrize(
    ("point", "turns"),
    [(5050, 1), ((40.3, 60.2, 0.0), 1), ((50.5, 50.0, 0.0), 1), (0, 0.25), (70, 0.5)],
)
def test_on_a_plane_it_is_the_plane_turned(
    plane: geodesicd.Mesh, point: PointLike, turns: float
) -> None:
    found = plane.logmap(point, 9, method="exact")
    there = plane.geometry().positions[found.vertices] - found.source.xyz
    asked, laid = plane_of(there), plane_of(found.coordinates)
    far = np.abs(asked).argmax()
    turn = laid[far] / asked[far]
    assert abs(turn) == pytest.approx(1)
    np.testing.assert_allclose(laid, turn * asked, atol=1e-9)
    assert found.straight.any()
    assert (found.method, found.angle, found.radius) == ("exact", 0, 9)
    assert found.all_round == (turns == 1)
    assert found.total_angle == pytest.approx(turns * 2 * np.pi)
    # The same with another direction as the x axis.
    other = plane.logmap(point, 9, angle=0.7, method="exact")
    assert other.angle == 0.7
    np.testing.assert_array_equal(other.angles, found.angles)
    np.testing.assert_allclose(plane_of(other.coordinates), laid * np.exp(-0.7j), atol=1e-9)


def test_its_arrays(plane: geodesicd.Mesh) -> None:
    found = plane.logmap(5050, 4)
    count = len(found)
    assert count == len(found.vertices) > 40
    assert found.vertices.dtype == np.int64
    assert found.straight.dtype == np.bool_
    for array in (found.distances, found.angles, found.coordinates):
        assert array.dtype == np.float64
    shapes = {a.shape for a in (found.vertices, found.distances, found.angles, found.straight)}
    assert shapes == {(count,)}
    assert found.coordinates.shape == (count, 2)
    assert (np.diff(found.vertices) > 0).all()
    assert found.source.vertex == 5050
    own = found.vertices == 5050
    assert found.coordinates[own].tolist() == [[0, 0]]
    np.testing.assert_allclose(np.linalg.norm(found.coordinates, axis=1), found.distances)


@pytest.mark.parametrize("place", ["vertex", "face"])
def test_going_straight_ahead_is_the_inverse(client: geodesicd.Client, place: str) -> None:
    mesh = client.upload(hills(20, 3))
    positions = mesh.geometry().positions
    point: PointLike = 190 if place == "vertex" else geodesicd.OnFace(300, (0.2, 0.3, 0.5))
    found = mesh.logmap(point, method="exact")
    size = float(np.linalg.norm(np.ptp(positions, axis=0)))
    ends = np.array([
        mesh.trace(point, d, angle=a).points[-1]
        for a, d in zip(found.angles, found.distances, strict=True)
    ])  # fmt: skip
    off = np.linalg.norm(ends - positions[found.vertices], axis=1)
    assert found.straight.sum() > 100
    assert off[found.straight].max() < 1e-6 * size


def test_round_a_hole_paths_are_not_straight(holes: geodesicd.Mesh) -> None:
    found = holes.logmap(0, method="exact")
    chosen = np.random.default_rng(7).permutation(len(found))[:60]
    positions = holes.geometry().positions
    ends = np.array([
        holes.trace(0, found.distances[i], angle=found.angles[i]).points[-1] for i in chosen
    ])  # fmt: skip
    off = np.linalg.norm(ends - positions[found.vertices[chosen]], axis=1)
    straight = found.straight[chosen]
    assert straight.any()
    assert not straight.all()
    assert off[straight].max() < 1e-6
    # What is not seen from vertex 0, at 0, 0, 0, is farther than it is in space.
    around = found.distances > np.linalg.norm(positions[found.vertices], axis=1) + 1e-6
    assert around.any()
    assert not found.straight[around].any()


def test_a_radius_limits_the_vertices(terrain: geodesicd.Mesh) -> None:
    field = terrain.distance(9000, method="exact", max=20)
    for radius in (0.5, 3.0, 7.25):
        found = terrain.logmap(9000, radius, method="exact")
        np.testing.assert_array_equal(found.vertices, np.flatnonzero(field <= radius))
        np.testing.assert_allclose(found.distances, field[found.vertices], rtol=1e-6)
        assert found.radius == radius


def test_without_a_radius_it_goes_as_far_as_paths_do(client: geodesicd.Client) -> None:
    vertices = np.array([[0, 0, 0], [3, 0, 0], [0, 4, 0], [5, 0, 0], [6, 0, 0], [5, 1, 0]], float)
    mesh = client.upload((vertices, np.array([[0, 1, 2], [3, 4, 5]])))
    for radius in (None, np.inf):
        found = mesh.logmap(0, radius)
        assert found.vertices.tolist() == [0, 1, 2]
        assert found.distances.tolist() == [0, 3, 4]
        assert found.radius == 4
    for refused in (0, -1):
        with pytest.raises(geodesicd.GeodesicError) as caught:
            mesh.logmap(0, refused)
        assert (caught.value.code, caught.value.parameter) == ("value_out_of_range", "radius")


def test_where_directions_have_no_angle(client: geodesicd.Client) -> None:
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]], float)
    book = client.upload((vertices, np.array([[0, 1, 2], [0, 1, 3], [0, 1, 4]])))
    with pytest.raises(geodesicd.GeodesicError) as caught:
        book.logmap((0.5, 0.0, 0.0))
    assert (caught.value.code, caught.value.parameter) == ("value_out_of_range", "from")
    assert len(book.logmap((0.2, 0.2, 0.0))) == 5


def test_a_direction_carried_over_a_plane_is_the_x_axis(plane: geodesicd.Mesh) -> None:
    found = plane.logmap(5050, 5, angle=0.4, transport=True, method="exact")
    assert found.directions is not None
    assert found.directions.shape == (len(found), 3)
    there = plane.geometry().positions[found.vertices] - found.source.xyz
    along = (there * found.directions).sum(1)
    np.testing.assert_allclose(along, found.coordinates[:, 0], atol=1e-9)
    np.testing.assert_allclose(found.directions - found.directions[0], 0, atol=1e-9)
    assert plane.logmap(5050, 5).directions is None


def test_in_a_batch_and_asynchronously(
    server: geodesicd.LocalServer, plane: geodesicd.Mesh
) -> None:
    found = plane.logmap(5050, 3)
    line = {"query": "logmap", "from": (50.0, 50.0, 0.0), "radius": 3}
    (reply,) = plane.batch([line])
    assert reply.reply is not None
    assert reply.reply["coordinates"] == found.coordinates.tolist()

    async def ask() -> geodesicd.Logmap:
        async with geodesicd.AsyncClient(server.url) as client:
            mesh = await client.mesh(plane.id)
            told: list[float] = []
            answer = await mesh.logmap(5050, 3, progress=told.append)
            assert told[-1] == 1
            return answer

    np.testing.assert_array_equal(asyncio.run(ask()).coordinates, found.coordinates)


def read_glb(data: bytes) -> dict[str, NDArray[np.float32]]:
    """The attributes of the one primitive of a .glb file."""
    (length,) = struct.unpack_from("<I", data, 12)
    document = json.loads(data[20 : 20 + length])
    ((primitive,),) = [mesh["primitives"] for mesh in document["meshes"]]
    found = {}
    for name, index in primitive["attributes"].items():
        accessor = document["accessors"][index]
        begin = document["bufferViews"][accessor["bufferView"]].get("byteOffset", 0)
        width = int(accessor["type"].removeprefix("VEC"))
        flat = np.frombuffer(data, "<f4", width * accessor["count"], 28 + length + begin)
        found[name] = flat.reshape(-1, width)
    return found


def test_as_glb_it_has_texture_coordinates(plane: geodesicd.Mesh) -> None:
    data = plane.query("logmap", {"from": 5050, "radius": 5}, format="glb").data
    attributes = read_glb(data)
    found = plane.logmap(5050, 5)
    positions = plane.geometry().positions[found.vertices]
    np.testing.assert_array_equal(attributes["POSITION"], positions)
    # The square from 0 to 1 is the one about the circle of the radius, with v downwards.
    laid = (attributes["TEXCOORD_0"] - 0.5) * [10, -10]
    np.testing.assert_allclose(laid, found.coordinates, atol=1e-5)


def test_the_command(server: geodesicd.LocalServer, plane: geodesicd.Mesh, tmp_path: Path) -> None:
    found = plane.logmap(5050, 3, angle=0.5, method="exact")
    asked = (plane.id, "--from", "v:5050", "--radius", "3", "--angle", "0.5", "--method", "exact")
    printed = geodesic(server, "logmap", *asked).stdout
    for ending in ("csv", "npz", "json", "glb"):
        run = geodesic(server, "logmap", *asked, "-o", tmp_path / f"map.{ending}")
        assert f"map.{ending}" in run.stderr
        assert not run.stdout
    assert (tmp_path / "map.csv").read_text() == printed
    rows = np.loadtxt(printed.splitlines(), delimiter=",", skiprows=1)
    np.testing.assert_array_equal(rows[:, 0], found.vertices)
    np.testing.assert_allclose(rows[:, 4:], found.coordinates, rtol=1e-6, atol=1e-6)
    arrays = np.load(tmp_path / "map.npz")
    document = json.loads((tmp_path / "map.json").read_text())
    assert set(arrays) == set(document)
    for name in ("vertices", "distances", "angles", "straight", "coordinates"):
        np.testing.assert_array_equal(arrays[name], getattr(found, name))
        np.testing.assert_allclose(document[name], getattr(found, name), rtol=1e-6, atol=1e-6)
    assert (document["radius"], document["angle"], document["all_round"]) == (3, 0.5, True)
    assert float(arrays["total_angle"]) == found.total_angle
    assert (tmp_path / "map.glb").read_bytes().startswith(b"glTF")
    carried = geodesic(server, "logmap", *asked, "--transport").stdout
    assert carried.startswith("vertex,distance,angle,straight,x,y,dx,dy,dz\n")
    geodesic(server, "logmap", *asked, "--transport", "-o", tmp_path / "carried.npz")
    assert np.load(tmp_path / "carried.npz")["directions"].shape == (len(found), 3)
    wrong = geodesic(server, "logmap", *asked, "-o", tmp_path / "map.obj", status=2)
    assert "should end with" in wrong.stderr
    refused = geodesic(server, "logmap", plane.id, "--from", "0", "--radius", "0", status=1)
    assert "radius" in refused.stderr
