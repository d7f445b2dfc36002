"""A query's parameters as a request: in a URL, which caches can keep, or in a JSON body."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any
from urllib.parse import urlencode

import numpy as np
from numpy.typing import DTypeLike

from .costs import costing
from .flows import Request
from .masks import check_masks
from .points import Point, point_of, points_of
from .surface_regions import Region, regions_of, walls_of

_LONGEST_URL = 4000  # what proxies and logs bear; longer ones are asked in a body


def encode(mesh: str, query: str, parameters: Mapping[str, Any]) -> Request:
    """A query as GET, which caches can keep, or as POST if a URL cannot say it. Parameters that
    are None, and empty lists, are left out.

    Raises:
        ValueError: a mask of faces has not one element for each of them.
    """
    check_masks(mesh, parameters)
    given = {k: v for k, v in parameters.items() if v is not None and not _is_empty(v)}
    where = f"/v1/meshes/{mesh}/{query}"
    texts = [
        (name, _text(one))
        for name, value in given.items()
        for one in (value if isinstance(value, list) else [value])
    ]
    if all(text is not None for _, text in texts):
        target = f"{where}?{urlencode(texts, safe=':,')}"
        if len(target) <= _LONGEST_URL:
            return Request("GET", target)
    return Request("POST", where, {"Content-Type": "application/json"}, _bytes(body_json(given)))


def body_json(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """A query's parameters as its JSON body has them."""
    return {
        name: [_json(one) for one in value] if isinstance(value, list | tuple) else _json(value)
        for name, value in parameters.items()
        if value is not None and not _is_empty(value)
    }


def _is_empty(value: Any) -> bool:
    return isinstance(value, list) and not value


def _text(value: Any) -> str | None:
    if isinstance(value, Point):
        return value.text()
    if isinstance(value, bool):
        return "1" if value else "0"
    if isinstance(value, tuple):
        return ",".join(_number(one) for one in value)
    return value if isinstance(value, str) else _number(value)


def _number(value: Any) -> str:
    """Of NumPy's numbers as of Python's: NumPy 2 writes them as ``np.float64(1.0)``."""
    return repr(value.item() if isinstance(value, np.generic) else value)


def _json(value: Any) -> Any:
    if isinstance(value, Point):
        return value.json()
    return value.item() if isinstance(value, np.generic) else value


def _bytes(document: Any) -> bytes:
    return json.dumps(document, allow_nan=False, separators=(",", ":")).encode()


_POINTS = ("from", "to", "at", "via", "point", "through", "around")


def as_points(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Parameters by the contract's names, with all that are points as points."""
    found = dict(parameters)
    for name in _POINTS:
        if (value := found.get(name)) is not None:
            found[name] = points_of(value) if isinstance(value, list) else point_of(value)
    for name in ("within", "forbid"):
        if (value := found.get(name)) is not None:
            found[name] = regions_of(value)
    if (value := found.get("walls")) is not None:
        found["walls"] = walls_of(value)
    if (costs := found.pop("costs", None)) is not None:
        found |= costing(costs)
    for name in ("weights", "slope"):  # a URL says texts alone
        if (value := found.get(name)) is not None and not isinstance(value, str):
            several = value if isinstance(value, list) else [value]
            found[name] = [_verbatim(one) for one in several]
    for name in ("direction", "normal", "up"):
        if found.get(name) is not None:
            found[name] = tuple(found[name])
    return found


def _verbatim(value: Any) -> Any:
    return Region(None, value) if isinstance(value, Mapping | list | tuple) else value


def milliseconds(seconds: float | None) -> int | None:
    """A deadline as the server takes it: at least 1."""
    return None if seconds is None else max(1, math.ceil(seconds * 1000))


def as_bound(max: float | None) -> float | None:
    """A bound as the server takes it: no bound is to leave it out."""
    return None if max is None or max == math.inf else max


def format_of(dtype: DTypeLike) -> str:
    """The format of bare arrays of that dtype.

    Raises:
        ValueError: neither float32 nor float64.
    """
    wanted = np.dtype(dtype)
    if wanted not in (np.dtype(np.float32), np.dtype(np.float64)):
        raise ValueError(f"distances are float32 or float64, not {wanted}")
    return "f32" if wanted == np.dtype(np.float32) else "f64"
