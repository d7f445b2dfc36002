"""A server that a proxy publishes below a path (``--base-path``), which takes it off or leaves it
on: the client's URL ends with it or not."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import geodesicd


@pytest.fixture(scope="module")
def published() -> Iterator[str]:
    """The URL of a server that is published at /tools/geo."""
    server = geodesicd.serve(flags=["--log-level", "warn", "--base-path", "/tools/geo"])
    yield server.start()
    server.stop()


@pytest.mark.parametrize("below", ["", "/", "/tools/geo", "/tools/geo/"])
def test_everything_works_at_either_url(published: str, samples: Path, below: str) -> None:
    told: list[float] = []
    with geodesicd.Client(published + below) as client:
        mesh = client.upload(samples / "plane.glb", name="plane", probe=False, progress=told.append)
        assert client.mesh("plane").prepare(progress=told.append).id == mesh.id
        field = mesh.distance(0, method="exact", progress=told.append)
        np.testing.assert_array_equal(field, mesh.distance(0, method="exact"))
        path = mesh.path(0, 99, progress=told.append)
        assert path.length == pytest.approx(99)
        assert told[-1] == 1
        assert [one.length for one in mesh.paths([(0, 9), (0, 99)])] == pytest.approx([9, 99])
        assert [one.id for one in client.meshes(page_size=1)] == [mesh.id]
        with pytest.raises(geodesicd.GeodesicError) as caught:
            mesh.path(0, 77777, progress=told.append)
        assert caught.value.code == "index_out_of_range"
        assert client.status()["jobs"]["ended"] == 0  # none is left lying about

    async def ask() -> float:
        async with geodesicd.AsyncClient(published + below) as client:
            mesh = await client.mesh("plane")
            return (await mesh.path(0, 99, progress=told.append)).length

    assert asyncio.run(ask()) == pytest.approx(99)
