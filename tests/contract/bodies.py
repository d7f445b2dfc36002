"""Mesh files that are refused, each with the code that it is refused with."""

import base64
import json
import struct


def _gltf(positions, indices=None, **changes):
    data = struct.pack(f"<{len(positions)}f", *positions)
    buffers = len(data)
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [
            {
                "bufferView": 0,
                "componentType": 5126,
                "count": len(positions) // 3,
                "type": "VEC3",
                "min": [0, 0, 0],
                "max": [1, 1, 0],
            }
        ],
        "bufferViews": [{"buffer": 0, "byteLength": buffers}],
    }
    if indices is not None:
        packed = struct.pack(f"<{len(indices)}I", *indices)
        document["meshes"][0]["primitives"][0]["indices"] = 1
        document["accessors"].append(
            {"bufferView": 1, "componentType": 5125, "count": len(indices), "type": "SCALAR"}
        )
        document["bufferViews"].append(
            {"buffer": 0, "byteOffset": buffers, "byteLength": len(packed)}
        )
        data += packed
    text = base64.b64encode(data).decode()
    document["buffers"] = [
        {"byteLength": len(data), "uri": f"data:application/octet-stream;base64,{text}"}
    ]
    document.update(changes)
    return json.dumps(document).encode()


_TRIANGLE = [0, 0, 0, 1, 0, 0, 0, 1, 0]
_ELSEWHERE = [{"byteLength": 36, "uri": "elsewhere.bin"}]

TRIANGLE = _gltf(_TRIANGLE)

# Two meshes in one file, and so a face without surface that touches no other.
NEEDLE = _gltf([0, 0, 0, 1, 0, 0, 0, 1, 0, 5, 5, 0, 5, 5, 0, 6, 5, 0], [0, 1, 2, 3, 4, 5])

# Moved by its node to where float32 does not reach.
HUGE = _gltf([0, 0, 0, 1e20, 0, 0, 0, 1e20, 0], nodes=[{"mesh": 0, "scale": [1e20] * 3}])

REFUSED = {
    "format_unknown": b"neither of them",
    "mesh_invalid": _gltf([0, 0, 0, 1, 0, 0, 0, float("nan"), 0]),
    "no_triangles": _gltf(
        _TRIANGLE, meshes=[{"primitives": [{"attributes": {"POSITION": 0}, "mode": 0}]}]
    ),
    "too_many_vertices": _gltf(_TRIANGLE * 40),
    "too_many_faces": _gltf(_TRIANGLE, [0, 1, 2] * 40),
    "external_uri": _gltf(_TRIANGLE, buffers=_ELSEWHERE),
    "extension_required": _gltf(
        _TRIANGLE, extensionsRequired=["EXT_unheard_of"], extensionsUsed=["EXT_unheard_of"]
    ),
    "index_out_of_range": _gltf(_TRIANGLE, [0, 1, 7]),
}
