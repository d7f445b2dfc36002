"""What is written down runs: the README's snippets, the examples and the notebook."""

from __future__ import annotations

import ast
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import nbformat
import numpy as np
import pytest
from nbclient import NotebookClient
from test_bench import stopping_locust

import geodesicd
from geodesicd import local_server

HERE = Path(__file__).parents[1]
ROOT = HERE.parents[1]


def run_example(name: str, *arguments: str, **environment: str) -> dict[str, str]:
    """Runs an example; what it prints, by the first word of each line."""
    run = subprocess.run(
        [sys.executable, str(HERE / "examples" / f"{name}.py"), *arguments],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        env={**os.environ, **environment},
    )
    assert run.returncode == 0, run.stderr
    return dict(line.split(" ", 1) for line in run.stdout.splitlines())


def test_tape() -> None:
    told = run_example("tape")
    # A polygon inside a great circle, on faces that bulge towards the sphere.
    assert 2 * np.pi * 0.998 < float(told["girth"].split()[0]) < 2 * np.pi
    assert float(told["chords"]) == pytest.approx(4 * 2**0.5, rel=1e-3)
    assert told["closed"] == "True"


def test_terrain_route(tmp_path: Path) -> None:
    told = run_example("terrain_route", str(tmp_path / "profile.csv"))
    route, over = (float(told[name].split()[0]) for name in ("route", "straight"))
    assert 110 < route < 0.85 * over
    profile = np.loadtxt(tmp_path / "profile.csv", delimiter=",", skiprows=1)
    assert profile[-1, 0] == pytest.approx(route, rel=1e-4)


def test_remesh_seeds() -> None:
    told = run_example("remesh_seeds", "80")
    covering = float(told["seeds"].split()[-1])
    assert float(told["farthest"].split()[-1]) == pytest.approx(covering, abs=1e-3)
    assert float(told["least"].split()[-1]) >= covering * 0.99
    assert told["triangles"] == "156 Euler 2"  # a sphere again: 2 * 80 - 4 triangles


@pytest.mark.parametrize("name", ["tape", "terrain_route", "remesh_seeds", "voronoi_colouring"])
def test_an_example_asks_the_server_that_is_named(
    server: geodesicd.LocalServer, tmp_path: Path, name: str
) -> None:
    arguments = [str(tmp_path / "out.png")] if name == "voronoi_colouring" else []
    nowhere = {"GEODESICD": "/nowhere", "GEODESICD_BINARY": "/nowhere"}
    assert run_example(name, *arguments, **nowhere, GEODESICD_URL=server.url)


def test_voronoi_colouring(tmp_path: Path) -> None:
    told = run_example("voronoi_colouring", str(tmp_path / "regions.png"), "12")
    assert told["regions"].endswith("of 10242")
    assert (tmp_path / "regions.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("named", [False, True])
def test_the_notebook_runs_and_has_no_outputs(
    server: geodesicd.LocalServer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, named: bool
) -> None:
    if named:
        monkeypatch.setenv("GEODESICD_URL", server.url)
        monkeypatch.setenv("GEODESICD", "/nowhere")
    notebook = nbformat.read(HERE / "tour.ipynb", as_version=4)
    nbformat.validate(notebook)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert all(not cell.outputs and cell.execution_count is None for cell in code)
    NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()
    for cell in code:
        pictures = [one for one in cell.outputs if "image/png" in one.get("data", {})]
        shown = re.findall(r"\bdisplay\(|plt\.show\(", cell.source)
        assert len(pictures) == len(shown), cell.source
    last = "".join(output.get("text", "") for output in code[-1].outputs)
    assert "stopped" in last


def snippets() -> list[tuple[str, str]]:
    text = (HERE / "README.md").read_text(encoding="utf-8")
    return re.findall(r"```(python|sh)\n(.*?)```", text, re.DOTALL)


def run_python(code: str, names: dict[str, object]) -> int:
    """Runs a snippet. A line with ``# = value`` at its end has that value; how many there were."""
    checked = 0
    lines = code.splitlines()
    for statement in ast.parse(code).body:
        source = "\n".join(lines[statement.lineno - 1 : statement.end_lineno])
        comment = re.search(r"  # = (.+)$", source)
        if isinstance(statement, ast.Expr) and comment:
            value = eval(source, names)
            assert repr(value) == comment[1], source
            checked += 1
        else:
            exec(source, names)
    return checked


def test_the_projects_readme(
    server: geodesicd.LocalServer, samples: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The snippet of the README at the top, but for the server's address."""
    (tmp_path / "build").mkdir()
    (tmp_path / "build" / "samples").symlink_to(samples)
    monkeypatch.chdir(tmp_path)
    text = (HERE.parents[1] / "README.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    names: dict[str, object] = {}
    assert run_python(code.replace("http://localhost:8080", server.url), names) == 3
    asked = names["mesh"]
    assert isinstance(asked, geodesicd.Mesh)
    asked.client.close()


def test_the_readmes_python(samples: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """All in one name space, in turn."""
    monkeypatch.chdir(tmp_path)
    for name in ("plane_three_holes.glb", "torus_knot.glb"):
        (tmp_path / name).write_bytes((samples / name).read_bytes())
    names: dict[str, object] = {}
    checked = 0
    server = geodesicd.serve()
    monkeypatch.setenv("GEODESICD_URL", server.start())
    try:
        for kind, code in snippets():
            if kind != "python":
                continue
            checked += run_python(code, names)
    finally:
        connected = names.get("client")
        if isinstance(connected, geodesicd.Client):
            connected.close()
        for own, client in local_server._shared.values():
            client.close()
            own.stop()
        server.stop()
    assert checked >= 12


def test_the_readmes_pictures(holes: geodesicd.Mesh) -> None:
    """Each is there, its page has it, and the call beside it is answered."""
    text = (HERE / "README.md").read_text(encoding="utf-8")
    rows = re.findall(r'(?m)^\| \[<img src="(.+?)".*?>\]\((.+?)\) \|.*\| `(.+)` \|$', text)
    names = {"mesh": holes, **{name: getattr(geodesicd, name) for name in geodesicd.__all__}}
    for picture, page, call in rows:
        assert (HERE / picture).read_bytes().startswith(b"\x89PNG")
        path, _, heading = page.partition("#")
        told = (HERE / path).read_text(encoding="utf-8")
        assert f"]({Path(picture).name})" in told
        headings = [one.lower().replace(" ", "-") for one in re.findall(r"(?m)^#+ (.+)$", told)]
        assert not heading or heading in headings
        assert eval(call, names) is not None
    commands = re.search(r"(?s)\[pictures\]\(#pictures\).*?```sh\n(.*?)```", text)
    assert commands
    assert len(rows) == len(re.findall(r"(?m)^\$ geodesic ", commands[1])) >= 14


def test_an_analyst_works_within_ten_lines() -> None:
    text = (HERE / "README.md").read_text(encoding="utf-8")
    first = text[: text.index("```\n", text.index("```python"))]
    (code,) = re.findall(r"```python\n(.*)", first, re.DOTALL)
    assert len(code.splitlines()) <= 10
    assert len(first.splitlines()) < 24


def ended(command: str, url: str, folder: Path) -> str:
    """A command of the README's as one that ends, and changes nothing that is installed."""
    if command.startswith("pip install "):
        alone = "--dry-run --quiet --no-deps --no-build-isolation --disable-pip-version-check"
        return f"{command.partition('#')[0]} {alone}"
    if command.startswith("locust "):
        here = command.replace("http://localhost:8080", url)
        return f"{here.replace('.py', f'.py,{stopping_locust(folder)}')} --headless"
    return command


def serves(command: str, folder: Path, environment: dict[str, str]) -> None:
    """A command that runs until it is stopped."""
    with subprocess.Popen(
        command, shell=True, cwd=folder, env=environment, stdout=subprocess.PIPE,
        stderr=subprocess.PIPE, text=True,
    ) as process:  # fmt: skip
        assert process.stdout is not None
        listening = re.fullmatch(r"listening on (\S+)\n", process.stdout.readline())
        assert listening
        with geodesicd.Client(listening[1]) as client:
            assert [mesh.name for mesh in client.meshes()] == ["plane_three_holes.glb"]
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)
    assert process.returncode == 130


def test_the_readmes_commands(server: geodesicd.LocalServer, samples: Path, tmp_path: Path) -> None:
    (tmp_path / "plane_three_holes.glb").write_bytes(
        (samples / "plane_three_holes.glb").read_bytes()
    )
    binaries = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = {**os.environ, "GEODESICD_URL": server.url, "PATH": binaries}
    checked = 0
    kinds: set[str] = set()
    for kind, code in snippets():
        if kind != "sh":
            continue
        for command, told in re.findall(r"^\$ (.+)\n((?:(?!\$ ).*\n)*)", code, re.MULTILINE):
            if command.startswith("geodesic serve"):
                serves(f"exec {command} --listen 127.0.0.1:0", tmp_path, environment)
                checked += 1
                continue
            at_root = command.startswith(("pip ", "locust "))
            run = subprocess.run(
                ended(command, server.url, tmp_path), shell=True, cwd=ROOT if at_root else tmp_path,
                env=environment, capture_output=True, text=True, timeout=120, check=False,
            )  # fmt: skip
            assert run.returncode == 0, run.stderr
            if told:
                # Another compiler may round the last digit otherwise.
                numbers = [float(word) for word in told.split()]
                printed = [float(word) for word in run.stdout.split()]
                assert printed == pytest.approx(numbers, rel=1e-12), command
                checked += 1
            kinds.add(command.split()[0])
    assert checked >= 4
    assert kinds == {"python3", "pip", "geodesic", "locust"}
