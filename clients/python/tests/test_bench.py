"""The load test: its arithmetic by itself, and its loops against a real server."""

from __future__ import annotations

import asyncio
import json
import math
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import geodesicd
from geodesicd.bench import Histogram, Records, Settings, Workload, failures, parse_mix, report
from geodesicd.bench.drive import drive, due_times
from geodesicd.bench.report import parse_limits
from geodesicd.commands import main

LOCUSTFILE = Path(__file__).parents[1] / "locustfile.py"


def test_percentiles_are_within_a_bucket() -> None:
    times = np.random.default_rng(5).lognormal(-5, 1.5, 20000)
    one, two = Histogram(), Histogram()
    for number, seconds in enumerate(times):
        (one if number % 2 else two).add(float(seconds))
    one.merge(two)
    for percent in (50, 90, 99, 99.9):
        true = np.sort(times)[round(len(times) * percent / 100) - 1]
        assert true <= one.percentile(percent) <= true * 1.011
    assert one.percentile(100) == times.max()
    assert one.mean == pytest.approx(times.mean())
    assert sum(count for *_, count in one.buckets(8)) == one.count == 20000
    assert math.isnan(Histogram().percentile(99))


def test_mixes() -> None:
    assert parse_mix("path=8, field") == {"path": 8, "field": 1}
    for wrong in ("", "paths=1", "path=x", "path=0", "path=-1"):
        with pytest.raises(ValueError):
            parse_mix(wrong)
    assert parse_limits("50") == {"all": 50}
    assert parse_limits("path=5,field=7") == {"path": 5, "field": 7}


def test_requests_are_due_evenly_after_a_ramp() -> None:
    due = list(due_times(Settings(10, rate=20, ramp=4)))
    assert len(due) == 20 * 4 / 2 + 20 * 6
    after = np.array([t for t in due if t >= 4])
    np.testing.assert_allclose(np.diff(after), 1 / 20)
    # Half the rate on average while it grows, a quarter of those in the first half.
    assert sum(t < 2 for t in due) == 10
    with pytest.raises(ValueError):
        Settings(10, rate=20, clients=3)
    with pytest.raises(ValueError):
        Settings(10, rate=20, ramp=11)


def test_an_open_loop_counts_from_when_a_request_was_due() -> None:
    """A server that stands still once: the requests that had to wait for it are late, too."""

    class Still:
        def __init__(self) -> None:
            self.free_at = 0.0
            self.calls = 0

        async def run(self, flow: Any) -> None:
            loop = asyncio.get_running_loop()
            self.calls += 1
            # One after the other, and the first takes half a second.
            start = max(self.free_at, loop.time())
            self.free_at = start + (0.5 if self.calls == 1 else 0.0)
            await asyncio.sleep(self.free_at - loop.time())

    records = Records()
    workload = Workload("0" * 64, 100, {"path": 1})
    still: Any = Still()
    asyncio.run(drive(still, workload, Settings(1, rate=100), records))
    assert records.all.count == 100
    # Those due in that half second waited for a quarter of a second on average: half of all
    # were late. A loop that waited for each reply would have one late request.
    late = sum(count for low, _, count in records.all.buckets() if low > 0.05)
    assert late >= 40
    assert records.all.max >= 0.49


def test_a_closed_loop_keeps_its_clients(plane: geodesicd.Mesh) -> None:
    class Counting:
        def __init__(self) -> None:
            self.now = self.most = 0

        async def run(self, flow: Any) -> None:
            self.now += 1
            self.most = max(self.most, self.now)
            await asyncio.sleep(0.01)
            self.now -= 1

    counting: Any = Counting()
    workload = Workload("0" * 64, 100, {"path": 1})
    asyncio.run(drive(counting, workload, Settings(0.3, clients=3), Records()))
    assert counting.most == 3


def test_limits_are_judged() -> None:
    records = Records()
    for number in range(100):
        records.add("path", 0.010 + number * 1e-5, None, 0.5)
    records.add("field", 1.0, "overloaded", 1.5)
    outcome = report(records, Settings(2, clients=1), {"path": 1, "field": 1})
    assert outcome["errors"]["share"] == pytest.approx(1 / 101)
    assert outcome["seconds"][1] == {
        "second": 1, "completed": 0, "errors": 1, "p50_ms": None, "p99_ms": None
    }  # fmt: skip
    assert failures(outcome, {"all": 12}, 0.01) == []
    assert len(failures(outcome, {"path": 5, "field": 5}, 0.001)) == 3
    json.dumps(outcome, allow_nan=False)


def test_the_command(
    server: geodesicd.LocalServer, client: geodesicd.Client, tmp_path: Path
) -> None:
    before = len(client.meshes())
    command = [
        "bench", server.url, "--seconds", "2", "--vertices", "2500",
        "--mix", "path=4,field=2,table=1,upload=1",
        "--json", str(tmp_path / "report.json"), "--picture", str(tmp_path / "report.png"),
    ]  # fmt: skip
    assert main([*command, "--rate", "20", "--ramp", "1", "--fail-errors", "0"]) == 0
    outcome = json.loads((tmp_path / "report.json").read_text())
    assert outcome["requests"] == 30
    assert outcome["loop"] == "open"
    assert sum(numbers["count"] for numbers in outcome["latency_by_kind"].values()) == 30
    assert set(outcome["latency_by_kind"]) == {"path", "field", "table", "upload"}
    assert (tmp_path / "report.png").read_bytes().startswith(b"\x89PNG")
    assert main([*command, "--clients", "2", "--fail-p99", "0.001"]) == 1
    outcome = json.loads((tmp_path / "report.json").read_text())
    assert outcome["failures"][0].startswith("p99 of all")
    # Its uploads are gone again; the hills stay for the next run.
    assert len(client.meshes()) == before + 1


def test_a_server_that_is_gone_fails(capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "http://127.0.0.1:1", "--seconds", "1"]) == 1
    assert "connection_failed" in capfd.readouterr().err


def stopping_locust(folder: Path, *kinds: str) -> Path:
    """A file for Locust beside another, which ends a run once there are replies of these kinds, or
    of any: so a test waits for no time, which a slow machine may need more of."""
    file = folder / "stopping_locust.py"
    file.write_text(
        "from locust import events\n"
        f"wanted = set({kinds!r})\n"
        "@events.init.add_listener\n"
        "def begin(environment, **_):\n"
        "    @events.request.add_listener\n"
        "    def count(name, **_):\n"
        "        wanted.discard(name)\n"
        "        if not wanted:\n"
        "            environment.runner.quit()\n"
    )
    return file


def test_locust(server: geodesicd.LocalServer, tmp_path: Path) -> None:
    environment = {**os.environ, "GEODESIC_MIX": "path=3,upload=1,field=1,table=1"}
    files = f"{LOCUSTFILE},{stopping_locust(tmp_path, 'path', 'field')}"
    run = subprocess.run(
        [sys.executable, "-m", "locust", "-f", files, "--host", server.url,
         "--headless", "--users", "2", "--spawn-rate", "2", "--stop-timeout", "60",
         "--only-summary", "--json"],
        capture_output=True, text=True, timeout=120, env=environment, cwd=tmp_path, check=False,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
    kinds = {entry["name"]: entry for entry in json.loads(run.stdout)}
    assert set(kinds) >= {"path", "field"}
    assert all(entry["num_failures"] == 0 for entry in kinds.values())
    assert kinds["path"]["num_requests"] > 0
