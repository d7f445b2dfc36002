"""Work in bulk by real processes, of which some are killed: nothing is missing, nothing is wrong,
and nothing is computed twice but what was lost."""

from __future__ import annotations

import json
import os
import random
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.dataset as dataset
import pytest
import zarr
from distributed import Client as DaskClient
from distributed import LocalCluster

import geodesicd
from geodesicd import Costs, bulk
from geodesicd.bench.mixes import hills
from geodesicd.bulk import questions
from geodesicd.bulk.output import output_at

MESHES = int(os.environ.get("GEODESICD_BULK_MESHES") or 60)  # `make test-bulk` has 200


@pytest.fixture(scope="module")
def chance() -> random.Random:
    seed = int(os.environ.get("GEODESICD_SEED") or random.SystemRandom().getrandbits(31))
    print(f"GEODESICD_SEED={seed}")
    return random.Random(seed)


@pytest.fixture(scope="module")
def dask() -> Iterator[Any]:
    """Two workers with one thread each."""
    with (
        LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address="127.0.0.1:0", silence_logs=50
        ) as cluster,
        DaskClient(cluster) as client,
    ):
        yield client


class Logged:
    """A program that is the server, and keeps what it logs: a file a process."""

    def __init__(self, folder: Path) -> None:
        self.logs = folder / "logs"
        self.logs.mkdir()
        self.program = folder / "logged_server"
        server = os.environ["GEODESICD"]
        kept = f'>(exec tee "{self.logs}/$$")'
        self.program.write_text(f'#!/bin/bash\nexec "{server}" "$@" > {kept}\n')
        self.program.chmod(0o755)
        self.options: dict[str, Any] = {
            "binary": self.program, "flags": ["--log-level", "info"]
        }  # fmt: skip

    def pids(self) -> list[int]:
        """Of all servers that have been started."""
        return [int(log.name) for log in self.logs.iterdir()]

    def computed(self, query: str = "distance") -> int:
        """How many questions all of them have answered."""
        asked = f"/v1/meshes/{{id}}/{query} 200 "
        return sum(log.read_text().count(asked) for log in self.logs.iterdir())


@pytest.fixture
def logged(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Logged:
    monkeypatch.delenv("GEODESICD_URL", raising=False)
    return Logged(tmp_path)


def made(folder: Path, count: int, chance: random.Random) -> list[str]:
    """Files of so many small meshes that differ."""
    folder.mkdir()
    for number in range(count):
        mesh = hills(chance.randint(4, 12), chance.getrandbits(30))
        (folder / f"{number}.ply").write_bytes(geodesicd.ply_bytes(*mesh))
    return sorted(map(str, folder.iterdir()))


def until(condition: Callable[[], bool]) -> None:
    """Waits, though not for ever."""
    end = time.monotonic() + 60
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.005)


def runs(pid: int) -> bool:
    """Whether there is a process that has not ended."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def killed(
    pids: Callable[[], list[int]], out: Path, answers: int, chance: random.Random
) -> threading.Thread:
    """Kills processes at some moment after so many answers have been written."""
    pause = chance.uniform(0, 0.05)

    def kill() -> None:
        until(lambda: len(list(out.glob("?" * 64 + "*"))) >= answers)
        time.sleep(pause)
        for pid in pids():
            os.kill(pid, signal.SIGKILL)

    thread = threading.Thread(target=kill)
    thread.start()
    return thread


def answered(out: Path, file: str) -> Any:
    """The answer about a file."""
    root = zarr.open_group(out, mode="r")
    return root[root.attrs["geodesicd"]["meshes"][file]]


def nobodys(folder: Path) -> Path:
    """A folder with what no run has written."""
    (folder / "other.parquet").mkdir()
    (folder / "other.parquet" / "mine.txt").write_text("mine")
    return folder / "other.parquet"


def test_a_worker_is_killed_and_nothing_is_missing(
    dask: Any, client: geodesicd.Client, logged: Logged, tmp_path: Path, chance: random.Random
) -> None:
    files = made(tmp_path / "meshes", MESHES, chance)
    twin, broken = str(tmp_path / "twin.ply"), str(tmp_path / "broken.glb")
    Path(twin).write_bytes(Path(files[0]).read_bytes())
    Path(broken).write_bytes(b"glTF nonsense")
    chance.shuffle(given := [*files, twin, broken, str(tmp_path / "nowhere.obj")])
    out = tmp_path / "out.zarr"
    workers = list(dask.run(os.getpid).values())
    victim = chance.choice(workers)
    killer = killed(lambda: [victim], out, chance.randint(1, MESHES * 3 // 4), chance)
    told: list[float] = []
    report = bulk.map_meshes(
        "distance", given, out, client=dask, sources=0, progress=told.append, **logged.options
    )
    killer.join()
    assert report.failures.keys() == {broken, str(tmp_path / "nowhere.obj")}
    assert "mesh_invalid" in report.failures[broken]
    # What the killed worker had written and not told is there when it is asked for again.
    assert report.computed + report.there == MESHES
    assert report.there <= 4
    # Of what it was computing when it was killed, the reply may have been logged.
    assert MESHES <= logged.computed() <= MESHES + 1
    dask.wait_for_workers(2, timeout=60)
    until(lambda: not any(map(runs, logged.pids())))
    assert told == sorted(told)
    assert told[-1] == pytest.approx(1)
    for file in [*files, twin]:
        alone = client.upload(file).distance(0)
        np.testing.assert_array_equal(answered(out, file)["distance"][:], alone)
    assert zarr.open_group(out, mode="r").attrs["geodesicd"]["failures"] == report.failures
    assert not (out / ".parts").exists()

    before = logged.computed()
    Path(broken).write_bytes(geodesicd.ply_bytes(*hills(5, chance.getrandbits(30))))
    report = bulk.map_meshes("distance", given, out, client=dask, sources=0, **logged.options)
    assert (report.computed, report.there) == (1, MESHES)
    assert logged.computed() == before + 1
    assert report.failures.keys() == {str(tmp_path / "nowhere.obj")}
    with pytest.raises(ValueError, match=r"another question.*Write to another folder"):
        bulk.map_meshes("distance", given, out, client=dask, sources=1)
    with pytest.raises(ValueError, match="something else"):
        bulk.map_meshes("distance", given, nobodys(tmp_path), client=dask, sources=1)


def test_servers_are_killed_and_their_workers_start_others(
    dask: Any, logged: Logged, tmp_path: Path, chance: random.Random
) -> None:
    files = made(tmp_path / "meshes", 20, chance)
    out = tmp_path / "out.parquet"
    killer = killed(logged.pids, out, chance.randint(1, 8), chance)
    report = bulk.map_meshes(
        "table", files, out, client=dask, sources=[0, 5], targets=[3, 1, 2], **logged.options
    )
    killer.join()
    assert report == bulk.Report(computed=20)
    assert len(logged.pids()) > 2
    table = dataset.dataset(out).to_table()
    assert table.num_rows == 20 * 6
    assert set(table["file"].to_pylist()) == set(files)
    assert table.column_names == ["file", "mesh", "source", "target", "distance"]

    asked: dict[str, Any] = {"client": dask, "sources": [0, 5], "targets": [3, 1, 2]}
    manifest = out / "_manifest.json"
    with (
        output_at(out).opened(json.loads(manifest.read_text())["question"]),
        pytest.raises(ValueError, match="another run"),
    ):
        bulk.map_meshes("table", files, out, **asked)
    manifest.write_text(re.sub(r'("engine": ")\w+', r"\1other", manifest.read_text()))
    with pytest.raises(ValueError, match="another build of the server, other"):
        bulk.map_meshes("table", files, out, **asked, **logged.options)


def test_a_run_is_killed_and_another_goes_on(
    dask: Any, client: geodesicd.Client, logged: Logged, tmp_path: Path, chance: random.Random
) -> None:
    files = made(tmp_path / "meshes", 40, chance)
    out = tmp_path / "out.zarr"
    program = str(Path(sys.executable).parent / "geodesic")
    geodesic = [program, "map", "path", *files, "-o", str(out), "--from", "0", "--to", "15"]
    geodesic += ["--method", "exact"]
    environment = {**os.environ, "GEODESICD_BINARY": str(logged.program)}
    with subprocess.Popen([*geodesic, "--workers", "1"], env=environment) as first:
        killed(lambda: [first.pid], out, chance.randint(1, 20), chance).join()
    assert first.returncode == -signal.SIGKILL
    until(lambda: not any(map(runs, logged.pids())))
    there = len(list(out.glob("?" * 64)))
    assert 0 < there < 40
    second = subprocess.run(
        [*geodesic, "--scheduler", dask.scheduler.address],
        env=environment, capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert second.returncode == 0, second.stderr
    assert f"{40 - there} computed, {there} there already" in second.stderr
    for file in chance.sample(files, 10):
        alone = client.upload(file).path(0, 15, method="exact")
        np.testing.assert_array_equal(answered(out, file)["xyz"][:], alone.points)


@pytest.mark.parametrize("targets", [None, "vertices", [3, (1.0, 2.0, 0.5)]])
def test_a_matrix_is_that_of_one_request(
    dask: Any, client: geodesicd.Client, logged: Logged, tmp_path: Path, chance: random.Random,
    targets: Any,
) -> None:  # fmt: skip
    file = tmp_path / "mesh.ply"
    file.write_bytes(geodesicd.ply_bytes(*hills(14, chance.getrandbits(30))))
    sources: list[Any] = [chance.randrange(196) for _ in range(chance.randint(33, 64))]
    if targets:
        sources[5] = (4.5, 6.5, 90.0)
    mesh = client.upload(file)
    columns = list(range(196)) if targets == "vertices" else targets
    with pytest.warns(geodesicd.GeodesicWarning) if targets else nullcontext():
        whole = mesh.table(sources, columns, method="exact")
    asked: dict[str, Any] = {"targets": targets, "method": "exact", "client": dask}
    out = tmp_path / "out.zarr"
    report = bulk.distance_matrix(file, sources, out, **asked, **logged.options)
    assert not report.failures
    assert bool(report.remarks) == bool(targets)
    matrix = zarr.open_group(out, mode="r")["distance"]
    np.testing.assert_allclose(matrix[:], whole, rtol=1e-9, atol=1e-9)
    lost = chance.choice(list((out / "distance" / "c").glob("*/0")))
    lost.unlink()
    assert np.isnan(matrix[:]).any()
    again = bulk.distance_matrix(file, sources, out, **asked, **logged.options)
    assert (again.computed, again.there) == (1, report.computed - 1)
    np.testing.assert_allclose(matrix[:], whole, rtol=1e-9, atol=1e-9)

    out = tmp_path / "out.parquet"
    bulk.distance_matrix(file, sources, out, **asked, **logged.options)
    order = [("source", "ascending"), ("target", "ascending")]
    rows = dataset.dataset(out).to_table().sort_by(order)
    np.testing.assert_allclose(rows["distance"].to_numpy(), whole.ravel(), rtol=1e-9, atol=1e-9)
    with pytest.raises(ValueError, match="another question"):
        bulk.distance_matrix(file, sources[1:], out, **asked)


def test_a_server_that_runs_is_asked(
    dask: Any, server: geodesicd.LocalServer, client: geodesicd.Client, tmp_path: Path,
    chance: random.Random,
) -> None:  # fmt: skip
    files = made(tmp_path / "meshes", 6, chance)
    out = tmp_path / "out.zarr"
    asked: dict[str, Any] = {"count": 5, "reading": {"scale": 2.0}, "url": server.url}
    assert bulk.map_meshes("samples", files, out, client=dask, **asked).computed == 6
    for file in files:
        alone = client.upload(file, scale=2.0).samples(5)
        np.testing.assert_array_equal(answered(out, file)["vertex"][:], alone.vertices)
        np.testing.assert_array_equal(answered(out, file)["xyz"][:], alone.points)
        assert client.mesh(answered(out, file).attrs["mesh"]).reading == {"scale": 2}
    new = tmp_path / "new.zarr"
    with pytest.raises(geodesicd.ConnectionFailed):
        bulk.map_meshes("samples", files, new, client=dask, count=9, url="127.0.0.1:9")
    assert bulk.map_meshes("samples", files, new, client=dask, **asked).computed == 6


def test_costs_regions_and_walls_are_words_of_json() -> None:
    costs = Costs([(3, np.array([4, 5]))], slope=[(-1, 2), (1, 4)], up=np.array([0, 0, 1]))
    asked: dict[str, Any] = {
        "source": 0, "target": 9, "costs": costs, "within": np.array([True, False, True]),
        "forbid": ["part:2", {"sphere": {"center": np.zeros(3), "radius": np.float64(2)}}],
        "walls": np.array([3, 7]),
    }  # fmt: skip
    question = questions.checked("path", asked)
    assert json.loads(json.dumps(question)) == question
    assert question == {
        "question": "path",
        "source": {"vertex": 0},
        "target": {"vertex": 9},
        "costs": {
            "weights": [{"weight": 3.0, "region": "faces:4-5"}],
            "slope": "-1.0:2.0,1.0:4.0",
            "up": [0.0, 0.0, 1.0],
        },
        "within": ["faces:0,2"],
        "forbid": ["part:2", "sphere:0.0,0.0,0.0,2.0"],
        "walls": ["v:3;v:7"],
    }


def test_cheap_ways_past_what_is_forbidden(
    dask: Any, server: geodesicd.LocalServer, client: geodesicd.Client, tmp_path: Path,
    chance: random.Random,
) -> None:  # fmt: skip
    file = tmp_path / "mesh.ply"
    file.write_bytes(geodesicd.ply_bytes(*hills(6, chance.getrandbits(30))))
    out = tmp_path / "out.zarr"
    costs = Costs(slope="tobler", up=(0, 0, 1))
    asked: dict[str, Any] = {"source": 0, "target": 9, "costs": costs, "forbid": np.array([49])}
    run: dict[str, Any] = {"client": dask, "url": server.url}
    report = bulk.map_meshes("path", [file], out, **run, **asked)
    assert (report.computed, report.failures) == (1, {})
    alone = client.upload(file).path(**asked)
    np.testing.assert_array_equal(answered(out, str(file))["xyz"][:], alone.points)
    assert bulk.map_meshes("path", [file], out, **run, **asked).there == 1
    asked["costs"] = Costs(slope="energy", up=(0, 0, 1))
    with pytest.raises(ValueError, match="another question"):
        bulk.map_meshes("path", [file], out, **run, **asked)


def test_what_is_wrong_is_said_before_anything_is_done(
    logged: Logged, tmp_path: Path, chance: random.Random
) -> None:
    files = made(tmp_path / "meshes", 1, chance)
    wrong: list[tuple[type[Exception], str, dict[str, Any], str, str]] = [
        (ValueError, "picture", {}, "o.zarr", "distance, regions"),
        (TypeError, "distance", {}, "o.zarr", "distance: missing a required argument: 'sources'"),
        (TypeError, "table", {"sources": 0, "from": 0}, "o.zarr", "unexpected keyword"),
        (TypeError, "distance", {"sources": 0, "within": 3.5}, "o.zarr", "a float is no region"),
        (TypeError, "samples", {"count": {5}}, "o.zarr", "set is not JSON"),
        (ValueError, "distance", {"sources": 0}, "o.npy", "should end with .zarr or .parquet"),
    ]
    for error, question, asked, out, told in wrong:
        with pytest.raises(error, match=told):
            bulk.map_meshes(question, files, tmp_path / out, **asked)
        assert not (tmp_path / out).exists()
    with pytest.raises(ValueError, match="at least one source"):
        bulk.distance_matrix(files[0], [], tmp_path / "o.zarr")
    assert not logged.pids()


def test_without_dask_the_command_says_what_to_install(tmp_path: Path) -> None:
    code = (
        "import sys; sys.modules['distributed'] = None\n"
        "from geodesicd.commands import main; sys.exit(main())"
    )
    asked = ["map", "samples", "--count", "3", "-o", str(tmp_path / "o.zarr"), "x.ply"]
    run = subprocess.run(
        [sys.executable, "-c", code, *asked],
        capture_output=True, text=True, check=False, timeout=60,
    )  # fmt: skip
    assert run.returncode == 1
    assert "pip install 'geodesicd[bulk]'" in run.stderr
