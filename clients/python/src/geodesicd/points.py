"""Points on a surface, as a caller has them and as the server reads them.

One point is an integer, Python's or NumPy's (a source vertex), a tuple of three numbers or a float
array of shape (3,) (a place in space: whatever of the surface is closest), one of the classes
below, a :class:`~geodesicd.SurfacePoint` from an earlier reply, a text of the URL grammar
(``"v:12"``) or a mapping as the contract's JSON has it. Several points are a list of those, an
integer array of shape (n,) (vertices) or a float array of shape (n, 3) (places).

Three numbers can be read in two ways. With a fraction or a point among them, as in
``[0.0, 5, 9]``, they are a place, in a tuple or in a list. Three integers in a list are three
vertices. Three integers in a tuple are a place where one point is asked for, or inside a list;
where several could stand they are refused: write ``[0, 5, 9]`` for vertices, ``(0.0, 5.0, 9.0)``
or ``Xyz`` for a place.
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


def _is_integer(value: object) -> bool:
    return isinstance(value, int | np.integer) and not isinstance(value, bool)


def _is_number(value: object) -> bool:
    return _is_integer(value) or isinstance(value, float | np.floating)


def _are_numbers(value: object) -> bool:
    return isinstance(value, tuple | list) and len(value) > 0 and all(_is_number(n) for n in value)


def _as_array(value: object) -> NDArray[Any] | None:
    """What is an array, or makes one, as a series of pandas does."""
    if isinstance(value, np.ndarray):
        return value
    if hasattr(value, "__array__") and not isinstance(value, np.generic | Point):
        return np.asarray(value)
    return None


def kind_of(value: object) -> str:
    """What it is, for a person: ``an int``, ``an array of bool``."""
    if isinstance(value, np.ndarray):
        return f"an array of {value.dtype} with the shape {value.shape}"
    name = type(value).__name__
    return f"{'an' if name[0] in 'aeioAEIO' else 'a'} {name}"


def _wrong(value: object) -> TypeError:
    """Why this is no point, and what would be."""
    told = kind_of(value)
    if _is_number(value):
        why = f"{value!r} is no vertex, which is an integer: int({value!r}), if that is meant"
        return TypeError(why)
    if isinstance(value, bool | np.bool_):
        why = "np.flatnonzero(mask) makes vertices of a mask"
    elif isinstance(value, list | tuple | set | frozenset):
        why = "here is one point only; a place is a tuple (x, y, z)"
        told = repr(value) if len(value) < 9 else told
    elif isinstance(value, np.ndarray):
        if value.dtype == np.bool_:
            why = "np.flatnonzero(mask) makes vertices of a mask"
        elif value.shape == (3,) and np.issubdtype(value.dtype, np.integer):
            why = "three vertices, where one point is asked for? A place has floats"
        elif value.ndim == 1 and np.issubdtype(value.dtype, np.floating):
            why = "vertices are integers: array.astype(int)"
        else:
            why = "vertices are integers with the shape (n,), places floats with the shape (n, 3)"
    else:
        why = (
            "give a vertex as an integer, a place as a tuple (x, y, z), Vertex, OnFace, Xyz or Ray"
        )
    return TypeError(f"{told} is no point: {why}")


def point_of(value: PointLike) -> Point:
    """One point.

    Raises:
        TypeError: it is none; the message says what would be one.
        ValueError: three numbers that are not finite.
    """
    if isinstance(value, str):
        return _Text(with_vertices("curve:", value) if value.startswith("curve:") else value)
    if isinstance(value, Mapping):
        return _Json(value)
    if _is_integer(value):
        return Vertex(int(cast("int", value)))
    if _are_numbers(value):
        numbers = cast("Sequence[float]", value)
        if len(numbers) != 3:
            raise TypeError(f"{value!r} is no place: that has three numbers, (x, y, z)")
        if isinstance(value, list) and all(_is_integer(n) for n in numbers):
            raise TypeError(
                f"{value!r} is three vertices, where one point is asked for; a place is the tuple "
                f"{tuple(numbers)!r}"
            )
        return Xyz(numbers)
    if (array := _as_array(value)) is not None:
        if array.ndim == 0 and np.issubdtype(array.dtype, np.integer):
            return Vertex(int(array))
        if array.shape == (3,) and np.issubdtype(array.dtype, np.floating):
            return Xyz(array)
        raise _wrong(array)
    if isinstance(value, Point):
        return value
    raise _wrong(value)


def with_vertices(kind: str, text: str) -> str:
    """The text of a line, in which a number alone is a vertex: ``curve:0;9`` is
    ``curve:v:0;v:9``."""
    corners = text.removeprefix(kind).split(";")
    return kind + ";".join(f"v:{one}" if one.isdecimal() else one for one in corners)


def points_of(value: PointsLike) -> list[Point]:
    """Several points, or one as a list of one.

    Raises:
        TypeError, ValueError: as :func:`point_of`.
    """
    if (array := _as_array(value)) is not None:
        if array.ndim == 1 and np.issubdtype(array.dtype, np.integer):
            return [Vertex(int(index)) for index in array]
        if array.ndim == 2 and array.shape[1] == 3 and array.dtype != np.bool_:
            return [Xyz(place) for place in array]
        return [point_of(array)]
    if _are_numbers(value):
        numbers = cast("Sequence[float]", value)
        vertices = all(_is_integer(n) for n in numbers)
        if isinstance(value, tuple) and vertices:
            if len(numbers) == 3:
                raise TypeError(
                    f"{value!r} could be a place or three vertices: write {list(numbers)!r} for "
                    f"vertices, {tuple(float(n) for n in numbers)!r} or Xyz for a place"
                )
            raise TypeError(f"several vertices are a list: {list(numbers)!r}")
        if not vertices:
            if len(numbers) == 3:
                return [Xyz(numbers)]
            raise TypeError(
                f"{value!r} has a number that is no vertex, which is an integer; a place has three "
                "numbers, (x, y, z)"
            )
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [point_of(cast("PointLike", one)) for one in value]
    return [point_of(cast("PointLike", value))]


def some_points_of(value: PointsLike) -> list[Point]:
    """The same of points of which there may be none."""
    return [] if isinstance(value, tuple) and not value else points_of(value)
