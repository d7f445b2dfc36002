"""Queries about a part of a surface: by the client, and by the command."""

from __future__ import annotations

import asyncio
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import geodesic

import geodesicd
from geodesicd.surface_regions import region_of, regions_of, walls_of


def hole_of(mesh: geodesicd.Mesh) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Which faces of the plane of 100 x 100 are in a square hole."""
    positions, triangles = mesh.geometry()
    middles = positions[triangles].mean(axis=1)
    inside = (middles[:, :2] > 20).all(axis=1) & (middles[:, :2] < 80).all(axis=1)
    return np.asarray(inside)


def test_all_ways_to_name_a_region_are_the_same(plane: geodesicd.Mesh) -> None:
    hole = hole_of(plane)
    # From corner to corner round the hole's.
    expected = math.hypot(80, 20) + math.hypot(19, 79)
    regions: list[Any] = [
        hole,
        np.flatnonzero(hole),
        np.flatnonzero(hole)[::-1].astype(np.uint32),
        {"faces": np.flatnonzero(hole)},
        {"faces": np.flatnonzero(hole).tolist()},
        "box:20,20,-1,80,80,1",
        {"box": {"min": (20, 20, -1), "max": np.array([80, 80, 1])}},
        [{"box": {"min": [20, 20, -1], "max": [50, 80, 1]}}, "box:50,20,-1,80,80,1"],
    ]
    for region in regions:
        path = plane.path(0, 9999, method="exact", forbid=region)
        assert path.length == pytest.approx(expected, rel=1e-12)
        assert not hole[path.faces[:-1]].any()
    kept = plane.path(0, 9999, method="exact", within=~hole)
    assert kept.length == pytest.approx(expected, rel=1e-12)
    ball = plane.distance(0, forbid={"sphere": {"center": (50, 50, 0), "radius": 20}})
    assert ball[5050] == math.inf
    assert np.isfinite(ball[[0, 9999]]).all()
    assert np.isfinite(plane.distance(0, within={"part": 0})).all()


def test_every_query_knows_regions(plane: geodesicd.Mesh) -> None:
    hole = hole_of(plane)
    whole = np.isfinite(plane.distance(0))
    assert whole.all()
    reached = np.isfinite(plane.distance(0, forbid=hole))
    positions = plane.geometry().positions
    inner = np.asarray(((positions[:, :2] > 20) & (positions[:, :2] < 80)).all(axis=1))
    np.testing.assert_array_equal(reached, ~inner)
    assert (plane.regions(0, forbid=hole).labels == -1).sum() == inner.sum()
    assert (plane.distance(0, labels=True, forbid=hole).labels == -1).sum() == inner.sum()
    far = plane.distance_at(0, [9999, (20.0, 80.0, 0.0)], method="exact", forbid=hole)
    np.testing.assert_allclose(far, [math.hypot(80, 20) + math.hypot(19, 79), math.hypot(20, 80)])
    np.testing.assert_allclose(plane.table([0], [9999], method="exact", forbid=hole)[0], far[:1])
    assert plane.paths([(0, 9999)], method="exact", forbid=hole)[0].length == pytest.approx(far[0])
    assert not inner[plane.samples(50, forbid=hole).vertices].any()
    assert plane.measure(0, forbid=hole).area == pytest.approx(99 * 99 - 60 * 60)
    assert plane.extent("diameter", fields=2, forbid=hole).part_vertices == (~inner).sum()
    assert not inner[plane.logmap(0, forbid=hole).vertices].any()
    assert plane.voronoi([0, 9999], forbid=hole).areas.sum() == pytest.approx(99 * 99 - 60 * 60)
    round_it = plane.loop(around=[0, 99, 9999, 9900], forbid=hole)
    assert round_it.length == pytest.approx(4 * 60)
    for line in plane.isolines(0, count=5, forbid=hole):
        x, y = line.points[:, 0], line.points[:, 1]
        assert not ((x > 20) & (x < 80) & (y > 20) & (y < 80)).any()
    ahead = plane.trace((0.0, 50.0, 0.0), 99, direction=(1, 0, 0), forbid=hole)
    assert ahead.length == pytest.approx(20)
    (near,) = plane.nearest((30.0, 50.0, 0.0), forbid=hole)
    assert near.xyz.tolist() == pytest.approx([20, 50, 0])
    assert plane.picture(0, forbid=hole).startswith(b"\x89PNG")
    assert plane.annotated(0, forbid=hole).startswith(b"glTF")
    answer = plane.query("samples", {"count": 1, "within": {"faces": np.array([7])}})
    assert answer.document is not None
    assert len(answer.document["samples"]) == 1
    lines = plane.batch(
        [{"query": "path", "from": 0, "to": 9999, "method": "exact", "forbid": hole}]
    )
    assert lines[0].reply is not None
    assert lines[0].reply["length"] == pytest.approx(far[0])


def test_all_ways_to_name_a_wall_are_the_same(plane: geodesicd.Mesh) -> None:
    # From the left to the right of an upright wall, round its upper end.
    ends = [(50.3, 10.2, 0.0), (50.3, 80.6, 0.0)]
    a, b = (30.0, 60.0, 0.0), (70.0, 60.0, 0.0)
    expected = math.hypot(20.3, 20.6) + math.hypot(19.7, 20.6)
    walls: list[Any] = [
        "p:50.3,10.2,0;p:50.3,80.6,0",
        {"points": ends},
        {"points": [{"xyz": [50.3, 10.2, 0], "max_snap": 1}, ends[1]]},
        np.array(ends),
        [{"points": [ends[0], (50.3, 40, 0)]}, {"points": [(50.3, 40, 0), ends[1]]}],
    ]
    for wall in walls:
        path = plane.path(a, b, method="exact", walls=wall)
        assert path.length == pytest.approx(expected, rel=1e-9)
    assert plane.distance_at(a, b, method="exact", walls=walls[0])[0] == pytest.approx(expected)
    round_it = [(20.5, 20.5, 0.0), (60.5, 20.5, 0.0), (60.5, 60.5, 0.0), (20.5, 60.5, 0.0)]
    inside = {"inside": round_it}
    assert plane.measure(0, forbid=inside).area == pytest.approx(99 * 99 - 1600)
    assert plane.measure((40.0, 40.0, 0.0), within=inside).area == pytest.approx(1600)
    closed = plane.distance((40.0, 40.0, 0.0), walls={"points": [*round_it, round_it[0]]})
    assert np.isfinite(closed).sum() == 1600
    assert math.isinf(closed[0])
    # Faces and weights are those of the file.
    positions, triangles = plane.geometry()
    corners = positions[triangles[path.faces]]
    there = (corners * path.bary[..., None]).sum(axis=1)
    np.testing.assert_allclose(there, path.points, atol=1e-9)
    samples = plane.samples(500, within=inside)
    assert (samples.vertices < len(positions)).all()


def test_vertices_in_an_array_are_a_wall(plane: geodesicd.Mesh) -> None:
    # From the lower edge upwards between two sources, with one corner.
    said = walls_of(np.array([50, 8050, 8060], dtype=np.uint16))
    assert said is not None
    assert [one.text() for one in said] == ["v:50;v:8050;v:8060"]
    wall = np.array([50, 8050])
    around = plane.path(49, 51, method="exact", walls=wall)
    assert around.length == pytest.approx(2 * math.hypot(1, 80))
    two = plane.path(49, 51, method="exact", walls=[wall, "v:8050;v:9050"])
    assert two.length == pytest.approx(2 * math.hypot(1, 90))


def test_what_is_no_wall_is_refused(plane: geodesicd.Mesh) -> None:
    for wrong, told in (
        (7, "an int is no wall"),
        ([1, 2], "an int is no wall.*array of vertices"),
        (np.zeros(3), "an array of float64 with the shape .3,. is no wall"),
        (np.zeros(3, dtype=bool), "an array of bool with the shape .3,. is no wall"),
        ([["v:1", "v:2"]], "a list is no wall"),
    ):
        with pytest.raises(TypeError, match=told):
            plane.distance(0, walls=wrong)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="None is for no walls"):
        plane.distance(0, walls=[])
    said = walls_of(["v:1;v:2", {"points": [1, (0.0, 1.0, 2.0)]}, {"points": [{"vertex": 1}]}])
    assert said is not None
    assert [one.text() for one in said] == ["v:1;v:2", "v:1;p:0.0,1.0,2.0", None]
    assert region_of({"inside": [1, 2, 3]}).text() == "inside:v:1;v:2;v:3"
    for code, parameter, wall in (
        ("value_out_of_range", "walls", "v:1"),
        ("index_out_of_range", "walls.points[1]", "v:1;v:99999"),
        ("bad_syntax", "walls.points[1]", "v:1;w:2"),
        ("unknown_parameter", "walls.x", {"points": [1, 2], "x": 1}),
    ):
        with pytest.raises(geodesicd.GeodesicError) as caught:
            plane.distance(0, walls=wall)
        assert (caught.value.code, caught.value.parameter) == (code, parameter)


def test_asynchronously_too(server: geodesicd.LocalServer, plane: geodesicd.Mesh) -> None:
    async def ask() -> Any:
        async with geodesicd.AsyncClient(server.url) as client:
            mesh = await client.mesh(plane.id)
            return await mesh.distance(0, within="faces:0-9")

    field = asyncio.run(ask())
    np.testing.assert_array_equal(field, plane.distance(0, within="faces:0-9"))
    assert np.isfinite(field).sum() < 20


def test_what_a_url_can_say_is_said_there() -> None:
    said: list[tuple[Any, str | None]] = [
        ("part:2", "part:2"),
        ({"part": 2}, "part:2"),
        ({"part": "roof"}, "part:roof"),
        ({"part": "2"}, 'part:"2"'),
        ({"part": ""}, 'part:""'),
        ({"material": 3}, "material:3"),
        ({"material": None}, "material:none"),
        ({"material": "none"}, 'material:"none"'),
        ({"material": "a & b+c;d,e*f"}, "material:a & b+c;d,e*f"),
        ({"material": '"a"'}, 'material:""a""'),
        ({"material": True}, None),
        ({"material": "a", "part": 2}, None),
        (np.array([3, 1, 2, 7, 7]), "faces:1-3,7"),
        (np.array([False, True, True, False, True]), "faces:1-2,4"),
        ({"sphere": {"center": (1, 2, 3), "radius": 4}}, "sphere:1.0,2.0,3.0,4.0"),
        ({"box": {"min": (1, 2, 3), "max": (4, 5, 6)}}, "box:1.0,2.0,3.0,4.0,5.0,6.0"),
        ({"faces": [1, [2, 3]]}, None),
        ({"sphere": {"center": (1, 2, 3), "radius": 4, "x": 1}}, None),
        ({"label": {"attribute": "_A=B", "value": 3}}, "label:_A=B=3.0"),
        ({"label": {"attribute": "_A", "value": np.float64(-0.5)}}, "label:_A=-0.5"),
        ({"label": {"attribute": "_A"}}, None),
        ({"label": {"attribute": "_A", "value": "3"}}, None),
        ({"part": 2, "faces": [1]}, None),
        ({"ball": 2}, None),
    ]
    for value, text in said:
        assert region_of(value).text() == text
    assert regions_of(None) is None
    many = regions_of(("part:1", {"part": 2}))
    assert many is not None
    assert [one.text() for one in many] == ["part:1", "part:2"]


NAMES = ["glass & steel+50%", "3", "none", '"quoted"', "ä#?=;,*", "none"]


def test_materials_by_name(client: geodesicd.Client) -> None:
    """Whatever a name has in it, it means the same by text, by mapping and by number."""
    obj = ["v 0 0 0", "v 1 0 0", "v 0 1 0", "v 1 1 0", "f 1 2 3"]
    for name in NAMES:
        obj += [f"usemtl {name}", "f 2 4 3"]
    mesh = client.upload("\n".join(obj).encode())
    order = list(dict.fromkeys(NAMES))
    counts = [1, 1, 2, 1, 1]
    assert mesh.materials == tuple(map(geodesicd.Material, order, counts))
    assert mesh.parts[0].material is None
    faces = np.array([-1, *(order.index(name) for name in NAMES)])
    for place, name in enumerate(order):
        expected = mesh.measure(1, within=faces == place).area
        for region in ({"material": name}, {"material": place}, f'material:"{name}"'):
            assert mesh.measure(1, within=region).area == expected
        started = mesh.distance(geodesicd.Faces({"material": name}))
        np.testing.assert_array_equal(started, mesh.distance(geodesicd.Faces(faces == place)))
        weights = [(2.0, {"material": name})]
        weighted = mesh.distance(1, costs=geodesicd.Costs(weights=weights))
        same = mesh.distance(1, costs=geodesicd.Costs(weights=[(2.0, faces == place)]))
        np.testing.assert_array_equal(weighted, same)
    assert mesh.measure(1, within={"material": None}).area == 0.5
    with pytest.raises(geodesicd.GeodesicError, match='the nearest names are "none"') as caught:
        mesh.distance(1, forbid={"material": "nine"})
    assert (caught.value.code, caught.value.parameter) == ("value_out_of_range", "forbid.material")


def test_labels_are_their_faces(client: geodesicd.Client, plane: geodesicd.Mesh) -> None:
    _, triangles = plane.geometry()
    sources = [0, 9999, 5050]
    _, labels = plane.distance(sources, labels=True)
    file = plane.annotated(sources, labels=True)
    mesh = client.upload(file)
    for value in range(len(sources)):
        label = {"label": {"attribute": "_GEODESIC_SOURCE", "value": value}}
        faces = (labels[triangles] == value).all(axis=1)
        np.testing.assert_array_equal(
            mesh.distance(geodesicd.Faces(label)), mesh.distance(geodesicd.Faces(faces))
        )
        start = int(triangles[faces][0, 0])
        np.testing.assert_array_equal(
            mesh.distance(start, within=label), mesh.distance(start, within=faces)
        )
    with pytest.raises(geodesicd.GeodesicError, match="there are: 0, 1, 2") as caught:
        mesh.distance(0, forbid="label:_GEODESIC_SOURCE=3")
    assert (caught.value.code, caught.value.parameter) == ("value_out_of_range", "forbid.label")


def test_what_is_no_region_is_refused_here(plane: geodesicd.Mesh) -> None:
    for wrong, told in (
        (7, "an int is"),
        (1.5, "a float is"),
        (np.array([1.5]), "an array of float64 with the shape .1,. is"),
        (np.zeros((2, 2), dtype=int), "an array of int64 with the shape .2, 2. is"),
    ):
        with pytest.raises(TypeError, match=f"{told} no region"):
            plane.distance(0, forbid=wrong)  # type: ignore[arg-type]
    nothing: list[Any] = [[], np.zeros(0, dtype=int), np.zeros(9, dtype=bool)]
    for empty in nothing:
        with pytest.raises(ValueError, match="None is for the whole"):
            plane.distance(0, forbid=empty)
    with pytest.raises(ValueError, match="counted from 0"):
        plane.distance(0, forbid=np.array([-1]))


def test_what_the_server_refuses(plane: geodesicd.Mesh) -> None:
    def refused(code: str, parameter: str, **options: Any) -> str:
        with pytest.raises(geodesicd.GeodesicError) as caught:
            plane.distance(9999, **options)
        assert (caught.value.code, caught.value.parameter) == (code, parameter)
        return str(caught.value)

    told = refused("outside_region", "from[0]", within="faces:0-9")
    assert "closest point of what is left" in told
    refused("value_out_of_range", "forbid", forbid="part:0")
    refused("index_out_of_range", "within.part", within={"part": 1})
    refused("unknown_parameter", "forbid.x", forbid={"part": 0, "x": 1})
    refused("bad_syntax", "forbid", forbid={"ball": 1})


def test_by_the_command(server: geodesicd.LocalServer, samples: Path) -> None:
    mesh = str(samples / "plane.glb")
    ways = ("--from", "0", "--to", "9999", "--method", "exact")
    told = geodesic(server, "path", mesh, *ways, "--forbid", "box:20,20,-1,80,80,1").stdout
    assert float(told) == pytest.approx(math.hypot(80, 20) + math.hypot(19, 79))
    two = ("--within", "faces:0-9", "--within", "faces:40", "--forbid", "faces:40")
    field = geodesic(server, "distance", mesh, "--from", "0", *two).stdout.split()
    assert sum(number != "inf" for number in field) < 20
    wall = ("--walls", "p:50.3,-1,0;p:50.3,80.6,0")
    told = geodesic(server, "path", mesh, "--from", "0", "--to", "99", *ways[4:], *wall).stdout
    assert float(told) == pytest.approx(math.hypot(50.3, 80.6) + math.hypot(48.7, 80.6))
    for command in (
        ("table", "--from", "0", "--to", "9999"),
        ("logmap", "--from", "0", "--radius", "3"),
        ("measure", "--from", "0", "--radius", "3"),
        ("extent", "--of", "mean", "--fields", "1"),
        ("voronoi", "--from", "0"),
        ("loop", "--through", "0", "--through", "9", "--through", "909"),
    ):
        name, *rest = command
        nothing = geodesic(server, name, mesh, *rest, "--forbid", "part:0", status=1)
        assert "no face of the mesh is left" in " ".join(nothing.stderr.split())
