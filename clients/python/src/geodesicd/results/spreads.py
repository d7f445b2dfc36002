"""How distances spread over the whole surface: samples, discs, extents and cells."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .array_types import Float64, Index
from .lines import Bisector
from .surface import SurfacePoint


@dataclass(frozen=True, eq=False)
class Samples:
    """Vertices spread evenly, in the order in which they were chosen.

    Attributes:
        vertices: (k,) int64, source vertices.
        points: (k, 3) float64, their places, mesh units.
        radii: (k,) float64, each one's distance from all before it, when it was chosen;
            infinite when nothing before it was on its component.
        covering_radius: no vertex in a face is farther from its nearest sample.
    """

    vertices: Index
    points: Float64
    radii: Float64
    covering_radius: float

    def __len__(self) -> int:
        return len(self.vertices)

    def __repr__(self) -> str:
        return f"<Samples {len(self)} vertices, covering radius {self.covering_radius:g}>"


@dataclass(frozen=True, eq=False)
class Measure:
    """What geodesic discs measure, one for each radius, ascending; and the whole field.

    Attributes:
        area: of the surface that is reached, or no farther than ``max``, mesh units squared.
        mean: of the distance over that area, mesh units.
        max: the greatest distance of a vertex, mesh units.
        farthest: the source vertex that has it.
        radii: (k,) float64, mesh units.
        areas: (k,) float64, mesh units squared.
        means: (k,) float64, of the distance over the disc; 0 where that has no area.
        perimeters: (k,) float64, the lengths of the isolines at the radii.
        boundaries: (k,) float64, the length of the surface's own boundary inside the disc.
        lines: (k,) int64, how many isolines there are at the radius.
        vertices: (k,) int64, how many source vertices are in the disc.
        euler: (k,) int64, Euler characteristics: 1 of a disc that folds over nowhere, 0 of a ring.
        whole: (k,) bool, whether every vertex that is in a face is in the disc.
    """

    area: float
    mean: float
    max: float
    farthest: int | None
    radii: Float64
    areas: Float64
    means: Float64
    perimeters: Float64
    boundaries: Float64
    lines: Index
    vertices: Index
    euler: Index
    whole: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.radii)

    def __repr__(self) -> str:
        return f"<Measure {len(self)} discs, {self.max:g} to the farthest vertex>"


@dataclass(frozen=True, eq=False)
class Extent:
    """How large a surface is, or where its middle is: of its part with most vertices.

    Attributes:
        of: ``"diameter"``, ``"center"``, ``"median"``, ``"mean"`` or ``"means"``.
        value: the best that was found, mesh units.
        lower: the true one is not below.
        upper: the true one is not above; infinite where nothing is known of that.
        confidence: with which these two hold; 0.95 of means that are estimated, else 1.
        exact: whether the value is that of all vertices.
        vertices: (2,), (1,) or (0,) int64, the diameter's ends, or the one in the middle.
        points: (2, 3), (1, 3) or (0, 3) float64, where they are, mesh units.
        fields: how many were computed.
        part_vertices: how many vertices the part has; those at one position are one.
        means: of ``"means"``, the mean distance of each of the mesh's vertices, float64, mesh
            units; infinite outside of the part. Of anything else empty.
        margins: for each the most that it is off, with the confidence; infinite outside of the
            part, and where nothing is known of that.
    """

    of: str
    value: float
    lower: float
    upper: float
    confidence: float
    exact: bool
    vertices: Index
    points: Float64
    fields: int
    part_vertices: int
    means: Float64
    margins: Float64

    def __repr__(self) -> str:
        how = "exactly" if self.exact else f"from {self.lower:g} to {self.upper:g}"
        return f"<Extent: {self.of} {self.value:g}, {how}>"


@dataclass(frozen=True, eq=False)
class Voronoi:
    """The cells of the nearest of k sites, called by the places of these among those asked for;
    and the triangles between sites whose cells meet.

    Attributes:
        sites: the k sites, where relaxing left them; points again for other queries. Of a curve, a
            boundary or faces the first point, with its ``kind``.
        points: (k, 3) float64, where they are, mesh units.
        areas: (k,) float64, mesh units squared; 0 of a cell that has nothing.
        perimeters: (k,) float64, the lengths of each cell's bisectors, mesh units.
        boundaries: (k,) float64, the length of the surface's own boundary in the cell.
        vertices: (k,) int64, how many source vertices are in the cell.
        centroids: (k, 3) float64, the point of each cell that is nearest to its mean position; NaN
            of a cell without area.
        neighbors: (n, 2) int64, cells with a common bisector.
        lengths: (n,) float64, how long that is, mesh units.
        bisectors: as lines on the surface.
        triangles: (t, 3) int64, three cells that meet: the geodesic Delaunay triangulation of
            sites that are points.
        corners: (t, 3) float64, where the cells of each triangle meet.
        distances: (t,) float64, of that from the three sites, mesh units.
    """

    sites: list[SurfacePoint]
    points: Float64
    areas: Float64
    perimeters: Float64
    boundaries: Float64
    vertices: Index
    centroids: Float64
    neighbors: Index
    lengths: Float64
    bisectors: list[Bisector]
    triangles: Index
    corners: Float64
    distances: Float64

    def __len__(self) -> int:
        return len(self.sites)

    def __repr__(self) -> str:
        return f"<Voronoi {len(self)} cells, {len(self.triangles)} triangles>"
