"""Meshes that the examples are about: a sphere and hills, each as (vertices, faces)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Arrays = tuple[NDArray[np.float64], NDArray[np.int64]]


def sphere(divisions: int) -> Arrays:
    """An icosahedron of radius 1 whose faces were cut in four so many times:
    10 * 4 ** divisions + 2 vertices."""
    golden = (1 + 5**0.5) / 2
    ring = [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)]
    corners: list[tuple[float, float, float]] = [(a, b, 0.0) for a, b in ring]
    corners += [(0.0, a, b) for a, b in ring]
    corners += [(b, 0.0, a) for a, b in ring]
    vertices = np.array(corners, dtype=np.float64)
    faces = np.array(
        [[0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11], [1, 5, 9], [5, 11, 4],
         [11, 10, 2], [10, 7, 6], [7, 1, 8], [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8],
         [3, 8, 9], [4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1]]
    )  # fmt: skip
    vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
    for _ in range(divisions):
        sides = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        edges, which = np.unique(sides, axis=0, return_inverse=True)
        middle = which.reshape(-1, 3) + len(vertices)
        halves = vertices[edges].mean(axis=1)
        vertices = np.concatenate([vertices, halves / np.linalg.norm(halves, axis=1)[:, None]])
        a, b, c = faces.T
        ab, bc, ca = middle.T
        faces = np.concatenate(
            [np.column_stack(t) for t in ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))]
        )
    return vertices, faces


def hills(side: int, height: float) -> Arrays:
    """A landscape of ``side`` x ``side`` vertices, a mesh unit apart: a ridge across the way
    from west to east, with a pass in the north. z is up."""
    x, y = np.meshgrid(np.arange(side, dtype=np.float64), np.arange(side, dtype=np.float64))
    across = np.exp(-(((x - side / 2) / (side / 10)) ** 2))
    along = 1 - 0.9 * np.exp(-(((y - 0.8 * side) / (side / 9)) ** 2))
    z = height * across * along
    corner = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    one = np.column_stack([corner, corner + 1, corner + side + 1])
    two = np.column_stack([corner, corner + side + 1, corner + side])
    vertices = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    return vertices, np.concatenate([one, two]).astype(np.int64)
