"""How a caller's points become the server's: without a server."""

from __future__ import annotations

import numpy as np
import pytest

import geodesicd
from geodesicd.encoding import encode
from geodesicd.points import point_of, points_of


def test_a_tuple_is_a_place_and_a_list_several_points() -> None:
    assert point_of((0, 5, 9)).json() == {"xyz": [0, 5, 9]}
    assert [p.json() for p in points_of([0, 5, 9])] == [{"vertex": v} for v in (0, 5, 9)]
    assert [p.text() for p in points_of(np.array([3, 4]))] == ["v:3", "v:4"]
    assert [p.text() for p in points_of(np.eye(3)[:2])] == ["p:1.0,0.0,0.0", "p:0.0,1.0,0.0"]
    assert [p.text() for p in points_of(((1.0, 2.0, 3.0), 7))] == ["p:1.0,2.0,3.0", "v:7"]
    assert point_of(np.int32(4)).text() == "v:4"
    assert point_of(np.array([1.5, 2, 3])).text() == "p:1.5,2.0,3.0"


@pytest.mark.parametrize("wrong", [True, 1.5, None, {1}, np.array([1, 2, 3]), np.zeros((2, 2))])
def test_what_is_no_point_is_refused(wrong: object) -> None:
    with pytest.raises(TypeError):
        point_of(wrong)  # type: ignore[arg-type]


def test_a_list_of_floats_is_refused_with_a_hint() -> None:
    with pytest.raises(TypeError, match="tuple"):
        points_of([0.5, 1.0, 2.0])  # type: ignore[list-item]


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
