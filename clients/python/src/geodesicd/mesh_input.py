"""What can be uploaded: a file, its bytes, arrays, or a mesh of trimesh, PyVista or meshio.
Those libraries are never imported here: an object of theirs is known by its module."""

from __future__ import annotations

import hashlib
import os
import re
import warnings
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .arrays import distinct_rows, ply_bytes
from .errors import PrecisionWarning
from .glb import glb_bytes
from .gltf_files import buffer_files, form

_CHUNK = 1 << 18
_LONGEST_NAME = 200  # bytes
# What the server takes in no name (proto/wire/mesh_name.cpp): control characters, what breaks lines
# or turns the direction of what follows, and what is no text, such as half a surrogate pair.
_IN_NO_NAME = re.compile(r"[\x00-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")


class UploadBody:
    """Bytes to send, which are read a piece at a time and can be read again for a retry.

    Attributes:
        length: in bytes.
        digest: their SHA-256 in hexadecimal, a mesh's id.
        positions: (n, 3) what they were made of, if that was arrays.
        form: the media type, if this is a form of several files: then ``digest`` is no mesh's id.
        name: what to call the mesh, if that is known: the file's name.
    """

    def __init__(
        self,
        *source: bytes | Path,
        positions: NDArray[Any] | None = None,
        form: str | None = None,
        name: str | None = None,
    ) -> None:
        self._source = source
        self.positions = positions
        self.form = form
        self.name = name
        self.progress: Callable[[float], None] | None = None
        digest = hashlib.sha256()
        self.length = 0
        for chunk in self._pieces():
            digest.update(chunk)
            self.length += len(chunk)
        self.digest = digest.hexdigest()

    def _pieces(self) -> Iterator[bytes]:
        for source in self._source:
            if isinstance(source, Path):
                with source.open("rb") as file:
                    while chunk := file.read(_CHUNK):
                        yield chunk
            else:
                for start in range(0, len(source), _CHUNK):
                    yield source[start : start + _CHUNK]

    def chunks(self) -> Iterator[bytes]:
        """The bytes from the first on, telling ``progress`` which part has been taken."""
        sent = 0
        for chunk in self._pieces():
            yield chunk
            sent += len(chunk)
            if self.progress is not None:
                self.progress(sent / self.length)


def body_of(mesh: Any, faces: Any = None) -> UploadBody:
    """The bytes to upload.

    Args:
        mesh: a path to a .glb, .gltf (whose buffers may be in files beside it), .drc, .obj, .ply or
            .stl file; the bytes of one; a pair
            (vertices (n, 3), faces (m, 3)); or a mesh object of trimesh, PyVista or meshio.
        faces: (m, 3), if ``mesh`` is vertices (n, 3).

    Raises:
        TypeError: none of these. ValueError: no triangles, or numbers out of range.
        OSError: the file cannot be read.
    """
    if faces is not None:
        return _of_arrays(mesh, faces)
    if isinstance(mesh, str | os.PathLike):
        return _of_file(Path(os.fspath(mesh)))
    if isinstance(mesh, bytes | bytearray | memoryview):
        return UploadBody(bytes(mesh))
    if isinstance(mesh, tuple) and len(mesh) == 2:
        return _of_arrays(*mesh)
    library = {base.__module__.partition(".")[0] for base in type(mesh).__mro__}
    if "trimesh" in library and hasattr(mesh, "faces"):
        return _of_arrays(mesh.vertices, mesh.faces)
    if "pyvista" in library and hasattr(mesh, "triangulate"):
        return _of_arrays(*_of_pyvista(mesh))
    if "meshio" in library and hasattr(mesh, "cells"):
        return _of_arrays(*_of_meshio(mesh))
    if isinstance(mesh, np.ndarray):
        raise TypeError("cannot upload vertices alone: give (vertices, faces)")
    raise TypeError(
        f"cannot upload a {type(mesh).__module__}.{type(mesh).__qualname__}: give a path, bytes, "
        "(vertices, faces), or a mesh of trimesh, PyVista or meshio"
    )


def _of_arrays(vertices: Any, faces: Any) -> UploadBody:
    """As a .glb file if its float32 holds the numbers, else as a .ply file of float64."""
    positions = np.asarray(vertices)
    narrow = positions.dtype in (np.float16, np.float32)
    made = (glb_bytes if narrow else ply_bytes)(positions, np.asarray(faces))
    return UploadBody(made, positions=positions)


def _of_file(file: Path) -> UploadBody:
    """A file, and with a .gltf file those that it has its buffers in."""
    if file.suffix.lower() == ".gltf" and file.is_file() and (files := buffer_files(file)):
        name = name_of(file)
        media_type, pieces = form({name or file.name: file, **files})
        return UploadBody(*pieces, form=media_type, name=name)
    return UploadBody(file, name=name_of(file))


def name_of(file: Path) -> str | None:
    """What a mesh is called by its file: the file's name, without what the server takes in no name,
    and at most 200 bytes of it; None where nothing is left. Nobody has asked for this name, so no
    upload is to fail for it. The end stays, since it says the format."""
    name = _IN_NO_NAME.sub("", file.name).encode()
    return name[-_LONGEST_NAME:].decode(errors="ignore").strip() or None


def warn_of_rounding(
    body: UploadBody, metadata: Mapping[str, Any], reading: Mapping[str, Any], stacklevel: int
) -> None:
    """Warns where an upload of arrays has lost what tells vertices apart: the server has made
    one of positions that differ, or they came as float32 too coarse for their edges."""
    positions = body.positions
    if positions is None:
        return
    welded = metadata["vertices"] - metadata["welded_vertices"]
    if welded and not reading.get("weld"):  # a distance above 0 asks for it
        joined = welded - (len(positions) - distinct_rows(positions))
        if joined > 0:
            warnings.warn(
                f"the server joined {joined:,} of {len(positions):,} vertices with others although "
                "their positions differ: distances are wrong there. Upload with weld='off', or in "
                "another unit or from another origin, such as vertices - vertices.mean(axis=0)",
                PrecisionWarning,
                stacklevel,
            )
    if positions.dtype != np.float32:
        return
    edge = metadata["mean_edge"]
    for axis in positions.T:
        far = np.abs(axis).max()
        step = float(np.spacing(far))
        # Whole metres of a survey lose nothing to float32.
        whole = step < 1 and bool((axis == np.rint(axis)).all())
        if step * float(reading.get("scale", 1)) > 0.01 * edge and not whole:
            warnings.warn(
                f"the vertices are float32, which at {far:g} knows steps of {step:.2g}, and edges "
                f"are {edge:.2g} long on average: make them float64 from the first, or take the "
                "origin away before they become float32",
                PrecisionWarning,
                stacklevel,
            )
            return


def _of_pyvista(mesh: Any) -> tuple[Any, Any]:
    # Other data sets have a surface too, but with vertices in another order than theirs.
    if type(mesh).__name__ != "PolyData":
        raise TypeError(f"of PyVista only PolyData is a surface, not {type(mesh).__name__}; "
                        "see extract_surface()")  # fmt: skip
    triangles = mesh if mesh.is_all_triangles else mesh.triangulate()
    faces = np.asarray(triangles.faces).reshape(-1, 4)[:, 1:]
    return np.asarray(triangles.points), faces


def _of_meshio(mesh: Any) -> tuple[Any, Any]:
    faces = []
    for block in mesh.cells:
        corners = np.asarray(block.data)
        if block.type == "triangle":
            faces.append(corners)
        elif block.type == "quad":  # a quad is two triangles, in its place
            faces.append(corners[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3))
    if not faces:
        kinds = ", ".join(sorted({block.type for block in mesh.cells})) or "none"
        raise ValueError(f"the meshio mesh has no triangles or quads; its cells: {kinds}")
    points = np.asarray(mesh.points)
    if points.shape[1] == 2:  # a flat mesh
        points = np.column_stack([points, np.zeros(len(points))])
    return points, np.concatenate(faces)
