"""A .gltf file with its buffers in other files is uploaded by its path alone."""

from __future__ import annotations

import asyncio
import json
import os
import re
import struct
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import PROGRAM
from test_precision import grid

import geodesicd
from geodesicd.gltf_files import form


def write_scene(folder: Path, names: tuple[str, str], **more: Any) -> Path:
    """A plane of 5 x 5 vertices whose positions are in one file and whose corners in another."""
    vertices, faces = grid(5, 1, (0, 0, 0))
    glb = geodesicd.glb_bytes(vertices, faces)
    (length,) = struct.unpack_from("<I", glb, 12)
    document = json.loads(glb[20 : 20 + length])
    binary = glb[20 + length + 8 :]
    cut = 25 * 12
    document["buffers"] = [
        {"byteLength": cut, "uri": names[0]},
        {"byteLength": len(binary) - cut, "uri": names[1]},
    ]
    document["bufferViews"][1].update(buffer=1, byteOffset=0)
    document["images"] = [{"uri": "textures/colour.png"}]
    for name, data in zip(names, (binary[:cut], binary[cut:]), strict=True):
        file = folder / name.replace("%20", " ").removeprefix("./")
        if ".." not in name and ":" not in name:
            file.parent.mkdir(exist_ok=True, parents=True)
            file.write_bytes(data)
    scene = folder / "scene.gltf"
    scene.write_text(json.dumps({**document, **more}))
    return scene


@pytest.mark.parametrize(
    "names",
    [
        ("scene.bin", "corners.bin"),
        ("./data/two words.bin", "data/café.bin"),
        ("two%20words.bin", 'a"b.bin'),
    ],
)
def test_by_its_path_alone(
    client: geodesicd.Client, tmp_path: Path, names: tuple[str, str]
) -> None:
    scene = write_scene(tmp_path, names)
    told: list[float] = []
    mesh = client.upload(scene, progress=told.append)
    assert (mesh.vertices, mesh.faces, mesh.format) == (25, 32, "glb")
    assert told[-1] == 1
    # As clients/curl does it, with the image, too: the same mesh.
    (tmp_path / "colour.png").write_bytes(b"\x89PNG")
    forms = [f"files=@{tmp_path / 'colour.png'}"]
    if names[0] == "scene.bin":
        forms += [f"files=@{tmp_path / name}" for name in ("scene.gltf", *names)]
        options = [part for form in forms for part in ("-F", form)]
        curl = ["curl", "-s", "--noproxy", "*", *options, f"{client.url}/v1/meshes"]
        reply = subprocess.run(curl, capture_output=True, check=True, timeout=60).stdout
        assert json.loads(reply)["id"] == mesh.id
    np.testing.assert_array_equal(mesh.distance(0, method="exact")[:5], range(5))


@pytest.mark.parametrize(
    ("name", "told"),
    [("a\\", "a/"), ("\\", "/"), ("a\\\\", "a//"), ("a\\\\b", "a//b"), ('a"b\\', 'a"b/'),
     ('\\"', '\\"'), ("a\\b.bin", "a\\b.bin"), ("größe 100 %.bin", "größe 100 %.bin")],
)  # fmt: skip
def test_a_file_has_one_name_in_a_form_however_backslashes_are_read(
    tmp_path: Path, name: str, told: str
) -> None:
    (tmp_path / name).write_bytes(b"123")
    _, pieces = form({name: tmp_path / name})
    text = b"".join(piece for piece in pieces if isinstance(piece, bytes)).decode()
    # As itself (browsers), and as an escape (RFC 2183).
    (plain,) = re.findall(r'; filename="([^"]*)"\r\n', text)
    (escaped,) = re.findall(r'; filename="((?:[^"\\]|\\.)*)"\r\n', text)
    escaped = re.sub(r'\\(["\\])', r"\1", escaped)
    assert {plain.replace("%22", '"'), escaped.replace("%22", '"')} == {told}


def test_it_is_read_as_it_is_told(client: geodesicd.Client, tmp_path: Path) -> None:
    scene = write_scene(tmp_path, ("a.bin", "b.bin"))
    mesh = client.upload(str(scene), scale=10)
    assert mesh.bbox[1].tolist() == [40, 40, 0]

    async def ask() -> str:
        async with geodesicd.AsyncClient(client.url) as other:
            return (await other.upload(scene, scale=10)).id

    assert asyncio.run(ask()) == mesh.id
    environment = {**os.environ, "GEODESICD_URL": client.url}
    command = [PROGRAM, "upload", str(scene)]
    run = subprocess.run(
        [*command, "--scale", "10"], capture_output=True, text=True, env=environment, check=True
    )
    assert run.stdout.strip() == mesh.id


def test_files_that_are_not_there_are_named(client: geodesicd.Client, tmp_path: Path) -> None:
    scene = write_scene(tmp_path, ("a.bin", "deep/b.bin"))
    (tmp_path / "a.bin").unlink()
    with pytest.raises(FileNotFoundError, match=r"scene.gltf names a.bin, which is not in"):
        client.upload(scene)
    (tmp_path / "deep" / "b.bin").unlink()
    with pytest.raises(FileNotFoundError, match=r"names a.bin, deep/b.bin, which are not in"):
        client.upload(scene)


@pytest.mark.parametrize("name", ["../b.bin", "/etc/hostname", "https://example.org/b.bin"])
def test_no_other_file_is_sent(client: geodesicd.Client, tmp_path: Path, name: str) -> None:
    with pytest.raises(ValueError, match="not in its folder"):
        client.upload(write_scene(tmp_path, ("a.bin", name)))


def test_what_is_no_gltf_is_the_servers_to_say(client: geodesicd.Client, tmp_path: Path) -> None:
    for text in ("no JSON", "[]", '{"buffers": 3}'):
        (tmp_path / "bad.gltf").write_text(text)
        with pytest.raises(geodesicd.GeodesicError) as caught:
            client.upload(tmp_path / "bad.gltf")
        assert caught.value.status in (415, 422)
