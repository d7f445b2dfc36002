"""Fields and lines as objects of other libraries, and what help says of the methods."""

from __future__ import annotations

import asyncio
import builtins
import inspect
import pydoc
import re
from typing import Any

import numpy as np
import pytest

import geodesicd


@pytest.fixture(scope="module")
def pair(client: geodesicd.Client) -> geodesicd.Mesh:
    """Two triangles apart, and a vertex in neither."""
    vertices = [[0, 0, 0], [3, 0, 0], [0, 4, 0], [9, 9, 9], [5, 0, 0], [6, 0, 0], [5, 1, 0]]
    return client.upload((np.array(vertices, float), np.array([[0, 1, 2], [4, 5, 6]])))


def test_to_trimesh(pair: geodesicd.Mesh) -> None:
    field = pair.distance(0, method="exact")
    made = pair.to_trimesh(field)
    np.testing.assert_array_equal(made.vertices, pair.geometry().positions)
    np.testing.assert_array_equal(made.faces, pair.geometry().triangles)
    np.testing.assert_array_equal(made.vertex_attributes["distance"], field)
    colours = made.visual.vertex_colors
    assert colours.shape == (7, 4)
    assert (colours[np.isinf(field), :3] == 184).all()
    assert len(np.unique(colours[:3], axis=0)) == 3
    assert pair.client.upload(made).id == pair.id
    assert pair.to_trimesh().vertices.shape == (7, 3)


def test_to_pyvista(pair: geodesicd.Mesh) -> None:
    field, labels = pair.distance([0, 1], labels=True, method="exact")
    made = pair.to_pyvista(field, labels=labels)
    np.testing.assert_array_equal(made.points, pair.geometry().positions)
    np.testing.assert_array_equal(made.point_data["labels"], labels)
    shown = made.active_scalars
    np.testing.assert_array_equal(np.isnan(shown), np.isinf(field))
    np.testing.assert_array_equal(shown[:3], field[:3])
    assert pair.client.upload(made).id == pair.id
    assert pair.to_pyvista().n_cells == 2


def test_draw(pair: geodesicd.Mesh) -> None:
    figure = pair.draw(pair.distance(0), title="two", size=(3, 2), dpi=50)
    figure.canvas.draw()
    assert figure.axes[0].get_title() == "two"
    for made in (pair.draw, pair.to_trimesh, pair.to_pyvista):
        with pytest.raises(ValueError, match=r"shape \(7,\), not \(6,\)"):
            made(np.zeros(6))

    async def asynchronously() -> int:
        async with geodesicd.AsyncClient(pair.client.url) as client:
            mesh = await client.mesh(pair.id)
            return len((await mesh.to_trimesh(await mesh.distance(0))).vertices)

    assert asyncio.run(asynchronously()) == 7


def arc(line: Any) -> float:
    return float(line.compute_arc_length()["arc_length"].max())


def test_lines(holes: geodesicd.Mesh) -> None:
    path = holes.path(0, 9999)
    assert arc(path.to_pyvista()) == pytest.approx(path.length)
    assert path.to_trimesh().length == pytest.approx(path.length)
    assert path.to_pyvista().n_lines == 1
    ring = holes.isolines(0, levels=[20.0])[0]
    assert arc(ring.to_pyvista()) == pytest.approx(ring.length)
    straight = holes.trace(0, 9, direction=(1, 1, 0))
    assert straight.to_pyvista().n_points == len(straight.points)


def test_the_libraries_are_not_required(
    pair: geodesicd.Mesh, monkeypatch: pytest.MonkeyPatch
) -> None:
    field = pair.distance(0)
    known = builtins.__import__

    def without(name: str, *arguments: Any, **named: Any) -> Any:
        if name.partition(".")[0] in ("trimesh", "pyvista", "matplotlib"):
            raise ModuleNotFoundError(f"No module named {name!r}")
        return known(name, *arguments, **named)

    monkeypatch.setattr(builtins, "__import__", without)
    monkeypatch.setattr("importlib.import_module", without)
    with pytest.raises(ImportError, match="pip install trimesh"):
        pair.to_trimesh(field)
    with pytest.raises(ImportError, match="pip install pyvista"):
        pair.to_pyvista(field)
    with pytest.raises(ImportError, match="pip install matplotlib"):
        pair.draw(field)


@pytest.mark.parametrize("kind", [geodesicd.Mesh, geodesicd.AsyncMesh])
def test_help_shows_the_real_signature(kind: type) -> None:
    signature = inspect.signature(kind.table)  # type: ignore[attr-defined]
    assert list(signature.parameters)[:3] == ["self", "sources", "targets"]
    assert signature.return_annotation == "FloatArray"
    told = pydoc.plain(pydoc.render_doc(kind.table))  # type: ignore[attr-defined]
    assert "sources: 'PointsLike'" in told
    assert "tolerance: 'float | None' = None" in told
    assert "infinite where unreached" in told
    # Python 3.13 puts each parameter of a long signature on a line of its own.
    assert re.search(r"table\(\s*self,\s*sources", told)
    assert re.search(r"path\(\W*self", pydoc.plain(pydoc.render_doc(kind)))


@pytest.mark.parametrize("kind", [geodesicd.Mesh, geodesicd.AsyncMesh])
def test_help_tells_every_option_by_its_name(kind: type) -> None:
    for query in ("table_file", "sparse_table", "path", "isolines"):
        told = inspect.signature(getattr(kind, query)).parameters
        assert {"method", "bound", "walls", "costs", "deadline", "progress"} <= set(told), query
    for query in ("logmap", "voronoi", "cells_glb", "loop", "annotated"):
        told = inspect.signature(getattr(kind, query)).parameters
        assert {"method", "bound", "walls", "deadline", "progress"} <= set(told), query
        assert "costs" not in told, query
    for query in ("trace", "nearest"):
        told = inspect.signature(getattr(kind, query)).parameters
        assert {"walls", "deadline", "progress"} <= set(told), query
        assert "method" not in told, query


def test_an_option_that_a_query_does_not_take_is_refused(pair: geodesicd.Mesh) -> None:
    refused = r"^{}\(\) got an unexpected keyword argument '{}'$"
    with pytest.raises(TypeError, match=refused.format("path", "wall")):
        pair.path(0, 1, wall="v:0;v:1")  # type: ignore[call-arg]
    with pytest.raises(TypeError, match=refused.format("logmap", "costs")):
        pair.logmap(0, costs=geodesicd.Costs(slope="tobler"))  # type: ignore[call-arg]
    with pytest.raises(TypeError, match=refused.format("table_file", "stream")):
        pair.table_file("nowhere.npy", 0, stream=False)  # type: ignore[call-arg]
