"""The surface itself, and points found on it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

from .array_types import Float64, Index


@dataclass(frozen=True, eq=False)
class SurfacePoint:
    """A point found on the surface. It can be given wherever a point is asked for.

    Attributes:
        face: its source face; -1 at a vertex that is in no face.
        bary: (3,) the weights of that face's corners; NaN where ``face`` is -1.
        xyz: (3,) its place, mesh units.
        snap_distance: from what was asked to what was found, mesh units.
        vertex: the source vertex, when it is one, else None.
        ray_distance: of a ray's hit, its distance from the ray's origin, else None.
        kind: ``curve``, ``boundary`` or ``faces`` of a source that is no point, whose first point
            this is; else None.
        length: of the lines of such a source, mesh units; else None.
        pieces: of these lines, each straight within a face or along an edge; else None.
    """

    face: int
    bary: Float64
    xyz: Float64
    snap_distance: float
    vertex: int | None = None
    ray_distance: float | None = None
    kind: str | None = None
    length: float | None = None
    pieces: int | None = None

    def text(self) -> str | None:
        """As in a URL."""
        if self.vertex is not None:
            return f"v:{self.vertex}"
        return f"f:{self.face},{float(self.bary[0])!r},{float(self.bary[1])!r}"

    def json(self) -> Any:
        """As in a JSON body."""
        if self.vertex is not None:
            return {"vertex": self.vertex}
        return {"face": self.face, "bary": self.bary.tolist()}


class Geometry(NamedTuple):
    """What the server computes on, in the numbering of the file.

    Attributes:
        positions: (vertices, 3) float64, mesh units.
        triangles: (faces, 3) int64; welded vertices are named by the first of them.
    """

    positions: Float64
    triangles: Index
