"""Fields in the file that was uploaded, read back from its bytes."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import geodesic
from numpy.typing import NDArray

import geodesicd


def parts_of(glb: bytes) -> tuple[dict[str, Any], bytes]:
    """A GLB's JSON and its binary chunk."""
    magic, version, length = struct.unpack_from("<4sII", glb)
    assert (magic, version, length) == (b"glTF", 2, len(glb))
    size, kind = struct.unpack_from("<I4s", glb, 12)
    assert kind == b"JSON"
    at = 20 + size
    binary, kind = struct.unpack_from("<I4s", glb, at)
    assert kind == b"BIN\0"
    assert at + 8 + binary == len(glb)
    return json.loads(glb[20:at]), glb[at + 8 :]


def attribute(glb: bytes, name: str) -> NDArray[np.float32]:
    """An attribute of the first primitive, a row for each vertex."""
    document, binary = parts_of(glb)
    accessor = document["accessors"][document["meshes"][0]["primitives"][0]["attributes"][name]]
    view = document["bufferViews"][accessor["bufferView"]]
    width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3}[accessor["type"]]
    assert accessor["componentType"] == 5126
    assert view["byteStride"] == 4 * width
    start = view["byteOffset"] + accessor["byteOffset"]
    count = accessor["count"] * width
    return np.frombuffer(binary, "<f4", count, start).reshape(-1, width)


def test_a_field_is_read_back_from_the_file(plane: geodesicd.Mesh) -> None:
    before, binary = parts_of(plane.source())
    file = plane.annotated(5050, attribute="_HEAT", max=40)
    field = plane.distance(5050, max=40, dtype=np.float32)
    expected = np.where(np.isinf(field), np.float32(-1), field)
    assert (expected < 0).any()
    np.testing.assert_array_equal(attribute(file, "_HEAT")[:, 0], expected)
    # All else is as it was.
    after, longer = parts_of(file)
    assert longer[: len(binary)] == binary
    for mesh in after["meshes"]:
        for primitive in mesh["primitives"]:
            del primitive["attributes"]["_HEAT"]
    assert after["accessors"].pop()["count"] == len(field)
    after["bufferViews"].pop()
    after["buffers"][0]["byteLength"] = before["buffers"][0]["byteLength"]
    assert json.dumps(after) == json.dumps(before)


def test_labels_are_an_attribute_of_their_own(plane: geodesicd.Mesh) -> None:
    sources = [0, 99, 9999]
    file = plane.annotated(sources, labels=True, max=60)
    distances, labels = plane.regions(sources, max=60)
    told = attribute(file, "_GEODESIC_SOURCE")[:, 0]
    np.testing.assert_array_equal(told, labels)
    assert set(told) == {-1, 0, 1, 2}
    reached = labels >= 0
    told = attribute(file, "_GEODESIC_DISTANCE")[:, 0]
    np.testing.assert_array_equal(told[reached], distances[reached].astype(np.float32))
    assert (told[~reached] == -1).all()


def test_it_can_be_uploaded_again(client: geodesicd.Client, plane: geodesicd.Mesh) -> None:
    again = client.upload(plane.annotated(7))
    assert again.id != plane.id
    np.testing.assert_array_equal(again.distance(7), plane.distance(7))
    with pytest.raises(geodesicd.GeodesicError, match="another name"):
        again.annotated(7)
    again.delete()


def test_a_file_of_another_format_is_refused(client: geodesicd.Client, samples: Path) -> None:
    mesh = client.upload(samples / "plane.drc")
    with pytest.raises(geodesicd.GeodesicError, match="format=glb"):
        mesh.annotated(0)


def test_the_commands(server: geodesicd.LocalServer, plane: geodesicd.Mesh, tmp_path: Path) -> None:
    file = tmp_path / "annotated.glb"
    geodesic(server, "distance", plane.id, "--from", "0", "--into", file)
    assert file.read_bytes() == plane.annotated(0)
    asked = ("--attribute", "_MAP", "--radius", "9", "--into", file)
    geodesic(server, "logmap", plane.id, "--from", "5050", *asked)
    found = plane.logmap(5050, 9)
    told = attribute(file.read_bytes(), "_MAP")
    np.testing.assert_array_equal(told[found.vertices, :2], found.coordinates.astype(np.float32))
    np.testing.assert_array_equal(told[found.vertices, 2], found.distances.astype(np.float32))
    assert (told[:, 2] == -1).sum() == plane.vertices - len(found)
    for wrong in (["--into", "a.obj"], ["--into", "a.gltf"], ["--into", "a.glb", "--at", "3"]):
        geodesic(server, "distance", plane.id, "--from", "0", *wrong, status=2)
    for command in ("distance", "logmap"):
        alone = (command, plane.id, "--from", "0", "--attribute", "_HEAT", "-o", tmp_path / "a.csv")
        assert "--attribute is for --into" in geodesic(server, *alone, status=2).stderr
    assert not (tmp_path / "a.csv").exists()


def test_signed_distances_are_an_attribute_of_another_name(plane: geodesicd.Mesh) -> None:
    curve = geodesicd.Curve([3020, 3060, 5060, 5020], closed=True)
    file = plane.annotated(curve, signed=True, max=15)
    field = plane.distance(curve, signed=True, max=15, dtype=np.float32)
    expected = np.where(np.isinf(field), np.finfo(np.float32).max, field)
    assert (expected < 0).any()
    assert np.isinf(field).any()
    told = attribute(file, "_GEODESIC_SIGNED_DISTANCE")[:, 0]
    np.testing.assert_array_equal(told, expected)


def test_the_mesh_s_own_file_stays(
    server: geodesicd.LocalServer, plane: geodesicd.Mesh, tmp_path: Path
) -> None:
    file = tmp_path / "own.glb"
    file.write_bytes(plane.source())
    before = file.read_bytes()
    geodesic(server, "distance", file, "--from", "0", "--into", file, status=2)
    assert file.read_bytes() == before
