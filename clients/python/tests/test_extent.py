"""How large a surface is: by the client, and by the command."""

from __future__ import annotations

import asyncio
from pathlib import Path

import numpy as np
import pytest
from command import geodesic

import geodesicd
from geodesicd.bench.mixes import hills


def test_few_fields_tell_the_diameter_of_a_plane(plane: geodesicd.Mesh) -> None:
    found = plane.extent("diameter", method="exact")
    assert found.exact
    assert found.fields < 10
    assert found.value == found.lower == found.upper == pytest.approx(99 * np.sqrt(2))
    assert sorted(found.vertices.tolist()) in ([0, 9999], [99, 9900])
    np.testing.assert_array_equal(found.points, plane.geometry().positions[found.vertices])


def test_against_all_fields(client: geodesicd.Client) -> None:
    mesh = client.upload(hills(9, 3))
    table = np.array([mesh.distance(v, method="exact") for v in range(mesh.vertices)])
    diameter = mesh.extent("diameter", fields=1000, method="exact")
    center = mesh.extent("center", fields=1000, method="exact")
    assert diameter.exact
    assert center.exact
    assert diameter.value == pytest.approx(table.max())
    assert table[tuple(diameter.vertices)] == pytest.approx(table.max())
    assert center.value == pytest.approx(table.max(1).min())
    means = [mesh.measure(v, method="exact").mean for v in range(mesh.vertices)]
    median = mesh.extent("median", fields=1000, method="exact")
    assert median.value == pytest.approx(min(means))
    mean = mesh.extent("mean", fields=1000, method="exact")
    assert (mean.exact, mean.confidence, mean.vertices.shape) == (True, 1, (0,))
    assert min(means) < mean.value < max(means)
    for of, true in (("diameter", diameter), ("center", center), ("median", median)):
        few = mesh.extent(of, fields=5, method="exact")
        assert few.fields <= 5
        assert few.lower * (1 - 1e-9) <= true.value <= few.upper * (1 + 1e-9)
    estimated = mesh.extent("mean", fields=20, method="exact")
    assert (estimated.exact, estimated.confidence) == (False, 0.95)
    assert mesh.extent("mean", fields=1).upper == np.inf


def test_means(client: geodesicd.Client, tmp_path: Path, server: geodesicd.LocalServer) -> None:
    mesh = client.upload(hills(9, 3))
    table = np.array([mesh.distance(v, method="exact") for v in range(mesh.vertices)])
    corners = mesh.geometry().positions[mesh.geometry().triangles]
    areas = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    weights = np.bincount(mesh.geometry().triangles.ravel(), np.repeat(areas, 3))
    expected = table @ weights / weights.sum()
    whole = mesh.extent("means", fields=1000, method="exact")
    assert (whole.exact, whole.fields) == (True, mesh.vertices)
    np.testing.assert_allclose(whole.means, expected, rtol=1e-9)
    assert whole.margins.tolist() == [0] * mesh.vertices
    assert whole.value == pytest.approx(expected @ weights / weights.sum())
    some = mesh.extent("means", fields=20, method="exact")
    assert (some.margins > 0).all()
    assert (np.abs(some.means - expected) <= some.margins).mean() > 0.5
    assert mesh.extent("mean").means.size == 0
    for ending in ("csv", "json", "npy", "glb", "png"):
        file = tmp_path / f"means.{ending}"
        asked = ("--of", "means", "--fields", "20", "--method", "exact", "-o", str(file))
        geodesic(server, "extent", mesh.id, *asked)
        assert file.stat().st_size > 500
    np.testing.assert_array_equal(np.load(tmp_path / "means.npy"), some.means)
    rows = np.loadtxt(tmp_path / "means.csv", delimiter=",", skiprows=1)
    np.testing.assert_allclose(rows[:, 1:], np.array([some.means, some.margins]).T, rtol=1e-6)
    refused = geodesic(server, "extent", mesh.id, "--of", "means", status=2)
    assert "-o FILE" in refused.stderr


def test_asynchronously(server: geodesicd.LocalServer, plane: geodesicd.Mesh) -> None:
    async def ask() -> geodesicd.Extent:
        async with geodesicd.AsyncClient(server.url) as client:
            mesh = await client.mesh(plane.id)
            told: list[float] = []
            answer = await mesh.extent("center", fields=3, progress=told.append)
            assert told[-1] == 1
            return answer

    assert asyncio.run(ask()).value == plane.extent("center", fields=3).value


def test_the_command(server: geodesicd.LocalServer, plane: geodesicd.Mesh) -> None:
    asked = ("--of", "diameter", "--of", "mean", "--fields", "4", "--method", "exact")
    rows = geodesic(server, "extent", plane.id, *asked).stdout.splitlines()
    assert rows[0] == "of,value,lower,upper,exact,vertices"
    diameter = plane.extent("diameter", fields=4, method="exact")
    assert rows[1].startswith("diameter,140.007")
    assert rows[1].endswith(" ".join(map(str, diameter.vertices.tolist())))
    assert rows[2].split(",")[0::4] == ["mean", "0"]
    refused = geodesic(server, "extent", plane.id, "--of", "mean", "--fields", "0", status=1)
    assert "fields" in refused.stderr
