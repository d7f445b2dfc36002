"""Tables of thousands: files that go on where they broke off, and sparse ones."""

from __future__ import annotations

import asyncio
import json
import random
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest

import geodesicd
from geodesicd import Client, Mesh, Retries, large_tables


class Cut(httpx.BaseTransport):
    """Breaks bodies of tables off after so many bytes, as many times as asked."""

    def __init__(self, cuts: list[int]) -> None:
        self._inner = httpx.HTTPTransport()
        self.cuts = cuts
        self.rows: list[str] = []

    def close(self) -> None:
        """As a transport is closed."""
        self._inner.close()

    def handle_request(self, request: httpx.Request) -> httpx.Response:
        response = self._inner.handle_request(request)
        if not request.url.path.endswith("/table") or response.status_code != 200:
            return response
        asked = json.loads(request.content) if request.content else dict(request.url.params)
        self.rows.append(asked.get("rows", ""))
        if not self.cuts:
            return response
        left = self.cuts.pop(0)

        class Body(httpx.SyncByteStream):
            def __iter__(self) -> Any:
                nonlocal left
                for chunk in response.stream:  # type: ignore[union-attr]
                    if len(chunk) > left:
                        yield chunk[:left]
                        raise httpx.RemoteProtocolError("cut", request=request)
                    left -= len(chunk)
                    yield chunk

            def close(self) -> None:
                response.close()

        return httpx.Response(200, headers=response.headers, stream=Body())


def cut_client(url: str, cuts: list[int]) -> tuple[Client, Cut]:
    """A client whose connections break."""
    client = Client(url)
    transport = Cut(cuts)
    client._http.close()
    client._http = httpx.Client(base_url=client.url, transport=transport)
    return client, transport


@pytest.fixture(name="points")
def some_points(plane: Mesh) -> list[int]:
    """Vertices, drawn anew each time."""
    seed = random.randrange(2**32)
    print(f"seed {seed}")
    return random.Random(seed).sample(range(plane.vertices), 40)


def test_a_file_has_the_rows_of_distance(plane: Mesh, points: list[int], tmp_path: Path) -> None:
    file = tmp_path / "table.npy"
    told: list[float] = []
    mapped = plane.table_file(file, points, points[:7], progress=told.append)
    assert mapped.shape == (40, 7)
    assert mapped.dtype == np.float64
    fields = np.array([plane.distance(v)[points[:7]] for v in points])
    np.testing.assert_array_equal(np.load(file), fields)
    assert told == sorted(told)
    assert told[-1] == 1
    assert [one.name for one in tmp_path.iterdir()] == ["table.npy"]
    narrow = plane.table_file(file, points, dtype=np.float32, method="dijkstra", max=30)
    assert narrow.dtype == np.float32
    near = plane.table(points, method="dijkstra", max=30, dtype=np.float32)
    np.testing.assert_allclose(np.load(file), near, rtol=1e-6)


def test_a_table_may_be_estimated(plane: Mesh, points: list[int], tmp_path: Path) -> None:
    whole = plane.table_file(tmp_path / "whole.npy", points)
    said: list[dict[str, float]] = []
    found = plane.table_file(
        tmp_path / "estimated.npy", points, landmarks=20, estimated=said.append
    )
    assert said[0]["landmarks"] == 20
    assert 0 <= said[0]["mean"] <= said[0]["max"]
    assert np.mean(np.abs(found - whole)) < 0.05 * np.mean(whole)
    with pytest.raises(geodesicd.GeodesicError, match="landmarks"):
        plane.table_file(tmp_path / "no.npy", points, landmarks=20, max=3)


def test_a_table_goes_on_where_the_connection_breaks(
    plane: Mesh, points: list[int], tmp_path: Path
) -> None:
    whole = plane.table_file(tmp_path / "whole.npy", points)
    row = 8 * len(points)
    cuts = [3 * row + 5, 0, row - 1, 10 * row]
    client, transport = cut_client(plane.client.url, list(cuts))
    with client:
        found = client.mesh(plane.id).table_file(tmp_path / "cut.npy", points)
    np.testing.assert_array_equal(found, whole)
    assert transport.rows == ["0-", "3-", "3-", "3-", "13-"]


def test_a_call_goes_on_with_what_the_last_one_wrote(
    plane: Mesh, points: list[int], tmp_path: Path
) -> None:
    file = tmp_path / "table.npy"
    row = 8 * len(points)
    client, transport = cut_client(plane.client.url, [5 * row + 1, 0, 0, 0, 0, 0, 0])
    with client:
        with pytest.raises(geodesicd.ConnectionFailed):
            client.mesh(plane.id).table_file(file, points)
        assert json.loads((tmp_path / "table.npy.part").read_text())["rows"] == 5
        transport.cuts.clear()
        transport.rows.clear()
        found = client.mesh(plane.id).table_file(file, points)
        assert transport.rows == ["5-"]
        np.testing.assert_array_equal(found, plane.table_file(tmp_path / "other.npy", points))
        assert not (tmp_path / "table.npy.part").exists()
        # Of another table, or unless it is wanted, nothing is gone on with.
        for other in ({"max": 5.0}, {"resume": False}):
            transport.cuts = [5 * row + 1, 0, 0, 0, 0, 0, 0]
            with pytest.raises(geodesicd.ConnectionFailed):
                client.mesh(plane.id).table_file(file, points)
            transport.cuts.clear()
            transport.rows.clear()
            client.mesh(plane.id).table_file(file, points, **other)
            assert transport.rows == ["0-"]


ROWS = np.array([[0.0, 1.5, 2.5], [1.5, 0.0, 3.5], [2.5, 3.5, 0.0]])
TOLD = {"Geo-Dtype": "<f8", "Geo-Shape": "3,3"}


class Replies:
    """Replies without a server: first those that are given, None for a connection that breaks, and
    then the rows that are asked for."""

    def __init__(self, *first: httpx.Response | None) -> None:
        self.first = list(first)
        self.rows: list[str] = []

    def __call__(self, request: httpx.Request) -> httpx.Response:
        """As httpx.MockTransport calls it."""
        self.rows.append(request.url.params["rows"])
        if not self.first:
            rows = ROWS[int(self.rows[-1].removesuffix("-")) :]
            headers = {**TOLD, "Geo-Shape": f"{len(rows)},3"}
            return httpx.Response(200, headers=headers, content=rows.tobytes())
        reply = self.first.pop(0)
        if reply is None:
            raise httpx.RemoteProtocolError("cut", request=request)
        return reply


NOWHERE = "http://127.0.0.1:1"


def filled(replies: Replies, file: Path, attempts: int = 5) -> Any:
    """Fills a file by those replies."""
    with Client(NOWHERE, retries=Retries(attempts, first_pause=0)) as client:
        client._http.close()
        transport = httpx.MockTransport(replies)
        client._http = httpx.Client(base_url=client.url, transport=transport)
        return client.run(large_tables.table_file("0" * 64, file, [0, 1, 2]))


def filled_asynchronously(replies: Replies, file: Path, attempts: int = 5) -> Any:
    """The same by the asynchronous client."""

    async def ask() -> Any:
        retries = Retries(attempts, first_pause=0)
        async with geodesicd.AsyncClient(NOWHERE, retries=retries) as client:
            await client._http.aclose()
            transport = httpx.MockTransport(replies)
            client._http = httpx.AsyncClient(base_url=client.url, transport=transport)
            return await client.run(large_tables.table_file("0" * 64, file, [0, 1, 2]))

    return asyncio.run(ask())


by_either_client = pytest.mark.parametrize("fill", [filled, filled_asynchronously])


@by_either_client
@pytest.mark.parametrize(
    ("status", "headers"),
    [
        (200, {"Content-Type": "text/html"}),
        (200, {"Geo-Dtype": "<f8"}),
        (200, {**TOLD, "Geo-Shape": "4,3"}),
        (200, {**TOLD, "Geo-Shape": "3,4"}),
        (200, {**TOLD, "Geo-Dtype": "<f4"}),
        (206, TOLD),
    ],
)
def test_what_is_no_rows_is_not_taken_for_rows(
    tmp_path: Path, fill: Callable[..., Any], status: int, headers: dict[str, str]
) -> None:
    def foreign() -> httpx.Response:
        return httpx.Response(status, headers=headers, content=np.full((3, 3), 7.0).tobytes())

    begun = httpx.Response(200, headers=TOLD, content=ROWS[:1].tobytes())
    replies = Replies(foreign(), begun, foreign())
    np.testing.assert_array_equal(fill(replies, tmp_path / "table.npy"), ROWS)
    assert replies.rows == ["0-", "0-", "1-", "1-"]
    # One that comes each time is told, and nothing of it is written.
    with pytest.raises(geodesicd.ConnectionFailed, match=f"the reply has status {status}") as told:
        fill(Replies(*[foreign() for _ in range(5)]), tmp_path / "other.npy")
    assert "no reply of geodesicd's own" in str(told.value)
    assert [one.name for one in tmp_path.iterdir()] == ["table.npy"]


@by_either_client
def test_a_page_elsewhere_is_not_taken_for_rows(tmp_path: Path, fill: Callable[..., Any]) -> None:
    elsewhere = {"Location": "https://elsewhere.example/", **TOLD}
    replies = Replies(httpx.Response(302, headers=elsewhere, content=ROWS.tobytes()))
    with pytest.raises(geodesicd.GeodesicError, match=r"elsewhere\.example") as caught:
        fill(replies, tmp_path / "table.npy")
    assert caught.value.status == 302
    assert replies.rows == ["0-"]


@by_either_client
@pytest.mark.parametrize("attempts", [1, 3])
@pytest.mark.parametrize("breaks", [True, False])
def test_the_client_says_how_often_rows_are_asked_for(
    tmp_path: Path, fill: Callable[..., Any], attempts: int, breaks: bool
) -> None:
    replies = Replies(*[None if breaks else httpx.Response(503) for _ in range(9)])
    kind = geodesicd.ConnectionFailed if breaks else geodesicd.Overloaded
    with pytest.raises(kind):
        fill(replies, tmp_path / "table.npy", attempts)
    assert replies.rows == ["0-"] * attempts


def test_errors_of_a_file_are_those_of_the_table(plane: Mesh, tmp_path: Path) -> None:
    file = tmp_path / "table.npy"
    with pytest.raises(geodesicd.GeodesicError) as caught:
        plane.table_file(file, [0, plane.vertices])
    assert caught.value.code == "index_out_of_range"
    assert caught.value.parameter == "from[1]"
    with pytest.raises(geodesicd.DeadlineExceeded):
        plane.table_file(file, np.arange(2000), method="exact", deadline=0.05)
    with pytest.raises(ValueError, match="at least one row"):
        plane.table_file(file, [])
    with pytest.raises(ValueError, match="float32 or float64"):
        plane.table_file(file, [0], dtype=np.int32)


def test_a_file_by_the_asynchronous_client(plane: Mesh, points: list[int], tmp_path: Path) -> None:
    async def ask() -> Any:
        async with geodesicd.AsyncClient(plane.client.url) as client:
            other = await client.mesh(plane.id)
            return await other.table_file(tmp_path / "a.npy", points)

    expected = plane.table_file(tmp_path / "b.npy", points)
    np.testing.assert_array_equal(asyncio.run(ask()), expected)


def test_a_sparse_table_is_the_full_one_within_max(plane: Mesh, points: list[int]) -> None:
    full = np.array([plane.distance(v)[points] for v in points])
    most = float(np.median(full))
    sparse = plane.sparse_table(points, max=most)
    assert sparse.shape == (40, 40)
    np.testing.assert_array_equal(sparse.to_array(), np.where(full <= most, full, np.inf))
    matrix = sparse.to_scipy()
    assert matrix.nnz == len(sparse.data) == np.count_nonzero(full <= most)
    everything = plane.sparse_table(points, points[:3])
    np.testing.assert_array_equal(everything.to_array(), full[:, :3])


def test_scipy_and_numpy_read_what_the_server_sends(
    plane: Mesh, points: list[int], tmp_path: Path
) -> None:
    from scipy.sparse import load_npz

    with httpx.Client() as http:
        asked = {"from": [f"v:{v}" for v in points], "max": 40.0}
        where = f"{plane.client.url}/v1/meshes/{plane.id}/table"
        npz = http.post(where, json={**asked, "sparse": True, "format": "npz"})
        npy = http.post(where, json={**asked, "stream": True, "format": "npy"})
    (tmp_path / "table.npz").write_bytes(npz.content)
    (tmp_path / "table.npy").write_bytes(npy.content)
    full = np.load(tmp_path / "table.npy")
    assert full.shape == (40, 40)
    matrix = load_npz(tmp_path / "table.npz")
    assert matrix.format == "csr"
    assert matrix.shape == (40, 40)
    assert matrix.has_canonical_format
    sparse = plane.sparse_table(points, max=40.0)
    np.testing.assert_array_equal(matrix.data, sparse.data)
    np.testing.assert_array_equal(matrix.indices, sparse.indices)
    np.testing.assert_array_equal(matrix.indptr, sparse.indptr)
    np.testing.assert_array_equal(sparse.to_array(), full)


def test_too_many_entries_are_asked_for_in_fewer_rows(plane: Mesh) -> None:
    """4,600 points that are all near each other are 21 million entries."""
    points = np.zeros(4600, dtype=np.int64)
    sparse = plane.sparse_table(points, max=0.0)
    assert sparse.shape == (4600, 4600)
    assert len(sparse.data) == 4600**2
    assert not sparse.data.any()


def test_a_client_that_hangs_up_gives_its_slots_back(terrain: Mesh) -> None:
    """Killed as it were: the connection is closed in the middle of the rows."""
    asked = {"from": [f"v:{v}" for v in range(3000)], "method": "exact", "stream": True}
    where = f"{terrain.client.url}/v1/meshes/{terrain.id}/table"
    with httpx.Client(timeout=120) as http, http.stream("POST", where, json=asked) as response:
        assert response.status_code == 200
        next(response.iter_bytes())
    end = time.monotonic() + 60
    while True:
        compute = terrain.client.status()["compute"]
        if compute["running"] == compute["queued"] == 0:
            break
        assert time.monotonic() < end
        time.sleep(0.01)
    assert terrain.client.status()["replies"]["bytes"] == 0
