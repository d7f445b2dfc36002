"""What a table's file holds when a run fails, and what was there before it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import geodesic
from test_large_tables import cut_client

import geodesicd
from geodesicd import Mesh, commands, growing_file

POINTS = list(range(0, 4000, 100))
ROW = 8 * len(POINTS)


def contents(folder: Path) -> dict[str, bytes]:
    """All files of a folder."""
    return {file.name: file.read_bytes() for file in folder.iterdir()}


def broken(plane: Mesh, file: Path, most: int, **options: Any) -> None:
    """Asks for a table whose stream breaks after so many bytes, and then for good."""
    client, _ = cut_client(plane.client.url, [most, 0, 0, 0, 0, 0, 0])
    with client, pytest.raises(geodesicd.ConnectionFailed):
        client.mesh(plane.id).table_file(file, POINTS, **options)


def refused(plane: Mesh, file: Path, **options: Any) -> None:
    """Asks for a table that the server refuses."""
    with pytest.raises(geodesicd.GeodesicError, match="index_out_of_range"):
        plane.table_file(file, [0, plane.vertices], **options)


def refused_command(plane: Mesh, file: Path, **_: Any) -> None:
    """The same from the command line."""
    asked = ("--from", "0", "--from", str(plane.vertices), "-o", str(file))
    assert commands.main(["table", plane.id, "--url", plane.client.url, *asked]) == 1


@pytest.mark.parametrize("ask", [refused, refused_command])
def test_a_refused_request_leaves_the_folder_as_it_was(
    plane: Mesh, tmp_path: Path, ask: Callable[..., None]
) -> None:
    file = tmp_path / "table.npy"
    ask(plane, file)
    assert contents(tmp_path) == {}
    plane.table_file(file, [0, 99])
    whole = contents(tmp_path)
    assert list(whole) == ["table.npy"]
    ask(plane, file)
    assert contents(tmp_path) == whole
    broken(plane, file, 3 * ROW)
    part = contents(tmp_path)
    assert sorted(part) == ["table.npy", "table.npy.part"]
    for resume in (True, False):
        ask(plane, file, resume=resume)
        assert contents(tmp_path) == part


def test_nothing_is_replaced_before_the_first_row_is_whole(plane: Mesh, tmp_path: Path) -> None:
    file = tmp_path / "table.npy"
    file.write_bytes(b"of someone else")
    broken(plane, file, ROW - 1)
    assert contents(tmp_path) == {"table.npy": b"of someone else"}


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_rows_that_are_missing_are_nan(plane: Mesh, tmp_path: Path, dtype: Any) -> None:
    (tmp_path / "fresh").mkdir()
    fresh = plane.table_file(tmp_path / "fresh" / "table.npy", POINTS, dtype=dtype)
    row = fresh[0].nbytes
    file = tmp_path / "table.npy"
    broken(plane, file, 5 * row + row // 2, dtype=dtype)
    held = np.load(file)
    assert held.dtype == dtype
    np.testing.assert_array_equal(held[:5], fresh[:5])
    assert np.isnan(held[5:]).all()
    plane.table_file(file, POINTS, dtype=dtype)
    del fresh
    assert file.read_bytes() == (tmp_path / "fresh" / "table.npy").read_bytes()
    assert not (tmp_path / "table.npy.part").exists()


def test_a_broken_command_goes_on(
    plane: Mesh, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fresh = np.array(plane.table_file(tmp_path / "fresh.npy", POINTS))
    file = tmp_path / "table.npy"
    asked = ["table", plane.id, "-o", str(file)]
    asked += [word for point in POINTS for word in ("--from", str(point))]
    with monkeypatch.context() as patch:
        client, _ = cut_client(plane.client.url, [7 * ROW + 3, 0, 0, 0, 0, 0, 0])
        patch.setattr("geodesicd.command_line.connect", lambda options: client)
        assert commands.main(asked) == 1
    held = np.load(file)
    np.testing.assert_array_equal(held[:7], fresh[:7])
    assert np.isnan(held[7:]).all()
    client, cut = cut_client(plane.client.url, [])
    with monkeypatch.context() as patch:
        patch.setattr("geodesicd.command_line.connect", lambda options: client)
        assert commands.main(asked) == 0
    assert cut.rows == ["7-"]
    assert file.read_bytes() == (tmp_path / "fresh.npy").read_bytes()


def test_large_files_are_nan_to_their_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for block in (1, 5, 6, 7, 100):
        monkeypatch.setattr(growing_file, "_BLOCK", block)
        growing_file._write_nan(tmp_path / "nan.npy", (3, 2), np.dtype(np.float32))
        held = np.load(tmp_path / "nan.npy")
        assert held.shape == (3, 2)
        assert np.isnan(held).all()


def test_a_table_that_is_mapped_outlives_its_file(plane: Mesh, tmp_path: Path) -> None:
    mapped = plane.table_file(tmp_path / "table.npy", POINTS)
    kept = np.array(mapped)
    (tmp_path / "link.npy").symlink_to("table.npy")
    plane.table_file(tmp_path / "link.npy", [0, 99])
    np.testing.assert_array_equal(mapped, kept)
    assert (tmp_path / "link.npy").is_symlink()
    assert np.load(tmp_path / "table.npy").tolist() == [[0, 99], [99, 0]]


def test_a_full_disk_loses_nothing(
    plane: Mesh, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "table.npy"
    file.write_bytes(b"of someone else")

    def full(fresh: Path, *_: Any) -> None:
        fresh.write_bytes(b"begun")
        raise OSError("no space left")

    monkeypatch.setattr(growing_file, "_write_nan", full)
    with pytest.raises(OSError, match="no space left"):
        plane.table_file(file, POINTS)
    assert contents(tmp_path) == {"table.npy": b"of someone else"}


def test_where_no_file_can_be_is_said_before_it_is_computed(
    server: geodesicd.LocalServer, plane: Mesh, tmp_path: Path
) -> None:
    with pytest.raises(FileNotFoundError, match="nowhere"):
        plane.table_file(tmp_path / "nowhere" / "table.npy", [0, plane.vertices])
    (tmp_path / "folder.npy").mkdir()
    told = geodesic(
        server, "table", plane.id, "--from", "999999", "-o", tmp_path / "folder.npy", status=1
    )
    assert "Is a directory" in told.stderr
