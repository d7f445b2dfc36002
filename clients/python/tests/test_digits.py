"""Numbers are printed and written without digits that say nothing."""

from __future__ import annotations

import csv
import json
import math
import random
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import geodesic
from numpy.typing import NDArray

import geodesicd
from geodesicd.digits import number, numbers, short


@pytest.mark.parametrize("seed", range(5))
def test_a_float_is_said_in_its_own_digits(seed: int) -> None:
    chance = random.Random(seed)
    for _ in range(2000):
        double = chance.uniform(-1, 1) * 10.0 ** chance.randint(-12, 12)
        single = np.float32(double)
        assert float(number(double)) == double
        told = number(float(single))
        assert np.float32(told) == single
        assert float(told) == float(single) or told == np.format_float_positional(single, trim="-")
        assert len(told.lstrip("-0.").replace(".", "").rstrip("0")) <= 9


@pytest.mark.parametrize(
    ("value", "text"),
    [(152.14399719238281, "152.144"), (0.1, "0.1"), (151.83492798399453, "151.83492798399453"),
     (float(np.float32(0.1)), "0.1"), (99.0, "99"), (0.0, "0"), (math.inf, "inf"), (-2.5, "-2.5"),
     (50.0390625, "50.0390625"), (1e300, "1" + "0" * 300), (2.0**24 + 2, "16777218")],
)  # fmt: skip
def test_digits(value: float, text: str) -> None:
    assert number(value) == text


def test_arrays_keep_their_shape() -> None:
    points = np.array([[0.1, 0.2], [1e40, np.nan]]).astype(np.float64)
    points[0] = np.array([0.1, 0.2], np.float32)
    assert numbers(points) == ["0.1", "0.2", "1" + "0" * 40, "nan"]
    np.testing.assert_array_equal(short(points), [[0.1, 0.2], [1e40, np.nan]])
    assert numbers(np.empty(0)) == []


def test_the_commands_print_no_noise(
    server: geodesicd.LocalServer, terrain: geodesicd.Mesh, tmp_path: Path
) -> None:
    """Distances by auto are floats, and so are the vertices of the file."""
    field = terrain.distance(0, method="auto")
    assert (field == field.astype(np.float32)).all()
    asked = (terrain.id, "--from", "0", "--method", "auto")

    def quiet(texts: list[str], of: NDArray[Any]) -> None:
        np.testing.assert_array_equal(np.array(texts, dtype=np.float32), of)
        assert max(len(text) for text in texts) <= 12

    quiet(geodesic(server, "distance", *asked).stdout.split(), field)
    geodesic(server, "distance", *asked, "-o", tmp_path / "field.csv")
    with (tmp_path / "field.csv").open() as file:
        header, *rows = csv.reader(file)
    assert header == ["index", "distance"]
    assert [row[0] for row in rows] == [str(n) for n in range(len(field))]
    quiet([row[1] for row in rows], field)
    table = geodesic(server, "table", *asked, "--to", "77", "--to", "7777").stdout.splitlines()
    quiet(table[1].split(",")[1:], field[[77, 7777]])

    corners = terrain.path(0, 7777).points[[0, -1]]
    for ending in ("csv", "json"):
        file_of_path = tmp_path / f"path.{ending}"
        geodesic(server, "path", *asked[:3], "--to", "7777", "-o", file_of_path)
    with (tmp_path / "path.csv").open() as file:
        header, *rows = csv.reader(file)
    assert header == ["x", "y", "z", "face", "along"]
    document = json.loads((tmp_path / "path.json").read_text())
    for end in (0, -1):
        quiet(rows[end][:3], corners[end])
        quiet([repr(number) for number in document["points"][end]], corners[end])
    assert np.array([row[:3] for row in rows], float) == pytest.approx(np.array(document["points"]))
