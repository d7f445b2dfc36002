"""Lines on the surface: paths, loops, traces, isolines and bisectors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from .array_types import Float64, Index
from .surface import SurfacePoint


class _Line:
    """What all lines can become."""

    def to_trimesh(self) -> Any:
        """As a ``trimesh.path.Path3D``. ImportError: trimesh is not installed."""
        from ..exports import line_to_trimesh

        return line_to_trimesh(cast("Path | Loop | Trace | Isoline | Bisector", self))

    def to_pyvista(self) -> Any:
        """As a ``pyvista.PolyData`` of one polyline. ImportError: PyVista is not installed."""
        from ..exports import line_to_pyvista

        return line_to_pyvista(cast("Path | Loop | Trace | Isoline | Bisector", self))


@dataclass(frozen=True, eq=False)
class Path(_Line):
    """A geodesic polyline from ``source`` to ``target``.

    Attributes:
        points: (n, 3) float64, mesh units; empty when not reachable.
        faces: (n,) int64, the source face of the segment that leaves each point; -1 for none.
        bary: (n, 3) float64, each point's weights in that face; NaN where there is none.
        length: mesh units; infinite when not reachable.
        reachable: whether there is a path at all.
        source, via, target: the points asked for, as found on the surface.
        method: how distances were computed.
        refine: ``"none"`` or ``"shortest"``.
        cost: what the whole costs, with ``costs``; infinite when not reachable, else None.
        unit: what costs are in: ``"seconds"``, ``"joules_per_kilogram"``, ``"length"`` or
            ``"cost"``; None without costs.
        segment_costs: (n - 1,) float64, from each point to the next; None without costs.
    """

    points: Float64
    faces: Index
    bary: Float64
    length: float
    reachable: bool
    source: SurfacePoint
    via: tuple[SurfacePoint, ...]
    target: SurfacePoint
    method: str
    refine: str
    cost: float | None = None
    unit: str | None = None
    segment_costs: Float64 | None = None

    def __len__(self) -> int:
        return len(self.points)

    def __repr__(self) -> str:
        what = f"{self.length:g} long, {len(self)} points" if self.reachable else "there is none"
        return f"<Path {what}, {self.method}>"

    @property
    def along(self) -> Float64:
        """(n,) the length of the path up to each point, mesh units."""
        return _along(self.points)


@dataclass(frozen=True, eq=False)
class Loop(_Line):
    """A closed polyline: points, faces and bary as of a :class:`Path`; the last point is the first
    one again.

    Attributes:
        length: mesh units.
        start_length: of the paths or the section that it was made of, mesh units.
        geodesic: whether it is locally shortest all round.
        turn: degrees, the most that it is off straight ahead at any point; None of a hull.
        start: ``"through"``, ``"around"`` or ``"plane"``.
        asked: the points asked for, as found on the surface.
        hull: whether it is the convex hull of a section, whose segments are in space.
        method: how distances were computed; None of a plane.
    """

    points: Float64
    faces: Index
    bary: Float64
    length: float
    start_length: float
    geodesic: bool
    turn: float | None
    start: str
    asked: tuple[SurfacePoint, ...]
    hull: bool
    method: str | None

    def __len__(self) -> int:
        return len(self.points)

    def __repr__(self) -> str:
        what = "geodesic" if self.geodesic else "hull" if self.hull else "not geodesic"
        return f"<Loop {self.length:g} long, {len(self)} points, {what}>"

    @property
    def along(self) -> Float64:
        """(n,) the length of the loop up to each point, mesh units."""
        return _along(self.points)


def _along(points: Float64) -> Float64:
    if len(points) == 0:
        return np.empty(0)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


@dataclass(frozen=True, eq=False)
class Trace(_Line):
    """A straightest geodesic: points, faces and bary as of a :class:`Path`.

    Attributes:
        end: why it ends: ``"length"``, ``"boundary"``, ``"vertex"`` or ``"non_manifold"``.
        direction_at_end: (3,) where it was heading, of length 1.
    """

    points: Float64
    faces: Index
    bary: Float64
    length: float
    end: str
    direction_at_end: Float64
    source: SurfacePoint
    target: SurfacePoint

    def __repr__(self) -> str:
        return f"<Trace {self.length:g} long, {len(self.points)} points, ends by {self.end}>"

    @property
    def along(self) -> Float64:
        """(n,) the length of the trace up to each point, mesh units."""
        return _along(self.points)


class _Loop(_Line):
    """A line that may come back to its first point."""

    closed: bool
    points: Float64

    @property
    def polyline(self) -> Float64:
        """(n or n + 1, 3) the points, with the first once more at the end of a closed line."""
        if self.closed:
            return np.concatenate([self.points, self.points[:1]])
        return self.points


@dataclass(frozen=True, eq=False)
class Isoline(_Loop):
    """A line on which the distance is ``level``.

    Attributes:
        level: mesh units.
        closed: whether one more segment leads from the last point to the first.
        length: mesh units, that segment included.
        points: (n, 3) float64, the first not repeated.
    """

    level: float
    closed: bool
    length: float
    points: Float64

    def __repr__(self) -> str:
        kind = "closed" if self.closed else "open"
        return (
            f"<Isoline at {self.level:g}, {kind}, {self.length:g} long, {len(self.points)} points>"
        )


@dataclass(frozen=True, eq=False)
class Bisector(_Loop):
    """A line as far from the sites of two cells.

    Attributes:
        cells: their numbers, ascending.
        closed: whether one more segment leads from the last point to the first.
        length: mesh units, that segment included.
        points: (n, 3) float64, the first not repeated.
    """

    cells: tuple[int, int]
    closed: bool
    length: float
    points: Float64

    def __repr__(self) -> str:
        kind = "closed" if self.closed else "open"
        return f"<Bisector of {self.cells}, {kind}, {self.length:g} long>"
