"""Points on a surface, as a caller has them and as the server reads them.

One point is an int (a source vertex), a *tuple* of three numbers or a float array of shape
(3,) (a place in space: whatever of the surface is closest), one of the classes below, a
:class:`~geodesicd.SurfacePoint` from an earlier reply, a text of the URL grammar (``"v:12"``)
or a mapping as the contract's JSON has it. Several points are a *list* of those, an integer
array of shape (n,) (vertices) or a float array of shape (n, 3) (places). So ``(0, 5, 9)`` is
one place and ``[0, 5, 9]`` three vertices.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, TypeAlias, cast, runtime_checkable

import numpy as np
from numpy.typing import NDArray

Triple: TypeAlias = tuple[float, float, float] | Sequence[float] | NDArray[Any]


def triple(value: Triple, what: str) -> tuple[float, float, float]:
    """Three finite floats.

    Raises:
        ValueError: not three, or not finite.
    """
    numbers = np.asarray(value, dtype=np.float64)
    if numbers.shape != (3,) or not np.isfinite(numbers).all():
        raise ValueError(f"{what} takes three finite numbers, not {value!r}")
    x, y, z = numbers.tolist()
    return x, y, z


def _checked_offset(offset: float) -> float:
    if not (math.isfinite(offset) and offset >= 0):
        raise ValueError(f"an offset is a distance, not {offset!r}")
    return float(offset)


@runtime_checkable
class Point(Protocol):
    """What all kinds of points can do."""

    def text(self) -> str | None:
        """As in a URL; None if the URL grammar cannot say it."""

    def json(self) -> Any:
        """As in a JSON body."""


@dataclass(frozen=True)
class Vertex:
    """A source vertex by its index, counted from 0 in the order of the file. ``offset`` is
    the distance (mesh units) that a front starts with there; sources only."""

    index: int
    offset: float = 0.0

    def __post_init__(self) -> None:
        _checked_offset(self.offset)

    def text(self) -> str | None:
        """``v:12``."""
        return None if self.offset else f"v:{int(self.index)}"

    def json(self) -> Any:
        """``{"vertex": 12}``."""
        return _with_offset({"vertex": int(self.index)}, self.offset)


@dataclass(frozen=True)
class OnFace:
    """A place on a source face: ``bary`` are the weights of its three corners, not negative,
    with the sum 1. ``offset`` as for :class:`Vertex`."""

    face: int
    bary: Triple
    offset: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "bary", triple(self.bary, "bary"))
        _checked_offset(self.offset)

    def text(self) -> str | None:
        """``f:40,0.2,0.3``, whose third weight is the rest."""
        if self.offset:
            return None
        return f"f:{int(self.face)},{float(self.bary[0])!r},{float(self.bary[1])!r}"

    def json(self) -> Any:
        """``{"face": 40, "bary": [0.2, 0.3, 0.5]}``."""
        return _with_offset({"face": int(self.face), "bary": list(self.bary)}, self.offset)


@dataclass(frozen=True)
class Xyz:
    """Whatever of the surface is closest to a place in space (mesh units). Farther away than
    ``max_snap`` (mesh units) is refused with ``snap_too_far``. ``offset`` as for
    :class:`Vertex`."""

    xyz: Triple
    max_snap: float | None = None
    offset: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "xyz", triple(self.xyz, "xyz"))
        _checked_offset(self.offset)

    def text(self) -> str | None:
        """``p:1,2,3``."""
        if self.offset or self.max_snap is not None:
            return None
        return "p:" + ",".join(repr(float(number)) for number in self.xyz)

    def json(self) -> Any:
        """``{"xyz": [1, 2, 3], "max_snap": 0.1}``."""
        body: dict[str, Any] = {"xyz": list(self.xyz)}
        if self.max_snap is not None:
            body["max_snap"] = float(self.max_snap)
        return _with_offset(body, self.offset)


@dataclass(frozen=True)
class Ray:
    """The first hit of a ray, a mouse pick: from ``origin`` towards ``direction``, which need
    not have length 1. A miss is refused with ``no_hit``. ``offset`` as for :class:`Vertex`."""

    origin: Triple
    direction: Triple
    offset: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "origin", triple(self.origin, "origin"))
        object.__setattr__(self, "direction", triple(self.direction, "direction"))
        _checked_offset(self.offset)

    def text(self) -> str | None:
        """``ray:0,0,9,0,0,-1``."""
        if self.offset:
            return None
        return "ray:" + ",".join(repr(float(n)) for n in (*self.origin, *self.direction))

    def json(self) -> Any:
        """``{"ray": {"origin": [0, 0, 9], "direction": [0, 0, -1]}}``."""
        ray = {"origin": list(self.origin), "direction": list(self.direction)}
        return _with_offset({"ray": ray}, self.offset)


@dataclass(frozen=True)
class _Text:
    """A point in the URL grammar, which the server reads and, if need be, refuses."""

    value: str

    def text(self) -> str | None:
        return self.value

    def json(self) -> Any:
        return self.value


@dataclass(frozen=True)
class _Json:
    """A point as a JSON body has it, likewise."""

    value: Mapping[str, Any]

    def text(self) -> str | None:
        return None

    def json(self) -> Any:
        return dict(self.value)


def _with_offset(body: dict[str, Any], offset: float) -> dict[str, Any]:
    if offset:
        body["offset"] = float(offset)
    return body


PointLike: TypeAlias = (
    "int | np.integer[Any] | tuple[float, float, float] | NDArray[Any] | str"
    " | Mapping[str, Any] | Point"
)
PointsLike: TypeAlias = "PointLike | Sequence[PointLike] | NDArray[Any]"


def point_of(value: PointLike) -> Point:
    """One point.

    Raises:
        TypeError: it is none; the message says what would be one.
        ValueError: three numbers that are not finite.
    """
    if isinstance(value, str):
        return _Text(value)
    if isinstance(value, Mapping):
        return _Json(value)
    if isinstance(value, int | np.integer) and not isinstance(value, bool):
        return Vertex(int(value))
    if isinstance(value, tuple):
        return Xyz(value)
    if isinstance(value, np.ndarray):
        if value.ndim == 0 and np.issubdtype(value.dtype, np.integer):
            return Vertex(int(value))
        if value.shape == (3,) and np.issubdtype(value.dtype, np.floating):
            return Xyz(value)
        raise TypeError(
            f"one point is a float array of shape (3,), not {value.dtype} {value.shape}"
        )
    if isinstance(value, Point):
        return value
    raise TypeError(
        f"{value!r} is no point: give a vertex index, a tuple (x, y, z), Vertex, OnFace, Xyz or Ray"
    )


def points_of(value: PointsLike) -> list[Point]:
    """Several points, or one as a list of one.

    Raises:
        TypeError, ValueError: as :func:`point_of`.
    """
    if isinstance(value, np.ndarray):
        if value.ndim == 1 and np.issubdtype(value.dtype, np.integer):
            return [Vertex(int(index)) for index in value]
        if value.ndim == 2 and value.shape[1] == 3:
            return [Xyz(place) for place in value]
        return [point_of(value)]
    # A tuple of three numbers is a place; a tuple of points is several.
    place = isinstance(value, tuple) and all(isinstance(n, int | float | np.number) for n in value)
    if isinstance(value, Sequence) and not isinstance(value, str) and not place:
        if any(isinstance(one, float | np.floating) for one in value):
            raise TypeError("a list is several points; write a place in space as a tuple (x, y, z)")
        return [point_of(cast("PointLike", one)) for one in value]
    return [point_of(cast("PointLike", value))]
