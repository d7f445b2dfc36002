"""How a caller's points become the server's: without a server."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import geodesicd
from geodesicd.encoding import as_points, encode
from geodesicd.points import point_of, points_of


def test_what_points_are() -> None:
    assert point_of((0, 5, 9)).json() == {"xyz": [0, 5, 9]}
    assert [p.json() for p in points_of([0, 5, 9])] == [{"vertex": v} for v in (0, 5, 9)]
    assert [p.text() for p in points_of(np.array([3, 4]))] == ["v:3", "v:4"]
    assert [p.text() for p in points_of(np.eye(3)[:2])] == ["p:1.0,0.0,0.0", "p:0.0,1.0,0.0"]
    assert [p.text() for p in points_of(((1.0, 2.0, 3.0), 7))] == ["p:1.0,2.0,3.0", "v:7"]
    for integer in (np.int32(4), np.uint8(4), np.array(4), 4):
        assert point_of(integer).text() == "v:4"
        assert [p.text() for p in points_of(integer)] == ["v:4"]
    assert [p.text() for p in points_of([np.int64(4), 5])] == ["v:4", "v:5"]
    assert point_of(np.array([1.5, 2, 3])).text() == "p:1.5,2.0,3.0"


def test_directions_of_numpy_are_numbers_in_a_url() -> None:
    for name in ("direction", "normal", "up"):
        for value, text in (
            (np.array([1.0, 0.25, 0.0]), "1.0,0.25,0.0"),
            ((np.float64(1.5), np.int64(2), 3), "1.5,2,3"),
            (np.array([0, 0, 1]), "0,0,1"),
        ):
            asked = as_points({"from": 0, name: value, "length": np.float64(9)})
            request = encode("abc", "trace", asked)
            assert request.target == f"/v1/meshes/abc/trace?from=v:0&{name}={text}&length=9.0"


def test_three_numbers_with_a_fraction_are_a_place() -> None:
    places: list[Any] = [[0.5, 1, 2], (0.5, 1, 2), np.array([0.5, 1, 2]), (np.float32(0.5), 1, 2)]
    for place in places:
        assert point_of(place).text() == "p:0.5,1.0,2.0"
        assert [p.text() for p in points_of(place)] == ["p:0.5,1.0,2.0"]
    assert [p.text() for p in points_of([(0, 1, 2), 7])] == ["p:0.0,1.0,2.0", "v:7"]
    assert [p.text() for p in points_of(places[:1])] == ["p:0.5,1.0,2.0"]


def test_three_integers_are_not_guessed_about() -> None:
    with pytest.raises(TypeError, match=r"write \[0, 5, 9\] for vertices, \(0\.0, 5\.0, 9\.0\)"):
        points_of((0, 5, 9))
    with pytest.raises(TypeError, match=r"the tuple \(0, 5, 9\)"):
        point_of([0, 5, 9])  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="three vertices"):
        point_of(np.array([0, 5, 9]))
    with pytest.raises(TypeError, match=r"a list: \[3, 7\]"):
        points_of((3, 7))


@pytest.mark.parametrize(
    ("wrong", "why"),
    [
        (True, "flatnonzero"),
        (1.5, "an integer"),
        (np.float64(3), "an integer"),
        (None, "NoneType is no point: give a vertex"),
        ({1}, "one point only"),
        ([1, 2], "three numbers"),
        (np.zeros((2, 2)), "shape"),
        (np.zeros(5), "astype"),
        (np.ones(5, bool), "flatnonzero"),
        (object(), "object is no point"),
    ],
)
def test_what_is_no_point_is_refused(wrong: object, why: str) -> None:
    with pytest.raises(TypeError, match=why):
        point_of(wrong)  # type: ignore[arg-type]
    if not isinstance(wrong, list):
        with pytest.raises(TypeError):
            points_of(wrong)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="integer"):
        points_of([0.5, 1.0, 2.0, 3.0])  # type: ignore[list-item]


def test_what_makes_an_array_is_one() -> None:
    class Series:
        def __array__(self, dtype: object = None, copy: object = None) -> object:
            return np.array([3, 4])

    assert [p.text() for p in points_of(Series())] == ["v:3", "v:4"]  # type: ignore[arg-type]


def test_numbers_that_are_not_finite_are_refused() -> None:
    with pytest.raises(ValueError, match="finite"):
        geodesicd.Xyz((0, float("nan"), 0))
    with pytest.raises(ValueError, match="offset"):
        geodesicd.Vertex(0, offset=-1)


def test_a_url_says_what_it_can_and_a_body_the_rest() -> None:
    short = encode("abc", "distance", {"from": points_of([0, (1e20, 2, -3)]), "max": 2.5})
    assert short.method == "GET"
    assert short.target == "/v1/meshes/abc/distance?from=v:0&from=p:1e%2B20,2.0,-3.0&max=2.5"
    offset = encode("abc", "distance", {"from": points_of([geodesicd.Vertex(0, offset=2)])})
    assert (offset.method, offset.body) == ("POST", b'{"from":[{"vertex":0,"offset":2.0}]}')
    assert encode("abc", "table", {"from": points_of(list(range(5000)))}).method == "POST"
    assert offset.idempotent
