"""What the command says to who does not know Python, and how points are written for it."""

from __future__ import annotations

import re
import socket
import ssl
from pathlib import Path

import httpx
import numpy as np
import pytest
from command import geodesic

import geodesicd
from geodesicd import errors, hints
from geodesicd.points import point_of
from geodesicd.surface_regions import region_of, walls_of

PYTHON = re.compile(r"[a-z_]\w*\(|\w=(?!DIR)|\b(client|mesh|numpy)\.|\bClient\b|\bmax_snap\b")


def of_causes(*causes: BaseException) -> list[httpx.RequestError]:
    """Connections that failed because of these."""
    failures: list[httpx.RequestError] = []
    for cause in causes:
        failure = httpx.ConnectError("no")
        failure.__cause__ = cause
        failures.append(failure)
    return failures


def all_hints() -> list[str]:
    """All that a reply or a missing one leads to."""
    found = [hints.of_error(422, code, "", None) for code in hints._OF_CODE]
    found += [hints.of_error(status, f"http_{status}", "", None) for status in range(300, 600)]
    for code in ("too_large", "too_much_memory"):
        for word in ("kept", "body", "reply", "computation"):
            found.append(hints.of_error(422, code, word, None))
    found.append(hints.of_error(422, "index_out_of_range", "", 9))
    tls = (ssl.SSLCertVerificationError(), ssl.SSLError(), ssl.SSLEOFError())
    silent = [httpx.ReadTimeout("no"), httpx.ReadError("no"), httpx.ConnectTimeout("no")]
    for failure in [*of_causes(socket.gaierror(), *tls), *silent]:
        found.append(hints.of_failure(failure))
    return [one for one in found if one is not None]


def test_no_hint_for_a_shell_speaks_python() -> None:
    told = all_hints()
    assert sum(PYTHON.search(one) is not None for one in told) > 10
    for hint in told:
        assert not PYTHON.search(hints.in_shell(hint)), hint
    for phrase in hints._IN_SHELL:
        assert any(phrase in hint for hint in told), phrase


def test_hints_are_for_the_command_line(
    server: geodesicd.LocalServer, plane: geodesicd.Mesh, samples: Path, tmp_path: Path
) -> None:
    loop = geodesic(server, "loop", plane.id, "--at", "0", "--normal", "1,1,0", status=1).stderr
    assert "no_loop" in loop
    assert loop.rstrip().endswith("'geodesic path' needs none.")
    asked = ("path", plane.id, "--from", "0", "--to", "1")
    unknown = geodesic(server, *asked, "--method", "x", status=1).stderr
    assert unknown.rstrip().endswith("/v1/methods of the server says what each is for.")
    nobody = geodesic(server, "list", "--url", "http://127.0.0.1:1", status=1).stderr
    assert "--url or $GEODESICD_URL" in nobody
    assert "Client(" not in nobody
    to_many = ("map", "distance", "--from", "0", "--method", "x", "--workers", "1")
    out, file = tmp_path / "out.zarr", samples / "plane.glb"
    many = geodesic(server, *to_many, "-o", out, file, status=1).stderr
    assert "/v1/methods of the server says what each is for." in many
    assert "client.methods()" not in many
    with pytest.raises(geodesicd.GeodesicError, match=r"mesh\.path needs none") as caught:
        plane.loop(at=0, normal=(1, 1, 0))
    assert str(caught.value).replace("mesh.path", "'geodesic path'") == caught.value.in_shell()
    assert errors.GeodesicError(418, "teapot", "no").in_shell() == "teapot: no"


@pytest.mark.parametrize("command", ["voronoi", "path", "upload", "map", "map distance"])
def test_what_is_asked_wrongly_is_said_by_the_command(
    server: geodesicd.LocalServer, command: str
) -> None:
    told = geodesic(server, *command.split(), status=2).stderr.splitlines()
    assert told[0].startswith(f"usage: geodesic {command} ")
    assert told[-1].startswith(f"geodesic {command}: error: ")


def test_help_names_lines_and_faces(server: geodesicd.LocalServer) -> None:
    for command in ("distance", "path", "table", "measure", "voronoi", "plot", "map matrix"):
        told = geodesic(server, *command.split(), "--help").stdout
        for word in ("p:X,Y,Z", "f:FACE,W0,W1", "ray:", "curve:", "boundary", "faces:", "label:"):
            assert word in told
    assert "curve:" not in geodesic(server, "logmap", "--help").stdout


def test_vertices_of_lines_are_numbers(
    server: geodesicd.LocalServer, plane: geodesicd.Mesh
) -> None:
    for short, whole in (
        ("curve:0;9", "curve:v:0;v:9"),
        ("curve:closed;0;v:9;p:1,2,3", "curve:closed;v:0;v:9;p:1,2,3"),
        ("curve:", "curve:"),
        ("faces:0;9", "faces:0;9"),
        ("v:0", "v:0"),
    ):
        assert point_of(short).text() == whole
    assert region_of("inside:0;9;ray:0,0,9,0,0,-1").text() == "inside:v:0;v:9;ray:0,0,9,0,0,-1"
    assert region_of("part:0;9").text() == "part:0;9"
    said = walls_of(["0;9", "v:1;2"])
    assert said is not None
    assert [one.text() for one in said] == ["v:0;v:9", "v:1;v:2"]
    asked = ("distance", plane.id, "--from", "curve:1010;1090", "--at", "303", "--method", "exact")
    more = ("--walls", "2020;2030", "--forbid", "inside:5050;5060;6060")
    told = geodesic(server, *asked, *more).stdout
    assert float(told) == pytest.approx(7 * np.sqrt(2))
