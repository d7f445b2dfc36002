"""Boolean arrays of faces: that they are of the mesh that is asked about. The server is told faces
by their numbers, and would not see that a mask is of something else, such as of vertices."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np


class SizedId(str):
    """A mesh's id, as queries take it, that knows how large the mesh is. A bare id does not, and no
    mask is checked by it."""

    vertices: int
    faces: int

    @classmethod
    def of(cls, id: str, vertices: int, faces: int) -> SizedId:
        """The id of a mesh of so many source vertices and faces."""
        made = cls(id)
        made.vertices, made.faces = vertices, faces
        return made


def is_mask(value: object) -> bool:
    """Whether it is an array that says of each face whether it is meant."""
    return isinstance(value, np.ndarray) and value.ndim == 1 and value.dtype == np.bool_


def check_masks(mesh: str, parameters: Mapping[str, Any]) -> None:
    """Checks what is made of masks among a query's parameters: all that has a ``mask``, which is
    how many elements that has, or None.

    Raises:
        ValueError: a mask has not an element for each face of the mesh.
    """
    if not isinstance(mesh, SizedId):
        return
    for name, value in parameters.items():
        for one in value if isinstance(value, list | tuple) else [value]:
            length = getattr(one, "mask", None)
            if length is not None and length != mesh.faces:
                raise ValueError(f"{name}: {_wrong(length, mesh)}")


def _wrong(length: int, mesh: SizedId) -> str:
    told = (
        f"this mask has {length} elements, and the mesh {mesh.faces} faces; a mask has one for "
        "each face"
    )
    if length != mesh.vertices:
        return told
    return (
        f"{told}. It looks like a mask of vertices, of which there are {length}: "
        "mask[mesh.geometry().triangles].all(axis=1) is one of the faces that have all their "
        "corners in it"
    )
