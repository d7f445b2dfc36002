"""The command ``geodesic`` as it is installed, against a real server; and its pictures."""

from __future__ import annotations

import contextlib
import json
import os
import pty
import re
import signal
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import PROGRAM, geodesic, installed
from matplotlib.image import imread

import geodesicd
from geodesicd.bench.mixes import hills
from geodesicd.commands import _parser
from geodesicd.plot import plot
from geodesicd.raster import Camera, render


def test_upload_and_list(server: geodesicd.LocalServer, samples: Path) -> None:
    files = (samples / "plane.glb", samples / "plane.drc")
    both = installed(server, "upload", *files).stdout.split()
    listed = installed(server, "list").stdout.splitlines()
    rows = {line.split("\t")[0]: line.split("\t")[1:] for line in listed}
    assert rows[both[0]] == ["plane.glb", "10000", "19602", "glb", "355840", ""]
    assert rows[both[1]][3] == "drc"
    metadata = json.loads(geodesic(server, "list", "--json").stdout)
    assert {one["id"] for one in metadata} == set(rows)


def test_upload_in_millimetres(server: geodesicd.LocalServer, samples: Path) -> None:
    options = ("--scale", "0.001", "--up", "z", "--weld", "off", "--node", "plane")
    mesh = geodesic(server, "upload", samples / "plane.glb", *options).stdout.strip()
    assert "~" in mesh
    far = geodesic(
        server, "distance", mesh, "--from", "0", "--at", "99", "--method", "exact"
    ).stdout
    assert round(float(far), 9) == 0.099


COMMANDS = re.findall(r"(?m)^  ([a-z]+)  ", _parser().format_help())


QUESTIONS = [f"map {name}" for name in ("distance", "path", "table", "samples", "matrix")]


@pytest.mark.parametrize("command", ["", *COMMANDS, *QUESTIONS])
def test_help_fits_a_screen(server: geodesicd.LocalServer, command: str) -> None:
    told = geodesic(server, *command.split(), "--help").stdout.splitlines()
    assert len(told) < 24  # and the prompt behind it
    assert max(map(len, told)) <= 80
    assert told[0].startswith(f"usage: geodesic {command}".rstrip())
    assert not [line for line in told if line.startswith(" " * 12)]  # none is folded


@pytest.mark.parametrize("command", [*COMMANDS, *QUESTIONS])
def test_help_names_every_argument(server: geodesicd.LocalServer, command: str) -> None:
    parser: Any = _parser()
    for word in command.split():
        (commands,) = (one for one in parser._actions if isinstance(one.choices, dict))
        parser = commands.choices[word]
    told = geodesic(server, *command.split(), "--help").stdout
    for action in parser._actions:
        for name in action.option_strings:
            assert name in ("-h", "--help") or re.search(rf"(?m)^  .*{name}\b", told), name


def test_every_command_is_listed() -> None:
    known = (
        "upload list rename delete distance path table isolines trace nearest samples measure "
        "extent voronoi loop logmap plot map bench serve"
    )
    assert known.split() == COMMANDS


def test_delete(server: geodesicd.LocalServer, client: geodesicd.Client) -> None:
    one, two = (client.upload(hills(5, seed)).id for seed in (101, 102))
    told = geodesic(server, "delete", one[:16], two).stdout.split()
    assert told == [one, two]
    for gone in (one, one[:16]):
        geodesic(server, "delete", gone, status=1)
    assert not {one, two} & {mesh.id for mesh in client.meshes()}


def test_a_file_means_the_mesh_of_its_bytes(
    server: geodesicd.LocalServer,
    client: geodesicd.Client,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    file = tmp_path / "one.glb"
    file.write_bytes(client.upload((np.eye(3) * 7, [[0, 1, 2]])).geometry_glb())
    plain = client.upload(file)
    other = client.upload(file, scale=2, name="one.glb")
    assert geodesic(server, "rename", file, "plainly").stdout.strip() == plain.id
    assert client.mesh(plain.id).name == "plainly"
    assert client.mesh(other.id).name == "one.glb"
    assert geodesic(server, "delete", file).stdout.strip() == plain.id
    assert {mesh.id for mesh in client.meshes()} >= {other.id}
    assert plain.id not in {mesh.id for mesh in client.meshes()}
    # Now the server has another mesh of the file's name.
    monkeypatch.chdir(tmp_path)
    assert other.id in geodesic(server, "delete", "one.glb", status=1).stderr.replace("\n", "")
    assert geodesic(server, "delete", other.id).stdout.strip() == other.id


def test_what_takes_one_point_refuses_two(server: geodesicd.LocalServer, samples: Path) -> None:
    asked = ("logmap", samples / "plane.glb", "--from", "0", "--from", "3", "--radius", "5")
    assert "once" in geodesic(server, *asked, status=2).stderr


def test_path_and_distance_take_the_same_options(
    server: geodesicd.LocalServer, plane: geodesicd.Mesh, tmp_path: Path
) -> None:
    points = (plane.id[:20], "--from", "0", "--method")
    for command, more in (("distance", ("--at", "5050")), ("path", ("--to", "5050"))):
        told = geodesic(
            server, command, *points, "steiner", *more, "--points-per-edge", "5",
            "--deadline", "60", "--tolerance", "1e-6", status=0 if command == "path" else 1,
        )  # fmt: skip
        if command == "path":
            assert float(told.stdout) == pytest.approx(50 * 2**0.5, rel=1e-2)
        upper = geodesic(server, command, *points, "auto", *more, "--bound", "upper")
        assert float(upper.stdout) == pytest.approx(50 * 2**0.5, rel=1e-3)
    within = geodesic(server, "distance", *points, "auto", "--at", "5050", "--tolerance", "1e-3")
    assert float(within.stdout) == pytest.approx(50 * 2**0.5, rel=1e-3)
    picture = tmp_path / "f.png"
    geodesic(server, "plot", *points, "auto", "--tolerance", "0.01", "-o", picture)
    table = geodesic(
        server, "table", *points, "auto", "--tolerance", "0", "--max", "60", "--to", "9"
    )
    assert table.stdout.splitlines()[1] == "0,9"


def test_distance(server: geodesicd.LocalServer, plane: geodesicd.Mesh, tmp_path: Path) -> None:
    file = tmp_path / "field.npy"
    run = geodesic(server, "distance", plane.id, "--from", "0", "-o", file, "--max", "50")
    np.testing.assert_array_equal(np.load(file), plane.distance(0, max=50))
    assert "reached" in run.stderr
    at = geodesic(server, "distance", plane.id, "--from", "p:10,10,5", "--at", "9", "--at", "0")
    np.testing.assert_allclose(
        [float(line) for line in at.stdout.split()], plane.distance_at("p:10,10,5", [9, 0])
    )
    geodesic(server, "distance", plane.id, "--from", "0", "-o", tmp_path / "field.csv")
    rows = np.loadtxt(tmp_path / "field.csv", delimiter=",", skiprows=1)
    np.testing.assert_array_equal(rows[:, 1].astype(np.float32), plane.distance(0))


def test_path(server: geodesicd.LocalServer, samples: Path, tmp_path: Path) -> None:
    mesh = samples / "plane_three_holes.glb"
    for ending in ("csv", "npy", "json", "glb"):
        file = tmp_path / f"path.{ending}"
        run = geodesic(server, "path", mesh, "--from", "0", "--to", "9999", "-o", file)
        assert float(run.stdout) == pytest.approx(151.835, rel=1e-5)
        assert file.stat().st_size > 100
    rows = np.loadtxt(tmp_path / "path.csv", delimiter=",", skiprows=1)
    np.testing.assert_allclose(rows[:, :3], np.load(tmp_path / "path.npy"))
    document = json.loads((tmp_path / "path.json").read_text())
    assert len(document["points"]) == len(rows)
    assert (tmp_path / "path.glb").read_bytes().startswith(b"glTF")


def test_table(server: geodesicd.LocalServer, plane: geodesicd.Mesh) -> None:
    run = geodesic(server, "table", plane.id, "--from", "0", "--from", "p:99,0,0")
    lines = run.stdout.splitlines()
    assert lines[0] == ',0,"p:99,0,0"'
    assert [float(cell) for cell in lines[1].split(",")] == [0, 0, 99]


def test_tables_in_files(
    server: geodesicd.LocalServer, plane: geodesicd.Mesh, tmp_path: Path
) -> None:
    from scipy.sparse import load_npz

    asked = ["table", plane.id, "--from", "0", "--from", "9", "--to", "3", "--to", "99"]
    file = tmp_path / "table.npy"
    assert geodesic(server, *asked, "-o", file).stdout == ""
    np.testing.assert_allclose(np.load(file), [[3, 99], [6, 90]])
    geodesic(server, *asked, "--max", "5", "-o", tmp_path / "table.npz")
    matrix = load_npz(tmp_path / "table.npz")
    assert matrix.shape == (2, 2)
    assert matrix.nnz == 1
    assert matrix[0, 0] == pytest.approx(3)
    assert ".npy or .npz" in geodesic(server, *asked, "-o", tmp_path / "t.csv", status=2).stderr


def test_points_of_a_table_in_files(
    server: geodesicd.LocalServer, plane: geodesicd.Mesh, tmp_path: Path
) -> None:
    rows, columns = tmp_path / "rows.txt", tmp_path / "columns.txt"
    rows.write_text("0 9\np:5,0,0\n")
    columns.write_text("\n3\n99\n")
    asked: list[str | Path] = ["table", plane.id, "--from-file", rows]
    told = geodesic(server, *asked, "--from", "1", "--to", "5", "--to-file", columns).stdout
    lines = [line.rsplit(",", 3) for line in told.splitlines()]
    assert lines[0] == ["", "5", "3", "99"]
    assert [line[0] for line in lines[1:]] == ["1", "0", "9", '"p:5,0,0"']
    distances = [[float(number) for number in line[1:]] for line in lines[1:]]
    np.testing.assert_allclose(distances, [[4, 2, 98], [5, 3, 99], [4, 6, 90], [0, 2, 94]])
    square = geodesic(server, *asked).stdout.splitlines()
    assert len(square) == 4
    assert square[0].startswith(',0,9,"p:5,0,0"')
    rows.write_text("\n")
    assert "rows.txt has no points" in geodesic(server, *asked, status=1).stderr
    assert "give --from POINT" in geodesic(server, "table", plane.id, status=2).stderr
    gone = geodesic(server, "table", plane.id, "--from-file", tmp_path / "none", status=1)
    assert "No such file" in gone.stderr


def test_what_is_wrong_is_said(
    server: geodesicd.LocalServer, plane: geodesicd.Mesh, tmp_path: Path
) -> None:
    refused = geodesic(server, "path", plane.id, "--from", "0", "--to", "77777", status=1)
    assert "index_out_of_range" in refused.stderr
    assert "limit 9999" in refused.stderr
    geodesic(server, "path", "nowhere.glb", "--from", "0", "--to", "1", status=1)
    geodesic(server, "distance", "0" * 64, "--from", "0", status=1)
    geodesic(server, "path", plane.id, "--from", "0", status=2)
    (tmp_path / "broken.glb").write_bytes(b"glTF nonsense")
    assert "mesh_invalid" in geodesic(server, "upload", tmp_path / "broken.glb", status=1).stderr


def test_a_field_is_drawn(
    server: geodesicd.LocalServer, holes: geodesicd.Mesh, tmp_path: Path
) -> None:
    file = tmp_path / "field.png"
    geodesic(server, "plot", holes.id, "--from", "0", "--to", "9999", "-o", file)
    picture = imread(file)
    assert picture.shape == (1125, 1500, 4)
    # The plane with its holes: colours of the field, white holes, and the path's red.
    red = (picture[..., 0] > 0.75) & (picture[..., 1] < 0.25) & (picture[..., 2] < 0.5)
    assert 500 < red.sum() < 20000
    white = (picture[..., :3] > 0.99).all(axis=2)
    assert 0.4 < white.mean() < 0.8


def test_a_picture_that_cannot_be_drawn_says_why(
    server: geodesicd.LocalServer, plane: geodesicd.Mesh, tmp_path: Path
) -> None:
    asked = ("plot", plane.id, "--from", "0", "-o", tmp_path / "field.png")
    for view in ("below", "30", "30,", "30,20,10", "up,20", "nan,20", "0,inf"):
        assert "--view is" in geodesic(server, *asked, "--view", view, status=2).stderr
    # Nothing is asked of the server before: it has no such target.
    sunset = ("--to", "99999", "--colormap", "sunset")
    assert "no colormap" in geodesic(server, *asked, *sunset, status=1).stderr
    # A field that no other test asks for: a reply that the server keeps is in time.
    slow = ("--method", "chen_han", "--deadline", "0")
    late = geodesic(server, "plot", plane.id, "--from", "6173", *asked[4:], *slow, status=1).stderr
    assert "deadline" in late
    assert not list(tmp_path.iterdir())
    geodesic(server, *asked, "--view", "30,20", "--colormap", "magma", "--deadline", "60")
    assert imread(tmp_path / "field.png").shape == (1125, 1500, 4)


def test_points_on_the_way_are_for_a_path(
    server: geodesicd.LocalServer, plane: geodesicd.Mesh, tmp_path: Path
) -> None:
    asked = ("plot", plane.id, "--from", "0", "--via", "5", "-o", tmp_path / "field.png")
    assert "--via is for --to" in geodesic(server, *asked, status=2).stderr
    assert not list(tmp_path.iterdir())
    of_path: list[dict[str, Any]] = [{"via": [5]}, {"refine": "none"}]
    for options in of_path:
        with pytest.raises(ValueError, match="give a target"):
            plot(plane, 0, **options)


def test_a_signed_field_is_drawn(
    server: geodesicd.LocalServer, plane: geodesicd.Mesh, tmp_path: Path
) -> None:
    curve = geodesicd.Curve([2020, 2080, 8080, 8020], closed=True)
    figure = plot(plane, curve, signed=True, method="exact", isolines=3, size=(4, 4), dpi=80)
    assert figure.axes[1].get_ylabel() == "signed distance (mesh units)"
    least, most = figure.axes[1].get_ylim()
    assert least == -most == pytest.approx(-30)  # to the middle of the square
    shown = figure.axes[0].images[0].get_array()
    assert shown is not None
    colours = np.asarray(shown)
    middle = colours[colours.shape[0] // 2, colours.shape[1] // 2]
    seen = colours[colours[..., 3] > 0]
    assert middle[2] > middle[0] + 0.2  # blue inside
    assert (seen[:, 0] > seen[:, 2] + 0.2).mean() > 0.2  # red outside
    unsigned, signed = tmp_path / "unsigned.png", tmp_path / "signed.png"
    asked = ("plot", plane.id, "--from", "curve:closed;2020;2080;8080;8020")
    geodesic(server, *asked, "-o", unsigned)
    geodesic(server, *asked, "--signed", "-o", signed)
    assert unsigned.read_bytes() != signed.read_bytes()
    told = geodesic(server, "plot", plane.id, "--from", "0", "--signed", "-o", signed, status=1)
    assert "signed" in told.stderr


def test_lines_among_sources_are_drawn(plane: geodesicd.Mesh) -> None:
    small: dict[str, Any] = {"size": (3, 3), "dpi": 50, "isolines": 0}
    points = plot(plane, [0, 99], **small)
    lines = plot(plane, [geodesicd.Curve([0, 99]), 5050], target=9900, **small)
    assert len(points.axes[0].collections) == 0
    assert len(lines.axes[0].collections) >= 2
    assert lines.axes[0].get_title().endswith("· path 99")
    assert plot(plane, geodesicd.Boundary(), **small).axes


def test_what_is_behind_is_hidden(client: geodesicd.Client, samples: Path) -> None:
    knot = client.upload(samples / "torus_knot.glb")
    geometry = knot.geometry()
    camera = Camera.looking(geometry.positions, 35, 25, "y", 400, 300)
    seen = render(camera, geometry)
    shown = seen.shows(camera, geometry.positions)
    # From outside, about half of a closed surface faces away, and some of the rest is covered;
    # what is on the rim counts as seen.
    assert 0.3 < shown.mean() < 0.6
    _, depth = camera.project(geometry.positions)
    assert shown[depth.argmax()]
    assert not shown[depth.argmin()]
    field = knot.distance(0)
    values = seen.interpolate(geometry.triangles, field)
    assert np.nanmin(values) >= 0
    assert np.nanmax(values) <= field.max()
    assert np.isnan(values[0, 0])


def test_a_mesh_with_an_unreached_part_is_drawn(client: geodesicd.Client) -> None:
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [5, 0, 0], [6, 0, 0], [5, 1, 0]])
    mesh = client.upload((vertices, np.array([[0, 1, 2], [3, 4, 5]])))
    figure = plot(mesh, 0, target=4, size=(4, 3), dpi=80)
    figure.canvas.draw()
    assert "out of reach" in figure.axes[0].get_title()
    colours = figure.axes[0].images[0].get_array()
    assert colours is not None
    seen = np.asarray(colours)[np.asarray(colours)[..., 3] > 0][:, :3]
    grey = np.ptp(seen, axis=1) < 1e-9
    assert grey.mean() == pytest.approx(0.5, abs=0.05)


def test_a_title_names_the_method_of_the_reply(plane: geodesicd.Mesh) -> None:
    default = plane.path(0, 5).method
    small: dict[str, Any] = {"size": (2, 2), "dpi": 40, "isolines": 2}
    assert plot(plane, 0, **small).axes[0].get_title().endswith(f" · {default}")
    figure = plot(plane, 0, target=99, method="dijkstra", **small)
    assert figure.axes[0].get_title().endswith(" · dijkstra · path 99")
    assert plot(plane, 0, method="auto", tolerance=0.1, **small).axes


def test_on_a_terminal_progress_is_shown(
    server: geodesicd.LocalServer, samples: Path, tmp_path: Path
) -> None:
    environment = {**os.environ, "GEODESICD_URL": server.url, "TERM": "xterm-256color"}
    for arguments, shown in (
        (["distance", str(samples / "saddle.glb"), "--from", "0", "--method", "exact",
          "-o", str(tmp_path / "f.npy")], ("uploading saddle.glb", "distances", "100%")),
        (["list"], ("saddle", "14,400")),
        (["bench", "--seconds", "2", "--vertices", "400"], ("geodesic bench", "replies", "p99")),
    ):  # fmt: skip
        ours, theirs = pty.openpty()
        with subprocess.Popen(
            [PROGRAM, *arguments], stdout=theirs, stderr=theirs, stdin=theirs, env=environment
        ) as process:
            os.close(theirs)
            written = b""
            with contextlib.suppress(OSError):  # Linux's way of telling the end
                while data := os.read(ours, 4096):
                    written += data
            os.close(ours)
        text = written.decode()
        assert process.returncode == 0, text
        assert all(word in text for word in shown), text


def test_serve_runs_until_it_is_stopped(samples: Path) -> None:
    command = [PROGRAM, "serve", "--listen", "127.0.0.1:0"]
    process = subprocess.Popen(
        [*command, str(samples / "plane.glb")],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    listening = re.fullmatch(r"listening on (\S+)\n", process.stdout.readline())
    assert listening
    with geodesicd.Client(listening[1]) as client:
        assert client.meshes()[0].vertices == 10000
        process.send_signal(signal.SIGTERM)
        _, told = process.communicate(timeout=60)
        assert process.returncode == 130
        assert "Traceback" not in told
    with (
        geodesicd.Client(listening[1], retries=geodesicd.Retries(attempts=1)) as client,
        pytest.raises(geodesicd.ConnectionFailed),
    ):
        client.status()


def test_a_server_that_does_not_start_says_why(tmp_path: Path) -> None:
    (tmp_path / "store").write_text("a file where a folder should be")
    with pytest.raises(RuntimeError, match="did not start"):
        geodesicd.serve(store=tmp_path / "store").start()
    with pytest.raises(FileNotFoundError):
        geodesicd.serve("/nowhere/geodesicd")
