"""What a field starts from besides points: curves, boundaries and whole faces.

They stand wherever sources do (``mesh.distance(Curve([1, 7, 9]))``), alone or in a list with
points, and are rows of tables and sites of cells.
A curve may be a text, too, as in a URL, where vertices may be numbers alone: ``"curve:1;7;9"``.
The methods ``exact`` and ``chen_han`` measure from the lines themselves, not from points on them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from .points import Point, PointsLike, points_of
from .surface_regions import RegionLike, region_of


@dataclass(frozen=True)
class Curve:
    """A curve along points: from each to the next straight within a face, or else by the shortest
    path. ``closed``: and from the last to the first.

    Raises:
        ValueError: fewer than two points, or than three of a closed one.
    """

    points: PointsLike
    closed: bool = False

    def __post_init__(self) -> None:
        least = 3 if self.closed else 2
        if len(self._points()) < least:
            raise ValueError(
                f"a {'closed ' if self.closed else ''}curve has {least} points at least"
            )

    def _points(self) -> list[Point]:
        return points_of(self.points)

    def text(self) -> str | None:
        """``curve:v:1;v:7``, or ``curve:closed;v:1;v:7;v:9``."""
        texts = [point.text() for point in self._points()]
        if None in texts:
            return None
        return "curve:" + ";".join(["closed"] * self.closed + [str(text) for text in texts])

    def json(self) -> Any:
        """``{"curve": {"points": [{"vertex": 1}, {"vertex": 7}], "closed": false}}``."""
        return {"curve": {"points": [p.json() for p in self._points()], "closed": self.closed}}


@dataclass(frozen=True)
class Boundary:
    """The edges that are in one face only: all of them, or one ``loop``, the longest being 0."""

    loop: int | None = None

    def text(self) -> str | None:
        """``boundary`` or ``boundary:0``."""
        return "boundary" if self.loop is None else f"boundary:{int(self.loop)}"

    def json(self) -> Any:
        """``{"boundary": "all"}`` or ``{"boundary": 0}``."""
        return {"boundary": "all" if self.loop is None else int(self.loop)}


@dataclass(frozen=True)
class Faces:
    """Whole faces, at distance 0: a region as ``within`` has it, such as an array of source faces
    or ``{"material": "glass"}``."""

    region: RegionLike

    def __post_init__(self) -> None:
        region_of(self.region)

    @property
    def mask(self) -> int | None:
        """How many elements the mask has that it was made of."""
        return region_of(self.region).mask

    def text(self) -> str | None:
        """As regions: ``faces:7,10-99``."""
        return region_of(self.region).text()

    def json(self) -> Any:
        """As regions."""
        return region_of(self.region).json()
