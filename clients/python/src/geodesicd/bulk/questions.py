"""What can be asked of many meshes, and the answers as arrays that can be written."""

from __future__ import annotations

import inspect
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import queries, spreads, tables
from ..client import Mesh
from ..costs import costing
from ..encoding import as_bound, body_json
from ..points import point_of, points_of
from ..surface_regions import regions_of, walls_of


@dataclass(frozen=True)
class Columns:
    """An answer: arrays that have their first axes in common. An array may have one axis more, as
    places have.

    Attributes:
        axes: what the common axes count, such as ``("vertex",)``.
        arrays: by name.
        first: the number of the first entry along the first axis.
    """

    axes: tuple[str, ...]
    arrays: Mapping[str, NDArray[Any]]
    first: int = 0


def _distance(mesh: Mesh, asked: Mapping[str, Any]) -> Columns:
    return Columns(("vertex",), {"distance": mesh.distance(**asked)})


def _regions(mesh: Mesh, asked: Mapping[str, Any]) -> Columns:
    found = mesh.regions(**asked)
    return Columns(("vertex",), {"distance": found.distances, "label": found.labels})


def _distance_at(mesh: Mesh, asked: Mapping[str, Any]) -> Columns:
    return Columns(("target",), {"distance": mesh.distance_at(**asked)})


def _table(mesh: Mesh, asked: Mapping[str, Any]) -> Columns:
    return Columns(("source", "target"), {"distance": mesh.table(**asked)})


def _path(mesh: Mesh, asked: Mapping[str, Any]) -> Columns:
    path = mesh.path(**asked)
    arrays = {"xyz": path.points, "face": path.faces, "along": path.along}
    return Columns(("point",), arrays)


def _samples(mesh: Mesh, asked: Mapping[str, Any]) -> Columns:
    found = mesh.samples(**asked)
    arrays = {"vertex": found.vertices, "xyz": found.points, "radius": found.radii}
    return Columns(("sample",), arrays)


# By the names of the methods of Mesh: what each takes, and how it is asked.
_QUESTIONS: dict[str, tuple[Callable[..., Any], Callable[[Mesh, Mapping[str, Any]], Columns]]] = {
    "distance": (queries.distance, _distance),
    "regions": (queries.regions, _regions),
    "distance_at": (queries.distance_at, _distance_at),
    "table": (tables.table, _table),
    "path": (queries.path, _path),
    "samples": (spreads.samples, _samples),
}
_ONE_POINT = ("source", "target")
_POINTS = ("sources", "targets", "at", "via", "covered")
_REGIONS = ("within", "forbid")


def answer(name: str, mesh: Mesh, asked: Mapping[str, Any]) -> Columns:
    """Asks a mesh. GeodesicError: the server refuses."""
    return _QUESTIONS[name][1](mesh, asked)


def checked(name: str, asked: Mapping[str, Any]) -> dict[str, Any]:
    """The question in words of JSON, by which it is known again.

    Raises:
        ValueError: no such question. TypeError: it does not take that.
    """
    if name not in _QUESTIONS:
        raise ValueError(f"{name!r} is no question to many meshes: {', '.join(_QUESTIONS)}")
    try:
        inspect.signature(_QUESTIONS[name][0]).bind("", **asked)
    except TypeError as error:
        raise TypeError(f"{name}: {error}") from None
    if asked.get("progress") is not None:
        raise TypeError(f"{name}: progress is that of the whole run")
    # No bound is none, and a deadline changes no answer.
    given = {**asked, "max": as_bound(asked.get("max")), "deadline": None}
    plain = {key: _plain(key, value) for key, value in given.items() if value is not None}
    # What JSON cannot say is told now, before anything is written.
    found: dict[str, Any] = json.loads(json.dumps({"question": name, **plain}))
    return found


def _plain(key: str, value: Any) -> Any:
    if key in _ONE_POINT:
        return point_of(value).json()
    if key in _POINTS:
        return [] if isinstance(value, tuple) and not value else plain_points(value)
    if key in _REGIONS:
        return [region.json() for region in regions_of(value) or ()]
    if key == "walls":
        return [wall.json() for wall in walls_of(value) or ()]
    if key == "costs":
        return body_json(costing(value))
    if key == "dtype":
        return np.dtype(value).name
    return value.item() if isinstance(value, np.generic) else value


def plain_points(points: Any) -> list[Any]:
    """Points in words of JSON."""
    return [point.json() for point in points_of(points)]
