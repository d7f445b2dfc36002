"""A server of one's own: two lines to a result, and where the server's program comes from."""

from __future__ import annotations

import importlib
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import geodesicd
from geodesicd import local_server
from geodesicd.bench.mixes import hills
from geodesicd.local_server import find_server

WHEEL = Path(__file__).parents[3] / "deploy" / "wheel"  # of the server


def test_two_lines_to_a_result(tmp_path: Path) -> None:
    code = (
        "import geodesicd\n"
        "mesh = geodesicd.local([[0, 0, 0], [3, 0, 0], [0, 4, 0]], [[0, 1, 2]])\n"
        "print(mesh.distance(1).tolist(), mesh.client.url)\n"
    )
    environment = {k: v for k, v in os.environ.items() if not k.startswith("GEODESICD")}
    environment["GEODESICD_BINARY"] = os.environ["GEODESICD"]
    run = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True, text=True, env=environment, check=False, timeout=60,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
    field, _, url = run.stdout.rpartition(" ")
    assert field == "[3.0, 0.0, 5.0]"
    with (  # it has ended with the process
        geodesicd.Client(url.strip(), retries=geodesicd.Retries(attempts=1)) as client,
        pytest.raises(geodesicd.ConnectionFailed),
    ):
        client.status()


def test_one_server_for_all_and_another_after_it_died(
    samples: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = geodesicd.local(*hills(10, 1))
    second = geodesicd.local(samples / "plane.glb", scale=2)
    assert first.client is second.client
    assert second.bbox[1, 0] == 198
    vertices, faces = hills(10, 1)
    with pytest.warns(geodesicd.PrecisionWarning) as caught:
        geodesicd.local((vertices + 1e7 + 0.1).astype(np.float32), faces)
    assert caught[0].filename == __file__
    monkeypatch.delenv("GEODESICD_URL", raising=False)
    with geodesicd.connect() as client:
        assert client.url == first.client.url
        monkeypatch.setenv("GEODESICD_URL", "127.0.0.1:9")
        with geodesicd.connect() as other:
            assert other.url == "http://127.0.0.1:9"
    pid = os.fork()
    if pid == 0:  # a fork leaves the server alone
        for server, _ in local_server._shared.values():
            server.stop()
        os._exit(0)
    assert os.waitpid(pid, 0)[1] == 0
    assert first.refresh().vertices == 100
    for server, client in local_server._shared.values():
        client.close()
        server.stop()
    assert geodesicd.local(*hills(10, 1)).client is not first.client
    for server, client in local_server._shared.values():
        client.close()
        server.stop()


def forget_the_servers_package(monkeypatch: pytest.MonkeyPatch) -> None:
    """Has Python look for it again."""
    monkeypatch.delitem(sys.modules, "geodesicd_server", raising=False)
    importlib.invalidate_caches()


def test_where_the_program_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    programs = {}
    package = tmp_path / "site" / "geodesicd_server"
    shutil.copytree(WHEEL / "src" / "geodesicd_server", package)
    places = {name: tmp_path / name for name in ("argument", "binary", "variable", "path")}
    for name, folder in {**places, "package": package / "bin"}.items():
        folder.mkdir()
        programs[name] = folder / "geodesicd"
        programs[name].write_text("#!/bin/sh\n")
        programs[name].chmod(0o755)
    monkeypatch.syspath_prepend(tmp_path / "site")
    forget_the_servers_package(monkeypatch)
    monkeypatch.setenv("GEODESICD_BINARY", str(programs["binary"]))
    monkeypatch.setenv("GEODESICD", str(programs["variable"]))
    monkeypatch.setenv("PATH", str(tmp_path / "path"))
    assert find_server(programs["argument"]) == programs["argument"]
    assert find_server() == programs["binary"]
    monkeypatch.delenv("GEODESICD_BINARY")
    assert find_server() == programs["variable"]
    monkeypatch.delenv("GEODESICD")
    assert find_server() == programs["package"]
    shutil.rmtree(package)
    forget_the_servers_package(monkeypatch)
    assert find_server() == programs["path"]
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(FileNotFoundError, match=r"\[server\].*PATH.*_BINARY.*Client\(url\)"):
        geodesicd.local(np.eye(3), [[0, 1, 2]])
    monkeypatch.setenv("GEODESICD_BINARY", "/nowhere/geodesicd")
    with pytest.raises(FileNotFoundError, match=r"\$GEODESICD_BINARY names no program: /nowhere"):
        find_server()


def test_serve_with_the_servers_wheel(tmp_path: Path, samples: Path) -> None:
    source = tmp_path / "source"
    shutil.copytree(WHEEL, source, ignore=shutil.ignore_patterns("__pycache__"))
    package = source / "src" / "geodesicd_server"
    (package / "bin").mkdir()
    shutil.copy(os.environ["GEODESICD"], package / "bin" / "geodesicd")
    share = package / "share" / "geodesicd"
    (share / "viewer").mkdir(parents=True)
    (share / "viewer" / "index.html").write_text("<title>a viewer</title>")
    (share / "samples").mkdir()
    shutil.copy(samples / "plane.glb", share / "samples")
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "-q"]
    alone = ["--no-deps", "--no-build-isolation"]
    built = [*pip, "wheel", *alone, "-w", str(tmp_path), str(source)]
    subprocess.run(built, check=True, timeout=120)
    (wheel,) = tmp_path.glob("*.whl")
    assert "none-any" not in wheel.name
    installed = [*pip, "install", *alone, "--target", str(tmp_path / "site"), str(wheel)]
    subprocess.run(installed, check=True, timeout=120)

    environment = {k: v for k, v in os.environ.items() if not k.startswith("GEODESICD")}
    environment["PYTHONPATH"] = str(tmp_path / "site")
    command = [sys.executable, "-m", "geodesicd.commands", "serve", "--listen", "127.0.0.1:0"]
    with subprocess.Popen(
        [*command, "--samples", "--", "--max-vertices", "10000"],
        stdout=subprocess.PIPE, text=True, env=environment,
    ) as process:  # fmt: skip
        assert process.stdout is not None
        listening = re.fullmatch(r"listening on (\S+)\n", process.stdout.readline())
        assert listening
        with geodesicd.Client(listening[1]) as client:
            assert client.mesh("plane.glb").vertices == 10000
            assert b"a viewer" in client.fetch("GET", "/").body
            assert client.status()["limits"]["max_vertices"] == 10000
        process.terminate()
