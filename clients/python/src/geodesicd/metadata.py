"""What the server knows of a mesh without computing on it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from .lookup import reading_text, short_ids
from .masks import SizedId
from .results import Float64

_IN_REPLY = {"reading": "import"}  # which is a keyword of Python


@dataclass(frozen=True)
class Part:
    """One drawn instance of one primitive: a run of source vertices and faces.

    ``field[part.first_vertex : part.first_vertex + part.vertex_count]`` are its values. glTF
    indices are None for Draco files. ``material`` is the number of a material of the file, a
    place in the mesh's ``materials`` unless it is behind those that are listed, or None for no
    material or several.
    """

    node: int | None
    mesh: int | None
    primitive: int | None
    name: str
    first_vertex: int
    vertex_count: int
    first_face: int
    face_count: int
    material: int | None = None


@dataclass(frozen=True)
class Material:
    """A material of the file, and how many faces have it; ``name`` may be empty."""

    name: str
    face_count: int


@dataclass(frozen=True)
class BoundaryLoop:
    """A loop of the boundary, edges that are in one face only.

    ``mesh.boundaries[k]`` is the source ``Boundary(k)``. ``length`` is in mesh units, ``vertex`` is
    the least source vertex on it. It is not ``closed`` where it ends at an edge of three faces or
    more.
    """

    length: float
    edges: int
    closed: bool
    vertex: int


@dataclass(frozen=True)
class Finding:
    """What was found when a file was read, and what it means for answers.

    ``examples`` are the first few of ``count``: mappings that name vertices, faces or points, or
    texts.
    """

    code: str
    count: int
    examples: list[Any]
    text: str


class Metadata:
    """A mesh's metadata as attributes.

    Attributes:
        id: the SHA-256 of the file, 64 hexadecimal digits; ``~`` and 32 more behind it where it
            was read in a way of its own.
        name: what the mesh is called, or None. It is no part of the id, and two meshes may have
            the same.
        bytes: the file's size.
        format: ``"glb"``, ``"gltf"``, ``"drc"``, ``"obj"``, ``"ply"`` or ``"stl"``.
        vertices, faces: how many source vertices and faces there are.
        welded_vertices: vertices once those that share a position are one.
        components, boundary_loops, edges_non_manifold, faces_degenerate: counts.
        boundaries: the loops of the boundary, the longest first, at most 100 of them; none where an
            older version of the server has described the mesh.
        bbox: (2, 3) float64, least and greatest coordinates, mesh units.
        area: square mesh units.
        mean_edge: mesh units.
        reading: how the file was told to be read (``import`` in the contract), as far as it differs
            from the defaults.
        parts: the primitives, in source-vertex order.
        materials: those of the file, in its order; none where an older version of the server has
            described the mesh.
        warnings: what was ignored or is unusual, a sentence each.
        report: what was welded, left out and kept, and what that means for answers.
        state: ``"resident"`` in memory or ``"stored"``, when it was asked for.
        prepared: whether what queries need was in memory then.
    """

    id: str
    name: str | None
    bytes: int
    format: str
    vertices: int
    faces: int
    welded_vertices: int
    components: int
    boundary_loops: int
    boundaries: tuple[BoundaryLoop, ...]
    edges_non_manifold: int
    faces_degenerate: int
    bbox: Float64
    area: float
    mean_edge: float
    reading: Mapping[str, Any]
    parts: tuple[Part, ...]
    materials: tuple[Material, ...]
    warnings: tuple[str, ...]
    report: tuple[Finding, ...]
    state: str
    prepared: bool

    def __init__(self, reply: Mapping[str, Any]) -> None:
        self._read(reply)

    def _read(self, reply: Mapping[str, Any]) -> None:
        for name in Metadata.__annotations__:
            if name not in ("name", "boundaries", "materials"):
                setattr(self, name, reply[_IN_REPLY.get(name, name)])
        self.name = reply.get("name")
        self.boundaries = tuple(
            BoundaryLoop(**{name: loop[name] for name in BoundaryLoop.__annotations__})
            for loop in reply.get("boundaries", ())
        )
        box = reply["bbox"]
        self.bbox = np.array([box["min"], box["max"]], dtype=np.float64)
        self.parts = tuple(
            Part(**{name: part.get(name) for name in Part.__annotations__})
            for part in reply["parts"]
        )
        self.materials = tuple(
            Material(one["name"], one["face_count"]) for one in reply.get("materials", ())
        )
        self.warnings = tuple(reply["warnings"])
        self.report = tuple(
            Finding(**{name: one[name] for name in Finding.__annotations__})
            for one in reply["report"]
        )

    @property
    def sized_id(self) -> SizedId:
        """The id, as queries take it."""
        return SizedId.of(self.id, self.vertices, self.faces)

    def __repr__(self) -> str:
        called = [] if self.name is None else [repr(self.name)]
        read = [reading_text(self.reading)] if self.reading else []
        sizes = f"{self.vertices} vertices {self.faces} faces"
        # As `geodesic list` shows them: two readings of one file differ behind the ~ of their ids.
        words = [type(self).__name__, *called, short_ids([self.id])[self.id], *read, sizes]
        return f"<{' '.join(words)}>"
