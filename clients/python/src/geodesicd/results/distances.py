"""Distances: a field with its nearest sources, a sparse table, and the logarithmic map."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .array_types import Float64, FloatArray, Index
from .surface import SurfacePoint


class LabelledDistances(NamedTuple):
    """A distance field with the nearest source of each vertex.

    Attributes:
        distances: (vertices,), mesh units; infinite where unreached.
        labels: (vertices,) int64, the place of the nearest source among those asked for; -1
            where unreached.
    """

    distances: FloatArray
    labels: Index


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
        directions: (n, 3) float64 or None, with ``transport``: the direction of the x axis at the
            point, carried along each path, of length one; zeros where there is none.
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
    directions: Float64 | None = None

    def __len__(self) -> int:
        return len(self.vertices)

    def __repr__(self) -> str:
        return f"<Logmap {len(self)} vertices within {self.radius:g}, {self.method}>"
