"""Tables and lists of any size are those that one request would give; errors in them are named."""

from __future__ import annotations

import functools
import os
import random
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import geodesicd
from geodesicd import pieces
from geodesicd.bench.mixes import hills
from geodesicd.flows import Flow

# Points of chance are far from the surface, too.
pytestmark = pytest.mark.filterwarnings("ignore::geodesicd.GeodesicWarning")


@pytest.fixture(scope="module")
def rough(client: geodesicd.Client) -> Iterator[geodesicd.Mesh]:
    """1,600 vertices of hills."""
    mesh = client.upload(hills(40, 5))
    yield mesh
    mesh.delete()


def told(limits: dict[str, int]) -> Flow[dict[str, int]]:
    """A server's limits, without asking it."""
    yield from ()
    return limits


@contextmanager
def asked(mesh: geodesicd.Mesh) -> Iterator[list[str]]:
    """The paths of the requests of a block."""
    sent: list[str] = []
    hooks = mesh.client._http.event_hooks["request"]
    hooks.append(lambda request: sent.append(request.url.path.rpartition("/")[2]))
    try:
        yield sent
    finally:
        hooks.clear()


def test_more_than_the_server_takes_at_once(rough: geodesicd.Mesh) -> None:
    rows, columns = list(range(1200)), list(range(400, 1600))
    told: list[float] = []
    with asked(rough) as sent:
        whole = rough.table(rows, columns, method="fast_marching")
    assert sent == ["status", "table", "table"]
    assert whole.shape == (1200, 1200)
    np.testing.assert_allclose(whole[833], rough.distance(833, method="fast_marching")[400:])
    one = rough.table(rows[900:905], columns, method="fast_marching")
    np.testing.assert_allclose(whole[900:905], one, rtol=1e-4)
    halves = rough.table(
        rows, columns, method="fast_marching", dtype=np.float32, progress=told.append
    )
    assert halves.dtype == np.float32
    np.testing.assert_allclose(halves, whole, rtol=1e-4)
    assert told == sorted(told)
    assert told[-1] == pytest.approx(1)


def test_blocks_are_one_table(rough: geodesicd.Mesh, monkeypatch: pytest.MonkeyPatch) -> None:
    seed = int(os.environ.get("GEODESICD_SEED") or random.SystemRandom().getrandbits(31))
    print(f"GEODESICD_SEED={seed}")
    chance = random.Random(seed)

    def some(most: int) -> list[geodesicd.PointLike]:
        x, y = (chance.uniform(0, 39) for _ in range(2))
        kinds: list[geodesicd.PointLike] = [
            (x, y, 3.0),
            geodesicd.OnFace(7, (0, 0, 1)),
            geodesicd.Curve([chance.randrange(1600), 7, 9]),
            "curve:closed;v:1;v:41;v:42",
            {"curve": {"points": ["v:5", "v:90"]}},
            geodesicd.Boundary(),
            geodesicd.Faces({"faces": [[4, 9]]}),
        ]
        return [
            chance.choice([*kinds, chance.randrange(1600)]) for _ in range(chance.randint(1, most))
        ]

    for _ in range(5):
        rows, columns = some(12), some(40)
        whole = rough.table(rows, columns, method="exact")
        limits = {
            "max_sources": chance.randint(1, 6),
            "max_points": chance.randint(1, 20),
            "max_curve_points": chance.randint(3, 9),
            "max_table_entries": chance.randint(1, 60),
            "max_json_bytes": chance.randint(200, 2000),
        }

        with monkeypatch.context() as patch, asked(rough) as sent:
            patch.setattr(pieces, "LIMITS", limits)
            patch.setattr(pieces, "told_limits", functools.partial(told, limits))
            np.testing.assert_allclose(
                rough.table(rows, columns, method="exact"), whole, rtol=1e-9, atol=1e-9
            )
            if len(rows) > limits["max_sources"]:
                assert len(sent) > 1


def test_more_lines_than_the_server_takes_at_once(client: geodesicd.Client, tmp_path: Path) -> None:
    """1,000 columns may be lines, and the curves of a request have 1,000 points."""
    mesh = client.upload(hills(8, 5))
    lines: list[geodesicd.PointLike] = [geodesicd.Curve([n % 60, n % 60 + 1]) for n in range(510)]
    lines += [geodesicd.Faces(np.array([n % 98])) for n in range(700)]
    ends: list[geodesicd.PointLike] = [0, 63, (3.25, 5.5, 0.0)]
    with asked(mesh) as sent:
        wide = mesh.table(ends, lines, method="exact")
        tall = mesh.table(lines, ends, method="exact")
        file = mesh.table_file(tmp_path / "tall.npy", lines, ends, method="exact")
    assert sent == ["status", "table", "table"] * 3
    np.testing.assert_allclose(wide, tall.T, rtol=1e-9, atol=1e-9)
    np.testing.assert_array_equal(file, tall)
    for number in (0, 499, 500, 509, 510, 1209):
        one = mesh.table(ends, [lines[number]], method="exact")
        np.testing.assert_array_equal(wide[:, number : number + 1], one)
    near = mesh.sparse_table(lines, ends, max=5, method="exact")
    np.testing.assert_array_equal(near.to_array(), np.where(tall <= 5, tall, np.inf))
    with asked(mesh) as sent:
        edges = mesh.table([27], [geodesicd.Boundary()] * 1200)
    assert sent == ["status", "table", "table"]
    assert np.unique(edges).tolist() == mesh.table([27], [geodesicd.Boundary()]).tolist()[0]
    with pytest.raises(geodesicd.GeodesicError) as caught:
        mesh.table(ends, [*lines, geodesicd.Faces(np.array([99999]))])
    assert caught.value.parameter == "to[1210].faces[0]"
    mesh.delete()


def test_tables_among_lines_are_symmetric_across_blocks(
    rough: geodesicd.Mesh, monkeypatch: pytest.MonkeyPatch
) -> None:
    lines: list[Any] = [geodesicd.Curve([v, v + 45]) for v in range(0, 1200, 150)]
    lines += [geodesicd.Boundary(), geodesicd.Faces(np.array([0, 1]))]
    whole = rough.table(lines, method="exact")
    limits = {**pieces.LIMITS, "max_sources": 3}
    monkeypatch.setattr(pieces, "told_limits", functools.partial(told, limits))
    monkeypatch.setattr(pieces, "LIMITS", limits)
    with asked(rough) as sent:
        blocks = rough.table(lines, method="exact")
    assert sent == ["table"] * 16
    np.testing.assert_array_equal(blocks, whole)
    np.testing.assert_array_equal(blocks, blocks.T)


def test_an_error_in_a_block_is_named_as_in_the_whole(rough: geodesicd.Mesh) -> None:
    rows = [*range(1500), 77777]
    with pytest.raises(geodesicd.GeodesicError) as caught:
        rough.table(rows, [0, 1], method="dijkstra")
    assert caught.value.parameter == "from[1500]"
    with pytest.raises(geodesicd.DeadlineExceeded):
        rough.table(rows, list(range(1600)), method="exact", deadline=0.05)


def test_more_points_than_the_server_takes_at_once(rough: geodesicd.Mesh) -> None:
    places = np.tile(rough.geometry().positions, (63, 1))
    places += (0, 0, 1e-7)
    assert len(places) > 100_000
    told: list[float] = []
    with asked(rough) as sent:
        far = rough.distance_at(0, places, method="fast_marching", progress=told.append)
    assert sent.count("distance") > 1
    assert far.shape == (len(places),)
    np.testing.assert_allclose(far[:1600], rough.distance(0, method="fast_marching"), atol=1e-4)
    np.testing.assert_allclose(far[1600:], far[:-1600], atol=1e-4)
    assert told == sorted(told)
    indices = [*range(1600)] * 63
    with asked(rough) as sent:
        found = rough.nearest(indices)
    assert sent.count("nearest") > 1
    assert [point.vertex for point in found] == indices
    with pytest.raises(geodesicd.GeodesicError) as caught:
        rough.nearest([*indices, 99999])
    assert caught.value.parameter == f"point[{len(indices)}]"
