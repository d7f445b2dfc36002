"""Files that commands write are whole, or what was there before stays."""

from __future__ import annotations

import resource
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from command import geodesic

import geodesicd

BEFORE = b"what was there before"

# Each command that writes files, with what it needs, and the endings.
WRITERS: dict[str, tuple[list[str], list[str]]] = {
    "distance": (["--from", "0"], ["npy", "csv"]),
    "path": (["--from", "0", "--to", "9999"], ["csv", "npy", "json", "glb"]),
    "table": (["--from", "0", "--from", "99", "--max", "200"], ["npy", "npz"]),
    "isolines": (["--from", "0", "--count", "3"], ["csv", "json", "glb"]),
    "trace": (["--from", "p:50.5,2.5,0", "--direction", "1,0,0", "--length", "9"],
              ["csv", "npy", "json", "glb"]),
    "samples": (["--count", "30"], ["csv", "npy", "json"]),
    "measure": (["--from", "0", "--radius", "20"], ["csv", "json"]),
    "extent": (["--of", "means", "--fields", "4"], ["npy", "csv"]),
    "voronoi": (["--from", "0", "--from", "99"], ["csv", "json", "png", "glb"]),
    "loop": (["--around", "202", "--around", "297", "--around", "9797"], ["csv", "npy", "json"]),
    "logmap": (["--from", "p:50,2,0", "--radius", "5"], ["csv", "npz", "json", "glb"]),
    "plot": (["--from", "0"], ["png", "svg", "pdf"]),
}  # fmt: skip
EACH = [(command, ending) for command, (_, endings) in WRITERS.items() for ending in endings]


@contextmanager
def small_files(most: int) -> Iterator[None]:
    """No file of this process may be larger: a stand-in for a full disk."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@pytest.mark.parametrize(("command", "ending"), EACH)
def test_a_full_disk_leaves_the_file_as_it_was(
    server: geodesicd.LocalServer, holes: geodesicd.Mesh, tmp_path: Path, command: str, ending: str
) -> None:
    file = tmp_path / f"out.{ending}"
    file.write_bytes(BEFORE)
    asked: list[str | Path] = [command, holes.id, *WRITERS[command][0], "-o", file]
    with small_files(64):
        failed = geodesic(server, *asked, status=1)
    assert str(file) in failed.stderr.replace("\n", "")
    assert failed.stdout == ""
    assert file.read_bytes() == BEFORE
    assert [one.name for one in tmp_path.iterdir()] == [file.name]
    geodesic(server, *asked)
    assert file.read_bytes() != BEFORE
    assert [one.name for one in tmp_path.iterdir()] == [file.name]


@pytest.mark.parametrize("command", WRITERS)
def test_no_folder_is_told_before_the_work(
    server: geodesicd.LocalServer, holes: geodesicd.Mesh, tmp_path: Path, command: str
) -> None:
    needs, endings = WRITERS[command]
    away = tmp_path / "none" / f"out.{endings[0]}"
    told = geodesic(server, command, holes.id, *needs, "-o", away, status=1)
    assert str(away.parent) in told.stderr.replace("\n", "")
    assert told.stdout == ""


def test_a_link_and_its_rights_stay(
    server: geodesicd.LocalServer, holes: geodesicd.Mesh, tmp_path: Path
) -> None:
    file, link = tmp_path / "file.csv", tmp_path / "link.csv"
    file.write_bytes(BEFORE)
    file.chmod(0o600)
    link.symlink_to(file)
    geodesic(server, "samples", holes.id, "--count", "3", "-o", link)
    assert link.is_symlink()
    assert file.read_bytes().startswith(b"vertex,x,y,z,radius\n")
    assert file.stat().st_mode & 0o777 == 0o600


def test_what_is_read_is_not_written_over(
    server: geodesicd.LocalServer, samples: Path, tmp_path: Path
) -> None:
    mesh, listed = tmp_path / "mesh.glb", tmp_path / "points.npy"
    mesh.write_bytes((samples / "plane.glb").read_bytes())
    listed.write_text("0 99")
    before = mesh.read_bytes()
    for asked in (
        ("isolines", mesh, "--from", "0", "--count", "2", "-o", mesh),
        ("path", mesh, "--from", "0", "--to", "9", "-o", tmp_path / "." / "mesh.glb"),
        ("table", mesh, "--from-file", listed, "-o", listed),
    ):
        assert "is what is read" in geodesic(server, *asked, status=2).stderr
    assert mesh.read_bytes() == before
    assert listed.read_text() == "0 99"


def test_files_of_points(
    server: geodesicd.LocalServer, holes: geodesicd.Mesh, tmp_path: Path
) -> None:
    from_windows, second = tmp_path / "windows.txt", tmp_path / "second.txt"
    from_windows.write_bytes(b"\xef\xbb\xbf# the corners\r\n0\r\n99\r\n")
    second.write_text("9999")
    out = tmp_path / "table.npy"
    both = ("--from-file", from_windows, "--from-file", second)
    geodesic(server, "table", holes.id, *both, "--to", "5", "-o", out)
    expected = holes.table([0, 99, 9999], [5])
    np.testing.assert_array_equal(np.load(out), expected)
    wrong = tmp_path / "wrong.txt"
    asked = ("table", holes.id, "--from", "0")
    for data, told in (
        (b"", "wrong.txt has no points"),
        (b"# none\n", "wrong.txt has no points"),
        ("0 1".encode("utf-16"), "no text in UTF-8"),
        (b"1 2 x:3", "to[2] is 'x:3'"),
    ):
        wrong.write_bytes(data)
        text = geodesic(server, *asked, "--to-file", wrong, status=1).stderr
        assert told in text.replace("\n", " ")
