"""Meshes of arrays: what they have to be, and as the bytes of a .ply file in memory, which hold
positions as float64."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from .results import Float64


def checked(
    vertices: NDArray[Any], faces: NDArray[Any], dtype: DTypeLike
) -> tuple[NDArray[Any], NDArray[np.uint32]]:
    """Positions (n, 3) of that dtype and corners (m, 3) as uint32.

    Raises:
        ValueError: other shapes, numbers that are not finite in that dtype, or faces that name
            vertices that are not there.
    """
    with np.errstate(over="ignore"):  # said below, by the number itself
        positions = np.ascontiguousarray(vertices, dtype=dtype)
    corners = np.asarray(faces)
    if positions.ndim != 2 or positions.shape[1] != 3 or len(positions) == 0:
        raise ValueError(f"vertices have the shape (n, 3), not {positions.shape}")
    if corners.ndim != 2 or corners.shape[1] != 3 or len(corners) == 0:
        raise ValueError(f"faces have the shape (m, 3), not {corners.shape}")
    if not np.issubdtype(corners.dtype, np.integer):
        raise ValueError(f"faces are integers, not {corners.dtype}")
    bad = np.flatnonzero(~np.isfinite(positions).all(axis=1))
    if len(bad):
        raise ValueError(f"vertex {bad[0]} is not finite in {positions.dtype.name}: "
                         f"{np.asarray(vertices)[bad[0]]}")  # fmt: skip
    if corners.min() < 0 or corners.max() >= len(positions):
        raise ValueError(f"faces name vertices from {corners.min()} to {corners.max()}, "
                         f"and there are {len(positions)}")  # fmt: skip
    return positions, np.ascontiguousarray(corners, dtype="<u4")


def ply_bytes(vertices: NDArray[Any], faces: NDArray[Any]) -> bytes:
    """The binary .ply file of a triangle mesh. Source vertex and face numbers are those of the
    arrays. It has no names, no materials and no axis that is up.

    Args:
        vertices: (n, 3) numbers, mesh units; float64 as they are.
        faces: (m, 3) integers below n.

    Raises:
        ValueError: other shapes, numbers that are not finite, or faces that name vertices that
            are not there.
    """
    positions, corners = checked(vertices, faces, "<f8")
    rows = np.empty(len(corners), dtype=[("count", "u1"), ("corners", "<u4", 3)])
    rows["count"] = 3
    rows["corners"] = corners
    axes = "".join(f"property double {axis}\n" for axis in "xyz")
    header = (
        "ply\nformat binary_little_endian 1.0\ncomment geodesicd for Python\n"
        f"element vertex {len(positions)}\n{axes}"
        f"element face {len(rows)}\nproperty list uchar uint vertex_indices\nend_header\n"
    )
    return b"".join([header.encode(), positions.data, rows.tobytes()])


def distinct_rows(positions: Float64 | NDArray[Any]) -> int:
    """How many rows of (n, 3) differ; -0 is 0."""
    rows = positions[np.lexsort(positions.T)]
    return 1 + int((rows[1:] != rows[:-1]).any(axis=1).sum())
