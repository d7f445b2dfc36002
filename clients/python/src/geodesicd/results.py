"""What queries return: plain records of NumPy arrays. Lengths are in mesh units, indices are
those of the uploaded file, and what cannot be reached is infinitely far away."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from .errors import GeodesicError

FloatArray: TypeAlias = NDArray[np.floating[Any]]
Float64: TypeAlias = NDArray[np.float64]
Index: TypeAlias = NDArray[np.int64]


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


class _Line:
    """What all lines can become."""

    def to_trimesh(self) -> Any:
        """As a ``trimesh.path.Path3D``. ImportError: trimesh is not installed."""
        from .exports import line_to_trimesh

        return line_to_trimesh(cast("Path | Loop | Trace | Isoline | Bisector", self))

    def to_pyvista(self) -> Any:
        """As a ``pyvista.PolyData`` of one polyline. ImportError: PyVista is not installed."""
        from .exports import line_to_pyvista

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
        unit: what costs are in: ``"seconds"``, ``"length"`` or ``"cost"``; None without costs.
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


@dataclass(frozen=True, eq=False)
class Voronoi:
    """The cells of the nearest of k sites, called by the places of these among those asked for;
    and the triangles between sites whose cells meet.

    Attributes:
        sites: the k sites, where relaxing left them; points again for other queries.
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
        triangles: (t, 3) int64, the geodesic Delaunay triangulation of the sites.
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


@dataclass(frozen=True, eq=False)
class SparseTable:
    """Distances that are not beyond some bound, by compressed sparse rows: those of row ``i`` are
    ``data[indptr[i]:indptr[i + 1]]``, and their columns are in ``indices`` at the same places,
    ascending. A distance of 0 is an entry too.

    Attributes:
        data: (n,) float64, mesh units.
        indices: (n,) int64, columns.
        indptr: (rows + 1,) int64.
        shape: rows and columns.
    """

    data: Float64
    indices: Index
    indptr: Index
    shape: tuple[int, int]

    @classmethod
    def joined(cls, parts: Sequence[SparseTable]) -> SparseTable:
        """Tables of the same columns, one below the other."""
        begins = [np.zeros(1, np.int64)]
        for part in parts:
            begins.append(begins[-1][-1] + part.indptr[1:])
        return cls(
            np.concatenate([part.data for part in parts]),
            np.concatenate([part.indices for part in parts]),
            np.concatenate(begins),
            (sum(part.shape[0] for part in parts), parts[0].shape[1]),
        )

    def to_array(self) -> Float64:
        """In full; infinite where there is no entry."""
        full = np.full(self.shape, np.inf)
        rows = np.repeat(np.arange(self.shape[0]), np.diff(self.indptr))
        full[rows, self.indices] = self.data
        return full

    def to_scipy(self) -> Any:
        """As a ``scipy.sparse.csr_array``. ImportError: SciPy is not installed."""
        from scipy.sparse import csr_array

        return csr_array((self.data, self.indices, self.indptr), shape=self.shape)


@dataclass(frozen=True, eq=False)
class Logmap:
    """The surface round ``source``, laid into the plane that touches it there: an entry for each
    vertex that has a place, ascending.

    Attributes:
        vertices: (n,) int64, source vertices.
        distances: (n,) float64, the lengths of the shortest paths to them, mesh units.
        angles: (n,) float64, those at which these paths leave the point, radians, as
            ``mesh.trace`` has them; 0 for a vertex at the point itself.
        straight: (n,) bool, whether ``mesh.trace`` by that angle and distance leads to the vertex:
            where its path passes no other vertex, and no edge with more than two faces.
        coordinates: (n, 2) float64, in the plane, mesh units; y is to the left of x.
        angle: of the x axis, radians.
        radius: the one asked for, or else the greatest distance, mesh units.
        total_angle: of all directions at the point, radians; 2 pi inside a face.
        all_round: whether no boundary is in the way at the point.
        source: the point asked for, as found on the surface.
        method: how distances were computed.
    """

    vertices: Index
    distances: Float64
    angles: Float64
    straight: NDArray[np.bool_]
    coordinates: Float64
    angle: float
    radius: float
    total_angle: float
    all_round: bool
    source: SurfacePoint
    method: str

    def __len__(self) -> int:
        return len(self.vertices)

    def __repr__(self) -> str:
        return f"<Logmap {len(self)} vertices within {self.radius:g}, {self.method}>"


class Geometry(NamedTuple):
    """What the server computes on, in the numbering of the file.

    Attributes:
        positions: (vertices, 3) float64, mesh units.
        triangles: (faces, 3) int64; welded vertices are named by the first of them.
    """

    positions: Float64
    triangles: Index


class LabelledDistances(NamedTuple):
    """A distance field with the nearest source of each vertex.

    Attributes:
        distances: (vertices,), mesh units; infinite where unreached.
        labels: (vertices,) int64, the place of the nearest source among those asked for; -1
            where unreached.
    """

    distances: FloatArray
    labels: Index


@dataclass(frozen=True)
class BatchReply:
    """The answer to one line of a batch: a ``reply`` as the query alone would have in JSON, or
    an ``error``. ``id`` is the line's own, if it had one."""

    status: int
    reply: dict[str, Any] | None
    error: GeodesicError | None
    id: str | int | float | None = None


@dataclass(frozen=True, eq=False)
class Answer:
    """A reply in the contract's own words.

    Attributes:
        document: the JSON, also of a frame; None if there is none.
        arrays: a frame's by name, lengths in mesh units; ``"array"`` of a bare one, as it came.
        data: the body of a picture, or of a .glb or .gltf file, else empty.
        media_type: the reply's.
        max: the greatest finite distance of a bare array of distances, mesh units, else None.
    """

    document: dict[str, Any] | None
    arrays: dict[str, NDArray[Any]]
    data: bytes
    media_type: str
    max: float | None
