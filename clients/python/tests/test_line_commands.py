"""The commands for lines of equal distance, straight lines, points and samples."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from command import geodesic

import geodesicd


def rows(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(text.splitlines()))


def test_isolines_of_a_plane(
    server: geodesicd.LocalServer, plane: geodesicd.Mesh, tmp_path: Path
) -> None:
    asked = ("isolines", plane.id, "--from", "5050", "--method", "exact")
    told = rows(geodesic(server, *asked, "--level", "10", "--level", "20.5").stdout)
    assert [row["level"] for row in told] == ["10", "20.5"]
    for row in told:
        assert row["closed"] == "1"
        round_it = 2 * np.pi * float(row["level"])
        assert float(row["length"]) == pytest.approx(round_it, rel=0.01)
    file = tmp_path / "lines.csv"
    geodesic(server, *asked, "--count", "5", "-o", file)
    points = rows(file.read_text())
    lines = plane.isolines(5050, count=5, method="exact")
    assert len(points) == sum(len(line.polyline) for line in lines)
    middle = plane.nearest([5050])[0].xyz
    for point in points:
        place = np.array([float(point[axis]) for axis in "xyz"])
        assert np.linalg.norm(place - middle) == pytest.approx(float(point["level"]), rel=0.01)
    first = [point for point in points if point["line"] == "0"]
    assert first[0] == first[-1]  # a closed one
    geodesic(server, *asked, "--step", "30", "--max", "70", "-o", tmp_path / "lines.json")
    document = json.loads((tmp_path / "lines.json").read_text())
    assert {line["level"] for line in document["isolines"]} == {30, 60}
    geodesic(server, *asked, "--count", "3", "-o", tmp_path / "lines.glb")
    assert (tmp_path / "lines.glb").read_bytes()[:4] == b"glTF"


def test_which_levels_has_to_be_said_once(server: geodesicd.LocalServer) -> None:
    none = geodesic(server, "isolines", "x", "--from", "0", status=2).stderr
    assert "--level --step --count" in none
    both = geodesic(server, "isolines", "x", "--from", "0", "--step", "1", "--count", "2", status=2)
    assert "not allowed with" in both.stderr
    assert (
        ".png should end with"
        in geodesic(
            server, "isolines", "x", "--from", "0", "--count", "2", "-o", "a.png", status=2
        ).stderr
    )


def test_straight_over_a_plane(
    server: geodesicd.LocalServer, plane: geodesicd.Mesh, tmp_path: Path
) -> None:
    asked = ("trace", plane.id, "--from", "p:10.25,20.5,0")
    way = ("--direction", "3,4,0")
    file = tmp_path / "line.csv"
    told = geodesic(server, *asked, *way, "--length", "25", "-o", file)
    assert float(told.stdout) == pytest.approx(25)
    assert "at 25.25, 40.5, 0: that is the length asked for" in told.stderr
    points = [[float(row[axis]) for axis in "xyz"] for row in rows(file.read_text())]
    np.testing.assert_allclose(points[0], [10.25, 20.5, 0], atol=1e-9)
    np.testing.assert_allclose(points[-1], [25.25, 40.5, 0], atol=1e-9)
    ended = geodesic(server, *asked, "--direction", "-1,0,0", "--length", "25")
    assert float(ended.stdout) == pytest.approx(10.25)
    assert "boundary" in ended.stderr
    assert rows(file.read_text())[-1]["along"] == told.stdout.strip()
    geodesic(server, *asked, "--angle", "1", "--length", "5", "-o", tmp_path / "line.glb")
    assert (tmp_path / "line.glb").read_bytes()[:4] == b"glTF"
    for wrong in (("--length", "1"), ("--angle", "1"), (*way, "--angle", "1", "--length", "1")):
        geodesic(server, *asked, *wrong, status=2)
    assert (
        "--direction is three numbers"
        in geodesic(server, *asked, "--direction", "1,0", "--length", "1", status=2).stderr
    )


def test_where_points_are(server: geodesicd.LocalServer, plane: geodesicd.Mesh) -> None:
    asked = ["p:10.25,20.5,3", "ray:50.5,50.25,9,0,0,-1", "99"]
    told = rows(geodesic(server, "nearest", plane.id, *asked).stdout)
    assert [float(row["away"]) for row in told] == pytest.approx([3, 0, 0])
    assert told[2]["point"] == "v:99"
    # What it tells is taken as a point.
    again = rows(geodesic(server, "nearest", plane.id, *(row["point"] for row in told)).stdout)
    for one, other in zip(told, again, strict=True):
        for axis in "xyz":
            assert float(one[axis]) == pytest.approx(float(other[axis]))
    kept = rows(geodesic(server, "nearest", plane.id, "p:50,50,0", "--within", "faces:0").stdout)
    assert float(kept[0]["away"]) > 60
    missed = geodesic(server, "nearest", plane.id, "ray:-9,-9,9,0,0,-1", status=1).stderr
    assert "bbox" in missed


def test_samples_of_a_plane(
    server: geodesicd.LocalServer, plane: geodesicd.Mesh, tmp_path: Path
) -> None:
    asked = ("samples", plane.id, "--from", "0", "--method", "exact")
    told = geodesic(server, *asked, "--count", "3")
    found = rows(told.stdout)
    assert found[0]["vertex"] == "9999"  # the corner across
    assert float(found[0]["radius"]) == pytest.approx(99 * np.sqrt(2))
    assert {row["vertex"] for row in found[1:]} == {"99", "9900"}
    assert "farther than 69.29646" in told.stderr  # 49 times the root of 2
    geodesic(server, *asked, "--count", "3", "-o", tmp_path / "some.npy")
    assert np.load(tmp_path / "some.npy").tolist() == [int(row["vertex"]) for row in found]
    geodesic(server, *asked, "--count", "3", "-o", tmp_path / "some.json")
    document = json.loads((tmp_path / "some.json").read_text())
    assert [str(sample["vertex"]) for sample in document["samples"]] == [
        row["vertex"] for row in found
    ]
