"""Cheap ways instead of short ones: by the client, and by the command."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import geodesic

import geodesicd
from geodesicd import Costs
from geodesicd.plot import plot


def least_by_snell(width: float, height: float, weight: float) -> float:
    """Across two halves of a plane, of which the second costs more, from corner to corner."""
    heights = np.linspace(0, height, 100_001)
    half = width / 2
    return float((np.hypot(half, heights) + weight * np.hypot(half, height - heights)).min())


def test_all_ways_to_say_weights_are_the_same(plane: geodesicd.Mesh) -> None:
    positions, triangles = plane.geometry()
    right = positions[triangles].mean(axis=1)[:, 0] > 50
    dear = {"box": {"min": (50, -1, -1), "max": (100, 100, 1)}}
    expected = least_by_snell(98, 99, 3)
    found = [
        plane.path(0, 9998, costs=Costs(weights=[(3, region)]))
        for region in (right, np.flatnonzero(right), dear, "box:50,-1,-1,100,100,1")
    ]
    found.append(plane.path(0, 9998, costs=Costs(face_weights=np.where(right, 3, 1))))
    for path in found:
        assert path.cost == found[0].cost
        assert path.unit == "length"
        assert path.method == "steiner"
        assert path.segment_costs is not None
        assert path.segment_costs.sum() == pytest.approx(path.cost)
        assert len(path.segment_costs) == len(path) - 1
    assert path.cost is not None
    # Its halves are 50 and 48 wide.
    assert path.cost == pytest.approx(expected, rel=0.03)
    assert path.cost > path.length > math.hypot(98, 99)


def test_distances_are_costs_of_walking_there(plane: geodesicd.Mesh) -> None:
    # Up is along x: the plane is a wall, of which one side is the other's mirror.
    costs = Costs(slope=[(-1, 2), (1, 4)], up=(1, 0, 0))
    field = plane.distance(0, costs=costs)
    assert field[99] == pytest.approx(99 * 4)
    assert plane.distance_at(99, 0, costs=costs)[0] == pytest.approx(99 * 2)
    assert plane.table([0, 99], costs=costs)[0, 1] == field[99]
    assert plane.table([0, 99], costs=costs)[1, 0] == pytest.approx(99 * 2)
    labelled = plane.regions([0, 99], costs=costs)
    assert labelled.labels[49] == 1
    lines = plane.isolines(0, levels=[40], costs=costs)
    assert [line.level for line in lines] == [40]
    assert plane.path(0, 99).cost is None
    [one] = plane.paths([(0, 99)], costs=costs)
    assert one.cost == pytest.approx(99 * 4)
    assert one.unit == "cost"
    level = plane.distance(0, costs=Costs(steepest=1e-6, up=(1, 0, 0)))
    assert np.isfinite(level).sum() == 100
    assert plane.path(0, 99, costs=Costs(steepest=0.1, up=(1, 0, 0))).reachable is False
    with pytest.raises(geodesicd.GeodesicError) as refused:
        plane.path(0, 99, costs=costs, method="exact")
    assert refused.value.parameter == "method"


def test_commands_walk_cheaply(
    server: geodesicd.LocalServer, plane: geodesicd.Mesh, tmp_path: Path
) -> None:
    asked = [plane.id, "--from", "v:0", "--to", "v:99"]

    def cost(*more: str | Path) -> float:
        return float(geodesic(server, "path", *asked, *more).stdout)

    assert cost("--slope", "1:4") == pytest.approx(99 * 4)
    assert cost("--weight", "2*box:-1,-1,-1,101,101,1") == pytest.approx(99 * 2)
    glb = tmp_path / "path.glb"
    assert cost("--weight", "2*part:0", "-o", glb) == pytest.approx(99 * 2)
    assert glb.read_bytes().startswith(b"glTF")
    wrong = geodesic(server, "path", *asked, "--weight", "2", status=2)
    assert "NUMBER*REGION" in wrong.stderr


@pytest.mark.parametrize(
    ("up", "slope"), [("1,0,0", "-1:2,1:4"), ("x", "-1:2,1:4"), ("-1,0,0", "-1:4,1:2")]
)
def test_up_of_the_commands(
    server: geodesicd.LocalServer, plane: geodesicd.Mesh, up: str, slope: str
) -> None:
    uphill = ("--slope", slope, "--up", up)
    ends = (plane.id, "--from", "0", "--to", "99")
    assert float(geodesic(server, "path", *ends, *uphill).stdout) == pytest.approx(99 * 4)
    rows = geodesic(server, "table", *ends, *uphill).stdout.splitlines()
    assert float(rows[1].split(",")[1]) == pytest.approx(99 * 4)
    down = geodesic(server, "distance", plane.id, "--from", "99", "--at", "0", *uphill)
    assert float(down.stdout) == pytest.approx(99 * 2)


def test_what_the_commands_say_of_a_wrong_up(
    server: geodesicd.LocalServer, plane: geodesicd.Mesh
) -> None:
    asked = ("path", plane.id, "--from", "0", "--to", "99", "--up")
    assert "--up is three numbers" in geodesic(server, *asked, "north", status=2).stderr
    assert "slope or steepest" in geodesic(server, *asked, "0,0,1", status=1).stderr


def test_face_weights_of_the_commands(
    server: geodesicd.LocalServer, plane: geodesicd.Mesh, tmp_path: Path
) -> None:
    positions, triangles = plane.geometry()
    weights = np.where(positions[triangles].mean(axis=1)[:, 0] > 50, 3.0, 1.5)
    sent = plane.path(0, 9998, costs=Costs(face_weights=weights)).cost
    array, text, row = (tmp_path / f"weights.{ending}" for ending in ("npy", "txt", "csv"))
    np.save(array, weights)
    np.savetxt(text, weights)
    row.write_text(",".join(map(repr, weights.tolist())))
    asked = ("path", plane.id, "--from", "0", "--to", "9998", "--face-weights")
    for file in (array, text, row):
        assert float(geodesic(server, *asked, file).stdout) == pytest.approx(sent)
    # A region goes over them.
    over = geodesic(server, *asked, text, "--weight", "2*box:-1,-1,-1,101,101,1").stdout
    alone = plane.path(0, 9998, costs=Costs([(2, "box:-1,-1,-1,101,101,1")])).cost
    assert float(over) == pytest.approx(alone)
    for name, content, told in (
        ("words.txt", "1 2 dear", "words.txt should have numbers alone"),
        ("endless.txt", "1 inf", "not finite"),
        ("few.txt", "1 2 3", "face_weights"),
    ):
        (tmp_path / name).write_text(content)
        assert told in geodesic(server, *asked, tmp_path / name, status=1).stderr
    np.save(array, weights.reshape(2, -1))
    assert "one number for each face" in geodesic(server, *asked, array, status=1).stderr


def test_costs_are_drawn(
    server: geodesicd.LocalServer, plane: geodesicd.Mesh, tmp_path: Path
) -> None:
    small: dict[str, Any] = {"size": (4, 3), "dpi": 50}
    costs = Costs(slope=[(-1, 2), (1, 4)], up=(1, 0, 0))
    figure = plot(plane, 0, target=99, costs=costs, **small)
    assert figure.axes[0].get_title().endswith("· path 396")
    assert figure.axes[1].get_ylabel() == "cost"
    assert plot(plane, 0, **small).axes[1].get_ylabel() == "distance (mesh units)"
    on_foot = plot(plane, 0, target=99, costs=Costs(slope="tobler"), **small)
    assert on_foot.axes[0].get_title().endswith(" s")
    assert on_foot.axes[1].get_ylabel() == "cost (seconds)"
    asked = ("plot", plane.id, "--from", "0", "--to", "99", "-o")
    short, dear, hilly = (tmp_path / f"{name}.png" for name in ("short", "dear", "hilly"))
    geodesic(server, *asked, short, "--up", "z")  # the picture's alone
    geodesic(server, *asked, dear, "--weight", "2*box:-1,-1,-1,50,99,1")
    geodesic(server, *asked, hilly, "--slope", "tobler", "--steepest", "1", "--up", "z")
    assert len({file.read_bytes() for file in (short, dear, hilly)}) == 3


def test_weights_may_come_from_the_file(
    server: geodesicd.LocalServer, client: geodesicd.Client, plane: geodesicd.Mesh
) -> None:
    point = (50.3, 50.2, 0.0)
    muddy = client.upload(plane.annotated(point, attribute="_MUD"))
    at_corners = plane.distance(point).astype(np.float32).astype(np.float64)
    weights = at_corners[plane.geometry().triangles].mean(axis=1)
    read = muddy.path(0, 9998, costs=Costs(weight_attribute="_MUD"))
    sent = muddy.path(0, 9998, costs=Costs(face_weights=weights))
    assert read.cost is not None
    assert read.cost == pytest.approx(sent.cost, rel=1e-9)
    asked = ("path", muddy.id, "--from", "0", "--to", "9998")
    told = geodesic(server, *asked, "--weight", "_MUD").stdout
    assert float(told) == pytest.approx(read.cost, rel=1e-4)
    with pytest.raises(geodesicd.GeodesicError) as caught:
        muddy.path(0, 9998, costs=Costs(weight_attribute="_SNOW"))
    assert caught.value.parameter == "weight_attribute"
    assert "_MUD" in str(caught.value)
