"""Regions of a surface, as a caller has them and as the server reads them: what a query is to keep
to (``within``), what it is to leave out (``forbid``) and which lines no path crosses (``walls``).

One region is a text of the URL grammar (``"faces:0-99"``, ``"part:2"``, ``"material:glass"``,
``"sphere:X,Y,Z,R"``, ``"box:X,Y,Z,X,Y,Z"``), a mapping as the contract's JSON has it (``{"sphere":
{"center": (0, 0, 0), "radius": 2}}``), an integer array of source faces, or a boolean one with an
element for each source face; one of another length is refused. ``{"part": name}`` and
``{"material": name}`` are all parts and materials of that name, a number instead of a name is a
place in the metadata, and ``{"material": None}`` are the faces without a material. ``{"label":
{"attribute": "_SEG", "value": 3}}`` are the faces whose corners all have that number in an
attribute of the file. A list of those is their union. Of spheres and boxes a region has the faces
whose centroids lie in them. ``{"inside": points}``, or
``"inside:1;2;3"``, is what a line through points and back to the first goes round; points are
as :mod:`geodesicd.points` says.

One wall is a text (``"1;2"``, as in a URL ``"v:1;v:2"``), a mapping ``{"points": points}``, an
integer array of shape (n,) (vertices in order) or a float array of shape (n, 3) (places in order).
It goes from point to point by shortest paths, and is closed if it ends with the point that it
begins with. A list of those is several walls.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from .masks import is_mask
from .points import kind_of, points_of, triple, with_vertices

RegionLike: TypeAlias = "str | Mapping[str, Any] | NDArray[Any]"
RegionsLike: TypeAlias = "RegionLike | Sequence[RegionLike]"

WallLike: TypeAlias = "str | Mapping[str, Any] | NDArray[Any]"
WallsLike: TypeAlias = "WallLike | Sequence[WallLike]"


@dataclass(frozen=True)
class Region:
    """One shape: its text, or if it is none that a URL can say, its JSON."""

    written: str | None
    value: Any
    mask: int | None = None  # how many elements the mask has that it was made of

    def text(self) -> str | None:
        """As in a URL."""
        return self.written

    def json(self) -> Any:
        """As in a JSON body."""
        return self.value if self.written is None else self.written


def region_of(value: RegionLike) -> Region:
    """One region.

    Raises:
        TypeError: it is none; the message says what would be one.
        ValueError: an array without a face, or numbers that are not finite.
    """
    if isinstance(value, Region):
        return value
    if isinstance(value, str):
        is_line = value.startswith("inside:")
        return Region(with_vertices("inside:", value) if is_line else value, None)
    if isinstance(value, Mapping):
        return _shape(value)
    if isinstance(value, np.ndarray) and is_mask(value):
        return _faces(np.flatnonzero(value), mask=len(value))
    if isinstance(value, np.ndarray) and value.ndim == 1 and np.issubdtype(value.dtype, np.integer):
        return _faces(value)
    raise TypeError(
        f"{kind_of(value)} is no region: give a text such as 'faces:0-99', a mapping such "
        "as {'part': 2}, or an array of faces"
    )


def regions_of(value: RegionsLike | None) -> list[Region] | None:
    """Several regions, or one as a list of one; None stays None."""
    if value is None:
        return None
    if isinstance(value, list | tuple):
        if not value:
            raise ValueError("there is no region in this list; None is for the whole surface")
        return [region_of(one) for one in value]
    return [region_of(value)]  # type: ignore[arg-type]


def walls_of(value: WallsLike | None) -> list[Region] | None:
    """Several walls, or one as a list of one; None stays None.

    Raises:
        TypeError: there is none among them; the message says what would be one.
    """
    if value is None:
        return None
    if isinstance(value, list | tuple):
        if not value:
            raise ValueError("there is no wall in this list; None is for no walls")
        return [_wall(one) for one in value]
    return [_wall(value)]  # type: ignore[arg-type]


def _wall(value: WallLike) -> Region:
    if isinstance(value, Region):
        return value
    if isinstance(value, str):
        return Region(with_vertices("", value), None)
    if isinstance(value, Mapping):
        if set(value) == {"points"}:
            return _line("", "points", value["points"])
        return Region(None, dict(value))
    if isinstance(value, np.ndarray) and value.ndim == 1 and np.issubdtype(value.dtype, np.integer):
        return _line("", "points", value)
    if isinstance(value, np.ndarray) and value.ndim == 2 and value.shape[1] == 3:
        return _line("", "points", value.astype(np.float64))
    raise TypeError(
        f"{kind_of(value)} is no wall: give a text such as 'v:1;v:2', a mapping {{'points': "
        "points}, an array of vertices, or one of places of shape (n, 3)"
    )


def _line(kind: str, name: str, value: Any) -> Region:
    """Points in a row: as text where a URL can say them all."""
    points = points_of(value if isinstance(value, np.ndarray) else list(value))
    texts = [point.text() for point in points]
    if points and None not in texts:
        return Region(kind + ";".join(text for text in texts if text is not None), None)
    return Region(None, {name: [point.json() for point in points]})


def _faces(faces: NDArray[Any], mask: int | None = None) -> Region:
    """Ascending, each once, what lies side by side as one range."""
    faces = np.unique(faces)
    if not len(faces):
        raise ValueError("there is no face in this array; None is for the whole surface")
    if faces[0] < 0:
        raise ValueError(f"faces are counted from 0; {faces[0]} is none")
    breaks = np.flatnonzero(np.diff(faces) != 1)
    firsts = faces[np.concatenate([[0], breaks + 1])].tolist()
    lasts = faces[np.concatenate([breaks, [len(faces) - 1]])].tolist()
    texts = (f"{a}" if a == b else f"{a}-{b}" for a, b in zip(firsts, lasts, strict=True))
    return Region("faces:" + ",".join(texts), None, mask)


def _shape(value: Mapping[str, Any]) -> Region:
    """A URL can say what is well formed; the server refuses the rest."""
    match dict(value):
        case {"part": called, **rest} if not rest and _is_called(called):
            return Region(_named("part", called), None)
        case {"material": None, **rest} if not rest:
            return Region("material:none", None)
        case {"material": called, **rest} if not rest and _is_called(called):
            return Region(_named("material", called), None)
        case {"label": Mapping() as label, **rest} if not rest and _has(label, *_LABEL):
            called, number = label["attribute"], label["value"]
            if isinstance(called, str) and isinstance(number, float | int):
                return _numbers(f"label:{called}=", number)
        case {"sphere": Mapping() as ball, **rest} if not rest and _has(ball, "center", "radius"):
            if isinstance(ball["radius"], float | int) and len(ball["center"]) == 3:
                return _numbers("sphere:", *triple(ball["center"], "center"), ball["radius"])
        case {"box": Mapping() as box, **rest} if not rest and _has(box, "min", "max"):
            if len(box["min"]) == len(box["max"]) == 3:
                return _numbers("box:", *triple(box["min"], "min"), *triple(box["max"], "max"))
        case {"faces": np.ndarray() as faces, **rest} if not rest:
            return region_of(faces)
        case {"inside": list() | tuple() | np.ndarray() as points, **rest} if not rest:
            return _line("inside:", "inside", points)
    return Region(None, dict(value))


_LABEL = ("attribute", "value")


def _is_called(value: Any) -> bool:
    return isinstance(value, int | str) and not isinstance(value, bool)


def _named(kind: str, value: int | str) -> str:
    """A place, or a name: in quotes where it would be taken for something else."""
    if isinstance(value, int):
        return f"{kind}:{value}"
    is_plain = bool(value) and value != "none" and not re.fullmatch('[0-9]+|".*"', value, re.DOTALL)
    return f"{kind}:{value}" if is_plain else f'{kind}:"{value}"'


def _has(value: Mapping[str, Any], *names: str) -> bool:
    return set(value) == set(names)


def _numbers(begin: str, *numbers: float) -> Region:
    return Region(begin + ",".join(repr(float(one)) for one in numbers), None)
