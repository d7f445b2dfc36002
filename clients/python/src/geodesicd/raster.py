"""Which face is seen at each pixel: a depth buffer in NumPy, for pictures of a few hundred
thousand faces in a second or two, without a GPU."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .results import Float64, Geometry, Index

_TESTS_AT_ONCE = 1 << 20  # pixel-in-triangle tests: bounds the memory


@dataclass(frozen=True)
class Camera:
    """A parallel projection.

    Attributes:
        axes: (3, 3) rows: to the right, up, and towards the viewer.
        centre: (2,) what of the first two axes is in the picture's middle, mesh units.
        scale: pixels a mesh unit.
        width, height: pixels.
    """

    axes: Float64
    centre: Float64
    scale: float
    width: int
    height: int

    @staticmethod
    def looking(
        positions: Float64, azimuth: float, elevation: float, up: str, width: int, height: int
    ) -> Camera:
        """One that has all of ``positions`` (n, 3) in view. (0, 0) looks from +z and (90, 0)
        from +x, in degrees, where y is up; with ``up="z"``, from -y and from +x."""
        a, e = np.radians(azimuth), np.radians(elevation)
        towards = np.array([np.sin(a) * np.cos(e), np.sin(e), np.cos(a) * np.cos(e)])
        right = np.array([np.cos(a), 0.0, -np.sin(a)])
        axes = np.stack([right, np.cross(towards, right), towards])
        if up == "z":  # (x, y, z) is seen where (x, z, -y) would be
            axes = axes @ np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
        flat = positions @ axes[:2].T
        low, high = flat.min(axis=0), flat.max(axis=0)
        size = np.maximum(high - low, 1e-300)
        scale = float(min(width / size[0], height / size[1]) * 0.96)
        return Camera(axes, (low + high) / 2, scale, width, height)

    def project(self, points: Float64) -> tuple[Float64, Float64]:
        """Of points (n, 3) the places (n, 2) in pixels, from the upper left, and the depths
        (n,) in mesh units, greater towards the viewer."""
        seen = points @ self.axes.T
        flat = (seen[:, :2] - self.centre) * self.scale
        return flat * [1, -1] + [self.width / 2, self.height / 2], seen[:, 2]


@dataclass(frozen=True)
class Seen:
    """What is seen at each pixel.

    Attributes:
        face: (height, width) int64, -1 for the background.
        bary: (height, width, 3) the place in that face.
        depth: (height, width), -inf for the background.
    """

    face: Index
    bary: Float64
    depth: Float64

    def interpolate(self, triangles: Index, values: NDArray[Any]) -> NDArray[Any]:
        """(height, width, ...) the values (vertices, ...) at each pixel; NaN where nothing is
        seen."""
        return self.blend(values[triangles])

    def blend(self, corners: NDArray[Any]) -> NDArray[Any]:
        """(height, width, ...) the values (faces, 3, ...) of faces' corners at each pixel; NaN
        where nothing is seen."""
        there = self.face >= 0
        faces, bary = self.face[there], self.bary[there]
        inside: NDArray[Any] = np.zeros((len(faces), *corners.shape[2:]))
        for corner in range(3):
            weight = bary[:, corner].reshape(-1, *[1] * (corners.ndim - 2))
            # Zero times infinity is NaN: a corner without weight has no say.
            inside += np.where(
                weight > 0, weight * np.where(weight > 0, corners[faces, corner], 0), 0
            )
        values = np.full((*self.face.shape, *corners.shape[2:]), np.nan)
        values[there] = inside
        return values

    def nearest(self, triangles: Index, values: NDArray[Any]) -> NDArray[Any]:
        """(height, width) at each pixel the value of the closest corner; NaN where nothing is
        seen."""
        corner = triangles[self.face, self.bary.argmax(axis=2)]
        return np.where(self.face < 0, np.nan, values[corner])

    def shows(self, camera: Camera, points: Float64) -> NDArray[np.bool_]:
        """(n,) whether points (n, 3) on the surface are seen, rather than behind it."""
        places, depth = camera.project(points)
        columns = np.clip(places[:, 0].astype(int), 1, camera.width - 2)
        rows = np.clip(places[:, 1].astype(int), 1, camera.height - 2)
        # At a slanted face the depth changes within a pixel: the farthest of those around.
        front = np.full(len(points), np.inf)
        for row in (-1, 0, 1):
            for column in (-1, 0, 1):
                front = np.minimum(front, self.depth[rows + row, columns + column])
        reach = 2 / camera.scale + 2e-3 * camera.height / camera.scale
        return np.asarray(depth >= front - reach)


def render(camera: Camera, geometry: Geometry) -> Seen:
    """What a camera sees of a surface."""
    places, depths = camera.project(geometry.positions)
    triangles = geometry.triangles
    pixels = camera.width * camera.height
    depth = np.full(pixels, -np.inf)
    face = np.full(pixels, -1, dtype=np.int64)
    bary = np.zeros((pixels, 3))
    for faces, where, weights in _covered(camera, places[triangles]):
        at = (weights * depths[triangles[faces]]).sum(axis=1)
        nearer = np.flatnonzero(at > depth[where])
        # The last of equal indices is kept by an assignment: so the nearest comes last.
        order = nearer[np.argsort(at[nearer], kind="stable")]
        where = where[order]
        depth[where], face[where], bary[where] = at[order], faces[order], weights[order]
    shape = (camera.height, camera.width)
    return Seen(face.reshape(shape), bary.reshape(*shape, 3), depth.reshape(shape))


def _covered(camera: Camera, corners: Float64) -> Iterator[tuple[Index, Index, Float64]]:
    """The pixels whose centres lie in faces with ``corners`` (n, 3, 2): faces, pixels and
    weights, some faces of like size at a time."""
    low = np.floor(corners.min(axis=1) - 0.5).astype(np.int64)
    size = np.ceil(corners.max(axis=1) - 0.5).astype(np.int64) - low + 1
    one, two = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]
    drawn = np.flatnonzero(np.abs(area) > 1e-12)
    box = 2 ** np.ceil(np.log2(np.maximum(size, 2))).astype(np.int64)
    kinds, kind = np.unique(box[drawn], axis=0, return_inverse=True)
    for number, (width, height) in enumerate(kinds):
        alike = drawn[kind.reshape(-1) == number]
        many = max(1, _TESTS_AT_ONCE // int(width * height))
        x, y = np.meshgrid(np.arange(width), np.arange(height))
        grid = np.column_stack([x.ravel(), y.ravel()])
        for start in range(0, len(alike), many):
            faces = alike[start : start + many]
            centres = low[faces][:, None] + grid
            off = centres + 0.5 - corners[faces, 0][:, None]
            b, c = one[faces][:, None], two[faces][:, None]
            second = (off[..., 0] * c[..., 1] - off[..., 1] * c[..., 0]) / area[faces][:, None]
            third = (b[..., 0] * off[..., 1] - b[..., 1] * off[..., 0]) / area[faces][:, None]
            first = 1 - second - third
            # Faces overlap by a hair rather than leave pixels between them to what is behind.
            inside = (first > -1e-9) & (second > -1e-9) & (third > -1e-9)
            inside &= (centres >= 0).all(axis=2)
            inside &= (centres[..., 0] < camera.width) & (centres[..., 1] < camera.height)
            which, place = np.nonzero(inside)
            at = centres[which, place]
            weights = np.stack([first[inside], second[inside], third[inside]], axis=1).clip(0, 1)
            yield faces[which], at[:, 1] * camera.width + at[:, 0], weights


def corner_normals(geometry: Geometry) -> Float64:
    """(faces, 3, 3) a normal for each corner: smooth, but for edges that are sharp."""
    corners = geometry.positions[geometry.triangles]
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    smooth = np.zeros_like(geometry.positions)
    for corner in range(3):
        np.add.at(smooth, geometry.triangles[:, corner], flat)
    unit = flat / np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1e-300)
    smooth /= np.maximum(np.linalg.norm(smooth, axis=1, keepdims=True), 1e-300)
    normals = smooth[geometry.triangles]
    bent = (normals * unit[:, None]).sum(axis=2) < 0.75
    normals[bent] = np.broadcast_to(unit[:, None], normals.shape)[bent]
    return np.asarray(normals)
