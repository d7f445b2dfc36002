"""What meshes are called: by their files, by a name that is given, and on a command line."""

from __future__ import annotations

import asyncio
import hashlib
import json
import os
import pty
import re
import shutil
import struct
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from command import PROGRAM, geodesic
from test_contract_cases import TABLE
from test_gltf_files import write_scene

import geodesicd
from geodesicd.bench.mixes import hills
from geodesicd.flows import Request
from geodesicd.lookup import mesh_id, reading_text, short_ids
from geodesicd.mesh_input import name_of
from geodesicd.wire import Reply

FILE_NAMES = TABLE["file_names"]
# What a file is called, and what its mesh is called then.
CLEANED: list[tuple[str, str | None]] = [
    *map(tuple, FILE_NAMES["rows"]),
    (f"a{FILE_NAMES['refused']}b.glb", "ab.glb"),
    (f"a{FILE_NAMES['taken']}.glb", f"a{FILE_NAMES['taken']}.glb"),
    ("gr\udcf6\udcdfe.glb", "gre.glb"),  # a file system's bytes that are no UTF-8
    ("\udcff", None),
]


@pytest.fixture(scope="module")
def own() -> Iterator[geodesicd.LocalServer]:
    """A server whose meshes are these tests' only."""
    running = geodesicd.serve(flags=["--log-level", "warn"])
    running.start()
    yield running
    running.stop()


@pytest.fixture
def named(own: geodesicd.LocalServer) -> Iterator[geodesicd.Client]:
    """A client of that server, which has no mesh."""
    with geodesicd.Client(own.url) as client:
        for mesh in client.meshes():
            mesh.delete()
        yield client


@pytest.mark.parametrize("ending", ["glb", "drc"])
def test_a_file_gives_its_name(named: geodesicd.Client, samples: Path, ending: str) -> None:
    file = samples / f"plane.{ending}"
    mesh = named.upload(file)
    assert mesh.name == f"plane.{ending}"
    assert repr(mesh) == f"<Mesh 'plane.{ending}' {mesh.id[:8]} 10000 vertices 19602 faces>"
    assert named.mesh(mesh.id).name == mesh.name
    read = named.upload(str(file), scale=2.0, name="twice")
    assert (read.name, read.id.partition("~")[0]) == ("twice", mesh.id)
    # Two readings of one file are told apart.
    short = f"{mesh.id[:8]}~{read.id.partition('~')[2][:4]}"
    assert repr(read) == f"<Mesh 'twice' {short} scale=2 10000 vertices 19602 faces>"
    # A mesh that has a name keeps it, sent again or not.
    for probe in (True, False):
        assert named.upload(file, name="another", probe=probe).name == f"plane.{ending}"


def test_a_gltf_file_with_others_beside_it_has_its_name(
    named: geodesicd.Client, tmp_path: Path
) -> None:
    (tmp_path / "a.gltf").write_text(
        '{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": '
        '[{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], '
        '"accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", '
        '"min": [0, 0, 0], "max": [1, 1, 0]}], "bufferViews": [{"buffer": 0, "byteLength": 36}], '
        '"buffers": [{"uri": "a.bin", "byteLength": 36}]}'
    )
    corners = (0, 0, 0, 1, 0, 0, 0, 1, 0)
    (tmp_path / "a.bin").write_bytes(struct.pack("<9f", *corners))
    assert named.upload(tmp_path / "a.gltf").name == "a.gltf"


def test_arrays_and_bytes_have_no_name_unless_given(named: geodesicd.Client) -> None:
    mesh = named.upload(hills(4, 1))
    assert mesh.name is None
    assert repr(mesh) == f"<Mesh {mesh.id[:8]} 16 vertices 18 faces>"
    data = geodesicd.glb_bytes(*hills(4, 2))
    assert named.upload(data).name is None
    # One that is there already and has no name gets one, also where it need not be sent again.
    assert named.upload(data, name="dünen & höhen 1/2").name == "dünen & höhen 1/2"
    assert named.upload(hills(4, 3), name="mine").name == "mine"


@pytest.mark.parametrize(("name", "kept"), CLEANED)
def test_no_upload_fails_for_a_files_name(
    named: geodesicd.Client, samples: Path, tmp_path: Path, name: str, kept: str | None
) -> None:
    assert name_of(Path(name)) == kept
    file = tmp_path / name.replace("\0", "")  # no file system has that
    shutil.copy(samples / "sphere.glb", file)
    assert named.upload(file).name == kept
    mesh = named.upload(file, probe=False).rename("")
    assert named.upload(file).name == kept  # of a mesh that is there
    assert mesh.refresh().name == kept


@pytest.mark.parametrize(
    "name", ["a\nb.gltf", "\u2028\x85.gltf", "\udcff.gltf", f"{'x' * 201}.gltf"]
)
def test_no_form_fails_for_a_files_name(named: geodesicd.Client, tmp_path: Path, name: str) -> None:
    scene = write_scene(tmp_path, ("a.bin", "b.bin")).rename(tmp_path / name)
    mesh = named.upload(scene)
    assert (mesh.vertices, mesh.name) == (25, name_of(scene))


def test_the_server_refuses_what_the_table_says_and_takes_the_rest(
    named: geodesicd.Client, samples: Path
) -> None:
    mesh = named.upload(samples / "sphere.glb")
    for letter in FILE_NAMES["refused"]:
        with pytest.raises(geodesicd.GeodesicError) as caught:
            mesh.rename(f"a{letter}b")
        assert (caught.value.status, caught.value.parameter) == (400, "name"), repr(letter)
    for letter in FILE_NAMES["taken"]:
        assert mesh.rename(f"a{letter}b").name == f"a{letter}b"


def problem(status: int, code: str) -> Reply:
    body = bytearray(f'{{"status": {status}, "code": "{code}", "detail": "no"}}'.encode())
    return Reply(status, {"content-type": "application/problem+json"}, body)


NO_NAMING: dict[str, Reply | Exception] = {
    "forbidden": problem(403, "forbidden"),
    "refused": problem(400, "bad_syntax"),
    "gone": problem(404, "mesh_unknown"),
    "failing": problem(500, "store_failed"),
    "full": problem(507, "store_full"),
    "too much": problem(503, "overloaded"),
    "between": Reply(200, {}, bytearray(b"<html>")),
    "lost": geodesicd.ConnectionFailed("lost", sent=True),
}


@pytest.mark.parametrize("why", NO_NAMING)
def test_an_upload_fails_for_its_naming_only_where_the_name_was_asked_for(
    named: geodesicd.Client, samples: Path, why: str
) -> None:
    class Unnaming(geodesicd.Client):
        def _send(self, request: Request) -> Reply:
            if request.method != "PATCH":
                return super()._send(request)
            outcome = NO_NAMING[why]
            if isinstance(outcome, Exception):
                raise outcome
            return outcome

    file = samples / "sphere.glb"
    there = named.upload(file.read_bytes())
    with Unnaming(named.url, retries=geodesicd.Retries(attempts=1)) as client:
        mesh = client.upload(file)
        assert (mesh.id, mesh.name) == (there.id, None)
        for asked in (file, file.read_bytes()):
            with pytest.raises(geodesicd.GeodesicError):
                client.upload(asked, name="ball")
    assert there.refresh().name is None


def test_renaming(named: geodesicd.Client, samples: Path) -> None:
    mesh = named.upload(samples / "sphere.glb")
    assert mesh.rename("the ball") is mesh
    assert mesh.name == named.mesh(mesh.id).name == named.meshes()[0].name == "the ball"
    assert mesh.rename("").name is None
    assert named.mesh(mesh.id).name is None
    assert named.mesh(mesh.rename("the ball").id[:9]).id == named.mesh("the ball").id == mesh.id
    for nothing in ("the bal", "../status", "", "0" * 63):
        with pytest.raises(geodesicd.NotFound, match="has the name"):
            named.mesh(nothing)
    for wrong in ("x" * 201, "a\nb", "\x7f"):
        with pytest.raises(geodesicd.GeodesicError) as caught:
            mesh.rename(wrong)
        assert (caught.value.status, caught.value.parameter) == (400, "name")
    mesh.delete()
    with pytest.raises(geodesicd.NotFound):
        mesh.rename("gone")

    async def asynchronously() -> None:
        async with geodesicd.AsyncClient(named.url) as client:
            ball = await client.upload(samples / "sphere.glb")
            assert ball.name == "sphere.glb"
            assert (await ball.rename("b")).name == "b"
            assert (await client.mesh("b")).id == ball.id
            assert (await ball.rename("")).name is None
            assert (await client.upload(samples / "sphere.glb", name="c")).name == "c"

    asyncio.run(asynchronously())


def test_a_token_that_may_only_read_uploads_what_is_known(samples: Path, tmp_path: Path) -> None:
    tokens = {"reader": "read", "admin": "read,upload,admin"}
    lines = [f"{who} {may} {hashlib.sha256(who.encode()).hexdigest()}\n" for who, may in
             tokens.items()]  # fmt: skip
    (tmp_path / "tokens").write_text("".join(lines))
    (tmp_path / "tokens").chmod(0o600)
    server = geodesicd.serve(flags=["--tokens", str(tmp_path / "tokens")])
    url = server.start()
    try:
        with geodesicd.Client(url, token="admin") as admin:
            unnamed = admin.upload((samples / "sphere.glb").read_bytes())
        with geodesicd.Client(url, token="reader") as reader:
            mesh = reader.upload(samples / "sphere.glb")
            assert (mesh.id, mesh.name) == (unnamed.id, None)
            with pytest.raises(geodesicd.NotAllowed):
                reader.upload(samples / "sphere.glb", name="ball")
    finally:
        server.stop()


def test_the_command_takes_names(
    own: geodesicd.LocalServer, named: geodesicd.Client, samples: Path
) -> None:
    plane = geodesic(own, "upload", samples / "plane.glb", "--name", "the plane").stdout.strip()
    small = geodesic(own, "upload", samples / "plane.glb", "--scale", "0.001").stdout.strip()
    listed = [line.split("\t") for line in geodesic(own, "list").stdout.splitlines()]
    assert [(row[0], row[1], row[-1]) for row in listed] == [
        (plane, "the plane", ""), (small, "plane.glb", "scale=0.001")
    ]  # fmt: skip
    far = ("--from", "0", "--at", "99", "--method", "exact")
    shorts = short_ids([plane, small])
    for text, length in (
        ("the plane", 99), (plane, 99), (plane[:4], 99), (shorts[plane], 99),
        ("plane.glb", 0.099), (small, 0.099), (small[:70], 0.099), (shorts[small], 0.099),
    ):  # fmt: skip
        told = geodesic(own, "distance", text, *far)
        assert float(told.stdout) == pytest.approx(length)
    again = geodesic(own, "upload", samples / "plane.glb", "--name", "other")
    assert (again.stdout.strip(), "'the plane'" in again.stderr) == (plane, True)
    assert geodesic(own, "rename", "the plane", "plane.glb").stdout.strip() == plane
    for command in (("distance", "plane.glb", *far), ("delete", "plane.glb"),
                    ("rename", "plane.glb", "x")):  # fmt: skip
        refused = geodesic(own, *command, status=1).stderr
        assert "any of 2 meshes" in refused
        assert shorts[plane] in refused
        assert re.search(f"{shorts[small]}  plane.glb  scale=0.001$", refused, re.MULTILINE)
    geodesic(own, "rename", shorts[small], "")
    assert named.mesh(small).name is None
    picture = samples / "named.png"
    geodesic(own, "plot", "plane.glb", "--from", "0", "--isolines", "0", "-o", picture)
    # So many requests are due however slow the machine is.
    load = ("--seconds", "1", "--rate", "3", "--mix", "path", "--json", "-")
    outcome = json.loads(geodesic(own, "bench", "--mesh", "plane.glb", *load).stdout)
    assert (outcome["latency_by_kind"]["path"]["count"], outcome["errors"]["count"]) == (3, 0)
    assert geodesic(own, "delete", "plane.glb").stdout.strip() == plane
    assert [mesh.id for mesh in named.meshes()] == [small]
    for unknown in ("plane.glb", "abcd", "f" * 64, "the plane"):
        assert geodesic(own, "delete", unknown, status=1).stderr.startswith("geodesic: ")
    missing = geodesic(own, "path", "nowhere.glb", "--from", "0", "--to", "1", status=1).stderr
    assert "no file nowhere.glb" in missing
    assert "geodesic list" in missing
    one_name = (samples / "plane.glb", samples / "sphere.glb", "--name", "both")
    assert "one file" in geodesic(own, "upload", *one_name, status=2).stderr


def test_a_beginning_that_fits_two_files_is_refused(
    own: geodesicd.LocalServer, named: geodesicd.Client
) -> None:
    ids: set[str] = set()
    for seed in range(3000):  # until two begin alike: after some 300
        mesh = named.upload(hills(2, seed))
        if mesh.id[:4] in ids:
            break
        ids.add(mesh.id[:4])
    with pytest.raises(ValueError, match="any of 2 meshes"):
        named.run(mesh_id(mesh.id[:4]))
    shorts = short_ids(one.id for one in named.meshes())
    for whole, short in shorts.items():
        assert named.run(mesh_id(short)) == whole


@pytest.mark.parametrize("length", [4, 8, 9, 63])
def test_a_name_does_not_go_before_the_beginning_of_another_meshs_id(
    own: geodesicd.LocalServer, named: geodesicd.Client, length: int
) -> None:
    victim, other = named.upload(hills(4, 11)), named.upload(hills(4, 12))
    begun = victim.id[:length]
    other.rename(begun)
    with pytest.raises(ValueError, match="any of 2 meshes"):
        named.mesh(begun)
    for command in (("delete", begun), ("rename", begun, "x"),
                    ("distance", begun, "--from", "0", "--at", "1")):  # fmt: skip
        refused = geodesic(own, *command, status=1).stderr
        assert "any of 2 meshes" in refused
        # Each of them can be told by what is told of it.
        told = [line.split()[0] for line in refused.splitlines()[1:]]
        assert {named.mesh(id).id for id in told} == {victim.id, other.id}
    assert {mesh.id for mesh in named.meshes()} == {victim.id, other.id}
    assert other.refresh().name == begun
    # A whole id is an id, or nothing could be said by it.
    other.rename(victim.id)
    assert named.mesh(victim.id).id == victim.id
    # A mesh may be called as its own id begins.
    other.rename("")
    victim.rename(begun)
    assert named.mesh(begun).id == victim.id


def test_a_beginning_with_readings_is_hidden_by_no_name(named: geodesicd.Client) -> None:
    data = geodesicd.glb_bytes(*hills(4, 13))
    plain, scaled = named.upload(data), named.upload(data, scale=2.0)
    other = named.upload(hills(4, 14), name=scaled.id[:70])
    with pytest.raises(ValueError, match="any of 2 meshes"):
        named.mesh(scaled.id[:70])
    other.rename(plain.id[:6])
    with pytest.raises(ValueError, match="any of 2 meshes") as caught:
        named.mesh(plain.id[:6])
    assert other.id[:8] in str(caught.value)
    # Of the readings of the same file the plain one is meant, as without a name.
    assert scaled.id[:70] not in str(caught.value)
    other.delete()
    scaled.rename(plain.id[:6])
    with pytest.raises(ValueError, match="any of 2 meshes"):
        named.mesh(plain.id[:6])


def test_a_folder_is_no_mesh_of_that_name(
    own: geodesicd.LocalServer,
    named: geodesicd.Client,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("ball", "nothing"):
        Path(name).mkdir()
    named.upload(hills(4, 15), name="ball")
    assert geodesic(own, "distance", "ball", "--from", "0", "--at", "0").stdout.strip() == "0"
    load = ("--seconds", "1", "--rate", "1", "--mix", "path")
    geodesic(own, "bench", "--mesh", "ball", *load)
    geodesic(own, "plot", "ball", "--from", "0", "-o", "ball.png")
    refused = geodesic(own, "path", "nothing", "--from", "0", "--to", "1", status=1).stderr
    assert "no file nothing" in refused


def test_a_terminal_shows_names_as_they_are_and_obeys_none(
    own: geodesicd.LocalServer, named: geodesicd.Client
) -> None:
    wild = "[red]\u200b31m \u200fgnp.exe[/nothing]"  # the worst that a server takes
    mesh = named.upload(hills(4, 5), name=wild)
    long = named.upload(hills(4, 6), name="n" * 200, weld="off")
    ours, theirs = pty.openpty()
    environment = {**os.environ, "GEODESICD_URL": own.url, "TERM": "xterm-256color",
                   "COLUMNS": "80"}  # fmt: skip
    with subprocess.Popen([PROGRAM, "list"], stdout=theirs, stderr=theirs, env=environment) as run:
        os.close(theirs)
        written = b""
        try:
            while data := os.read(ours, 4096):
                written += data
        except OSError:  # Linux's way of telling the end
            pass
        os.close(ours)
    text = written.decode()
    assert run.returncode == 0, text
    shown = re.sub(r"\x1b\[[0-9;]*m", "", text)
    assert "\u200b" not in shown
    assert "\u200f" not in shown
    shorts = short_ids([mesh.id, long.id])
    for short in shorts.values():
        assert short in shown
    joined = re.sub(r"\s", "", shown)
    assert "[red]?31m" in joined
    assert "weld=off" in joined
    refused = geodesic(own, "delete", "abcdefg\x1b[2J", status=1).stderr
    assert "\x1b" not in refused


def test_short_ids_are_as_long_as_they_must() -> None:
    a, b = "0" * 64, "0" * 30 + "1" * 34
    assert set(short_ids([a, b]).values()) == {a[:31], b[:31]}
    assert short_ids([a]) == {a: a[:8]}
    read = [f"{a}~{digits:032x}" for digits in (1, 2)]
    assert len(set(short_ids([a, *read]).values())) == 3
    assert short_ids([]) == {}
    assert reading_text({"up": "z", "node": "a\nb"}) == "node=a?b up=z"
