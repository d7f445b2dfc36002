"""A mesh of arrays as a .glb file in memory: one triangle primitive, positions as float32
(glTF has no wider), indices as uint32. Of float64, :func:`~geodesicd.ply_bytes` loses nothing."""

from __future__ import annotations

import json
import struct
from typing import Any

from numpy.typing import NDArray

from .arrays import checked

_FLOAT, _UNSIGNED_INT = 5126, 5125
_VERTICES, _INDICES = 34962, 34963


def glb_bytes(vertices: NDArray[Any], faces: NDArray[Any], name: str = "mesh") -> bytes:
    """The .glb file of a triangle mesh. Source vertex and face numbers are those of the arrays.

    Args:
        vertices: (n, 3) numbers, mesh units; rounded to float32.
        faces: (m, 3) integers below n.
        name: of the mesh in the file.

    Raises:
        ValueError: other shapes, numbers that are not finite in float32, or faces that name
            vertices that are not there.
    """
    positions, indices = checked(vertices, faces, "<f4")
    document = {
        "asset": {"version": "2.0", "generator": "geodesicd for Python"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": name}],
        "meshes": [{"name": name, "primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {
                "bufferView": 0,
                "componentType": _FLOAT,
                "count": len(positions),
                "type": "VEC3",
                "min": positions.min(axis=0).tolist(),
                "max": positions.max(axis=0).tolist(),
            },
            {
                "bufferView": 1,
                "componentType": _UNSIGNED_INT,
                "count": indices.size,
                "type": "SCALAR",
            },
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": positions.nbytes, "target": _VERTICES},
            {
                "buffer": 0,
                "byteOffset": positions.nbytes,
                "byteLength": indices.nbytes,
                "target": _INDICES,
            },
        ],
        "buffers": [{"byteLength": positions.nbytes + indices.nbytes}],
    }
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    size = positions.nbytes + indices.nbytes  # of four-byte numbers: needs no padding
    head = struct.pack("<4sIIII", b"glTF", 2, 12 + 8 + len(text) + 8 + size, len(text), 0x4E4F534A)
    return b"".join(
        [head, text, struct.pack("<II", size, 0x004E4942), positions.data, indices.data]
    )
