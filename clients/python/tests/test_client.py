"""The client against a real server: results that are known in closed form, and all the ways in
which a mesh comes in."""

from __future__ import annotations

import asyncio
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import geodesicd
from geodesicd.bench.mixes import hills


def test_a_field_on_a_plane_is_euclids(plane: geodesicd.Mesh) -> None:
    field = plane.distance(0, method="exact")
    positions = plane.geometry().positions
    assert field.shape == (10000,)
    assert field.dtype == np.float64
    np.testing.assert_allclose(field, np.linalg.norm(positions, axis=1), rtol=1e-9, atol=1e-9)
    assert plane.distance(0, dtype=np.float32).dtype == np.float32
    with pytest.raises(ValueError, match="float16"):
        plane.distance(0, dtype=np.float16)


def test_a_quantised_field_is_within_its_step(plane: geodesicd.Mesh) -> None:
    exact = plane.distance(0, max=50)
    quantised = plane.distance(0, max=50, quantised=True)
    assert quantised.dtype == np.float32
    np.testing.assert_array_equal(np.isinf(quantised), np.isinf(exact))
    reached = np.isfinite(exact)
    np.testing.assert_allclose(quantised[reached], exact[reached], atol=50 / 65534)


def test_labels_are_the_nearest_source(plane: geodesicd.Mesh) -> None:
    distances, labels = plane.distance([0, 99], labels=True)
    x = plane.geometry().positions[:, 0]
    assert labels.dtype == np.int64
    assert (labels[x < 49] == 0).all()
    assert (labels[x > 50] == 1).all()
    near = plane.regions(0, max=10)
    assert set(near.labels.tolist()) == {-1, 0}
    np.testing.assert_array_equal(near.labels == -1, np.isinf(near.distances))
    assert distances[99] == 0


def test_offsets_start_a_front_later(plane: geodesicd.Mesh) -> None:
    field = plane.distance([geodesicd.Vertex(0, offset=2.5)], method="exact")
    np.testing.assert_allclose(field, plane.distance(0, method="exact") + 2.5)


def test_path_distance_and_table_agree(plane: geodesicd.Mesh) -> None:
    table = plane.table([0, 5050], [9999, (20.0, 30.0, 4.0)], method="exact")
    assert table.shape == (2, 2)
    assert table[1, 0] == pytest.approx(np.hypot(49, 49))
    path = plane.path(5050, 9999, method="exact", refine="shortest")
    assert path.length == pytest.approx(table[1, 0])
    assert path.along[-1] == pytest.approx(path.length)
    at = plane.distance_at(0, [9999, (20.0, 30.0, 4.0)], method="exact")
    np.testing.assert_allclose(at, table[0], rtol=1e-9)
    with pytest.raises(ValueError, match="at least one"):
        plane.distance_at(0, [])


def test_a_path_is_on_its_faces(holes: geodesicd.Mesh) -> None:
    path = holes.path(0, 9999, refine="shortest")
    positions, triangles = holes.geometry()
    assert path.points.dtype == np.float64
    assert path.faces.dtype == np.int64
    corners = positions[triangles[path.faces]]
    np.testing.assert_allclose(
        (path.bary[:, :, None] * corners).sum(axis=1), path.points, atol=1e-9
    )


def test_what_is_not_said_is_the_servers_to_decide(plane: geodesicd.Mesh) -> None:
    asked: list[str] = []
    hooks = plane.client._http.event_hooks["request"]
    hooks.append(lambda request: asked.append(f"{request.url} {request.read().decode()}"))
    try:
        path = plane.path(0, 50)
        (same,) = plane.paths([(0, 50)])
        plane.distance(0)
        plane.table([0, 1])
    finally:
        hooks.clear()
    assert not [one for one in asked if "method" in one or "refine" in one]
    assert (path.method, path.refine) == (same.method, same.refine)
    assert path.method in [method["name"] for method in plane.client.methods()]
    assert plane.path(0, 50, refine="none").refine == "none"


def test_a_result_is_a_point_again(plane: geodesicd.Mesh) -> None:
    found = plane.nearest([(3.25, 4.5, 2.0), geodesicd.Ray((7.5, 8.25, 9), (0, 0, -1)), 12])
    assert [p.snap_distance for p in found] == [2, 0, 0]
    assert found[1].ray_distance == 9
    assert plane.distance_at(found[0], found[1:2], method="exact")[0] == pytest.approx(
        np.hypot(4.25, 3.75)
    )


def test_a_thousand_paths_are_one_request(plane: geodesicd.Mesh) -> None:
    sent: list[str] = []
    plane.client._http.event_hooks["request"].append(lambda request: sent.append(request.method))
    try:
        pairs = [(0, target) for target in range(1000)]
        paths = plane.paths(pairs, method="exact")
    finally:
        plane.client._http.event_hooks["request"].clear()
    assert sent == ["POST"]
    x, y = np.divmod(np.arange(1000), 100)
    np.testing.assert_allclose([path.length for path in paths], np.hypot(x, y), atol=1e-9)
    assert [path.target.vertex for path in paths] == list(range(1000))


def test_one_bad_pair_is_named(plane: geodesicd.Mesh) -> None:
    with pytest.raises(geodesicd.GeodesicError) as caught:
        plane.paths([(0, 1), (0, 77777)])
    assert caught.value.parameter == "pairs[1].to"
    assert caught.value.actual == 77777
    assert caught.value.limit == 9999
    assert pickle.loads(pickle.dumps(caught.value)).limit == 9999


def test_paths_take_what_a_path_takes(plane: geodesicd.Mesh) -> None:
    pairs = [(0, 5050), (3, 99)]
    steiner: dict[str, Any] = {"method": "steiner", "points_per_edge": 1, "tolerance": 1e-6}
    upper: dict[str, Any] = {"method": "auto", "bound": "upper", "deadline": 60}
    for options in (steiner, {**steiner, "points_per_edge": 9}, upper):
        lengths = [path.length for path in plane.paths(pairs, refine="none", **options)]
        alone = [plane.path(*pair, refine="none", **options).length for pair in pairs]
        assert lengths == pytest.approx(alone, rel=1e-12)
    with pytest.raises(TypeError, match=r"paths\(\) got an unexpected keyword argument 'bounds'"):
        plane.paths(pairs, bounds="upper")  # type: ignore[call-arg]


def test_a_deadline_of_paths_is_for_all_of_them(
    plane: geodesicd.Mesh, terrain: geodesicd.Mesh, monkeypatch: pytest.MonkeyPatch
) -> None:
    pairs = [(source, 30000 - source) for source in range(200)]
    with pytest.raises(geodesicd.DeadlineExceeded) as caught:
        terrain.paths(pairs, method="chen_han", deadline=0.05)
    assert caught.value.parameter is None
    monkeypatch.setattr(geodesicd.batches, "_LARGEST", 200)
    asked: list[int] = []
    hooks = plane.client._http.event_hooks["request"]
    hooks.append(lambda request: asked.append(int(request.url.params["deadline_ms"])))
    try:
        paths = plane.paths([(0, target) for target in range(9)], deadline=60)
    finally:
        hooks.clear()
    assert [path.length for path in paths] == list(range(9))
    assert len(asked) > 1
    assert 60_000 >= asked[0] >= asked[-1] > 0


def test_a_large_batch_is_cut(plane: geodesicd.Mesh, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(geodesicd.batches, "_LARGEST", 200)
    told: list[float] = []
    paths = plane.paths([(0, target) for target in range(9)], progress=told.append)
    assert [path.length for path in paths] == list(range(9))
    assert told == sorted(told)
    assert told[-1] == pytest.approx(1)


def test_isolines_of_a_plane_are_arcs(plane: geodesicd.Mesh) -> None:
    lines = plane.isolines(0, levels=np.array([20.0, 40.0]), method="exact")
    assert [line.level for line in lines] == [20, 40]
    assert lines[0].length == pytest.approx(np.pi * 10, rel=1e-3)
    ring = plane.isolines(5050, step=10, max=10)[0]
    assert ring.closed
    assert len(ring.polyline) == len(ring.points) + 1


def test_samples_cover(plane: geodesicd.Mesh) -> None:
    samples = plane.samples(9)
    assert samples.radii[0] == np.inf
    assert (np.diff(samples.radii[1:]) <= 0).all()
    farthest = plane.distance(samples.vertices).max()
    assert farthest == pytest.approx(samples.covering_radius, rel=1e-6)


def test_straight_ahead(plane: geodesicd.Mesh) -> None:
    trace = plane.trace(0, 200, direction=(2, 1, 0))
    assert trace.end == "boundary"
    np.testing.assert_allclose(trace.points[-1], [99, 49.5, 0], atol=1e-9)


def test_components_apart(client: geodesicd.Client) -> None:
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [5, 0, 0], [6, 0, 0], [5, 1, 0]])
    mesh = client.upload((vertices, np.array([[0, 1, 2], [3, 4, 5]])))
    path = mesh.path(0, 4)
    assert (path.reachable, path.length, path.points.shape) == (False, np.inf, (0, 3))
    assert mesh.distance(0).tolist() == [0, 1, 1, np.inf, np.inf, np.inf]
    assert mesh.table([0], [3]).tolist() == [[np.inf]]
    assert mesh.components == 2


def test_pictures_and_files(plane: geodesicd.Mesh, samples: Path) -> None:
    assert plane.picture(0, width=64, height=64).startswith(b"\x89PNG")
    assert plane.picture(0, 9999, via=[5050], width=64, height=64, view=(10, 20))[:4] == b"\x89PNG"
    assert plane.source() == (samples / "plane.glb").read_bytes()
    assert plane.geometry_glb().startswith(b"glTF")
    with pytest.raises(ValueError, match="one source"):
        plane.picture([0, 1], 2)
    of_path: list[dict[str, Any]] = [{"via": [5]}, {"via": np.array([5])}, {"refine": "none"}]
    for options in of_path:
        with pytest.raises(ValueError, match="give a target"):
            plane.picture(0, **options)


def test_every_way_in_is_the_same_mesh(client: geodesicd.Client) -> None:
    import meshio
    import pyvista
    import trimesh

    vertices, faces = hills(12, 3)
    arrays = client.upload((vertices, faces))
    for mesh in (
        trimesh.Trimesh(vertices, faces, process=False),
        pyvista.PolyData.from_regular_faces(vertices, faces),
        meshio.Mesh(vertices, [("triangle", faces)]),
        geodesicd.ply_bytes(vertices, faces),
    ):
        assert client.upload(mesh).id == arrays.id
    assert client.upload(vertices, faces).id == arrays.id
    with pytest.raises(TypeError, match="vertices alone"):
        client.upload(vertices)
    np.testing.assert_array_equal(arrays.geometry().triangles, faces)
    np.testing.assert_array_equal(arrays.geometry().positions, vertices)
    rounded = client.upload(geodesicd.glb_bytes(vertices, faces))
    assert client.upload((vertices.astype(np.float32), faces)).id == rounded.id
    np.testing.assert_array_equal(rounded.geometry().positions, vertices.astype(np.float32))
    quads = meshio.Mesh([[0, 0], [1, 0], [1, 1], [0, 1]], [("quad", [[0, 1, 2, 3]])])
    assert client.upload(quads).area == 1
    square = pyvista.Plane(i_resolution=2, j_resolution=2)  # quads, which are cut
    assert client.upload(square).faces == 8


@pytest.mark.parametrize(
    ("vertices", "faces", "what"),
    [
        ([[0, 0], [1, 1]], [[0, 1, 0]], "shape"),
        ([[0, 0, 0]], [[0, 0, 1]], "name vertices"),
        ([[0, 0, 0]], [[0.0, 0, 0]], "integers"),
        ([[0, 0, float("nan")]], [[0, 0, 0]], "vertex 0 is not finite"),
        ([[0, 0, 1e300]], [[0, 0, 0]], "not finite in float32"),
        (np.empty((0, 3)), np.empty((0, 3), int), "shape"),
    ],
)
def test_arrays_that_are_no_mesh(vertices: object, faces: object, what: str) -> None:
    with pytest.raises(ValueError, match=what):
        geodesicd.glb_bytes(np.array(vertices), np.array(faces))


def test_what_is_no_mesh_at_all(client: geodesicd.Client) -> None:
    with pytest.raises(TypeError, match="set"):
        client.upload({1})
    with pytest.raises(TypeError, match="colour"):
        client.upload(b"glTF", colour="red")  # type: ignore[call-arg]
    with pytest.raises(FileNotFoundError):
        client.upload("nowhere.glb")


def test_a_known_mesh_is_not_sent_again(client: geodesicd.Client, samples: Path) -> None:
    client.upload(samples / "sphere.glb")
    sent: list[str] = []
    client._http.event_hooks["request"].append(lambda request: sent.append(request.method))
    try:
        mesh = client.upload(samples / "sphere.glb")
    finally:
        client._http.event_hooks["request"].clear()
    assert sent == ["HEAD", "GET"]
    assert mesh.id in [one.id for one in client.meshes(page_size=1)]
    mesh.delete()
    with pytest.raises(geodesicd.NotFound) as caught:
        mesh.distance(0)
    assert caught.value.code == "mesh_unknown"
    assert caught.value.request_id


def test_asynchronously(server: geodesicd.LocalServer, samples: Path) -> None:
    async def ask() -> None:
        async with geodesicd.AsyncClient(server.url) as client:
            mesh = await client.upload(samples / "plane.glb", progress=lambda part: None)
            fields = await asyncio.gather(*(mesh.distance(v, method="exact") for v in range(5)))
            for vertex, field in enumerate(fields):
                assert field[9] == pytest.approx(9 - vertex)
            (path,) = await mesh.paths([(0, 9)])
            assert path.length == 9
            told: list[float] = []
            labelled = await mesh.distance([0, 99], labels=True, progress=told.append)
            assert labelled.labels[98] == 1
            assert told[-1] == 1
            assert (await (await client.mesh(mesh.id)).prepare()).prepared
            assert (await client.status())["name"] == "geodesicd"
            with pytest.raises(geodesicd.GeodesicError):
                await mesh.path(0, 77777)

    asyncio.run(ask())


def test_both_clients_have_the_same_methods() -> None:
    for one, other in (
        (geodesicd.Client, geodesicd.AsyncClient),
        (geodesicd.Mesh, geodesicd.AsyncMesh),
    ):
        assert {n for n in vars(one) if n[0] != "_"} == {n for n in vars(other) if n[0] != "_"}
        assert all(getattr(one, name).__doc__ for name in vars(one) if name[0] != "_")


def test_what_comes_back_says_what_it_is(plane: geodesicd.Mesh, client: geodesicd.Client) -> None:
    path = plane.path(0, 9999)
    assert repr(path) == f"<Path 140.007 long, {len(path)} points, auto>"
    (line,) = plane.isolines(0, levels=[50])
    assert repr(line) == f"<Isoline at 50, open, {line.length:g} long, {len(line.points)} points>"
    assert repr(plane.samples(3)).startswith("<Samples 3 vertices, covering radius ")
    trace = plane.trace(0, direction=(0.6, 0.8, 0), length=10)
    assert (
        repr(trace)
        == f"<Trace {trace.length:g} long, {len(trace.points)} points, ends by {trace.end}>"
    )
    assert repr(plane.measure(5050, 2)).startswith("<Measure 1 discs")
    assert repr(plane.extent("mean", fields=2)).startswith("<Extent: mean ")
    cells = plane.voronoi([0, 99, 9900])
    assert repr(cells) == "<Voronoi 3 cells, 1 triangles>"
    assert repr(cells.bisectors[0]).startswith("<Bisector of (0, 1), open, ")
    loop = plane.loop(through=[0, 99, 9900])
    assert repr(loop) == f"<Loop {loop.length:g} long, {len(loop)} points, not geodesic>"
    around = plane.logmap(5050, 2)
    assert repr(around) == f"<Logmap {len(around)} vertices within 2, {around.method}>"
    assert repr(client) == f"<Client of {client.url}>"
