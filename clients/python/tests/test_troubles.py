"""What goes wrong between a client and a server: refusals that pass, connections that break,
jobs that are cancelled, and a field of a million vertices in little memory."""

from __future__ import annotations

import asyncio
import http.server
import pickle
import socket
import threading
import time
import traceback
import tracemalloc
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest

import geodesicd
from geodesicd import queries, tables
from geodesicd.bench.mixes import hills
from geodesicd.errors import seconds_of
from geodesicd.flows import EventReader, Request, Watch
from geodesicd.wire import Reply


@contextmanager
def trouble_before(server: str, troubles: list[Any]) -> Iterator[tuple[str, list[str]]]:
    """A proxy before a real server that makes trouble first: a status with headers, or None for
    hanging up. Gives its URL and what it was asked."""
    asked: list[str] = []

    class Proxy(http.server.BaseHTTPRequestHandler):
        def _pass_on(self) -> None:
            asked.append(self.command)
            body = self.rfile.read(int(self.headers.get("Content-Length", 0)))
            if troubles:
                trouble = troubles.pop(0)
                self.close_connection = True
                if trouble is None:
                    return
                status, headers = trouble
                self.send_response(status)
                for name, value in headers.items():
                    self.send_header(name, value)
                self.send_header("Content-Length", "0")
                self.end_headers()
                return
            reply = httpx.request(self.command, server + self.path, content=body, timeout=60)
            self.send_response(reply.status_code)
            for name in ("content-type", "geo-shape", "geo-dtype", "location"):
                if name in reply.headers:
                    self.send_header(name, reply.headers[name])
            length = (
                reply.headers["content-length"] if self.command == "HEAD" else len(reply.content)
            )
            self.send_header("Content-Length", str(length))
            self.end_headers()
            self.wfile.write(reply.content)

        do_GET = do_HEAD = do_PUT = do_POST = _pass_on

        def log_message(self, *_: Any) -> None:
            pass

    proxy = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Proxy)
    thread = threading.Thread(target=proxy.serve_forever)
    thread.start()
    try:
        yield f"http://127.0.0.1:{proxy.server_port}", asked
    finally:
        proxy.shutdown()
        thread.join()
        proxy.server_close()


def test_refusals_that_pass_are_waited_out(
    server: geodesicd.LocalServer, plane: geodesicd.Mesh
) -> None:
    troubles: list[Any] = [(503, {"Retry-After": "0"}), (429, {"Retry-After": "0"}), None]
    with trouble_before(server.url, troubles) as (url, asked), geodesicd.Client(url) as client:
        assert client.mesh(plane.id).vertices == 10000
    assert asked == ["GET"] * 4


def test_the_time_that_the_server_names_is_honoured(
    server: geodesicd.LocalServer, plane: geodesicd.Mesh, monkeypatch: pytest.MonkeyPatch
) -> None:
    slept: list[float] = []
    monkeypatch.setattr(time, "sleep", slept.append)
    with (
        trouble_before(server.url, [(503, {"Retry-After": "7"})]) as (url, _),
        geodesicd.Client(url) as client,
    ):
        client.mesh(plane.id)
    waits = [seconds for seconds in slept if seconds >= 1]
    assert len(waits) == 1
    assert 7 <= waits[0] <= 7.2


def test_too_long_a_wait_is_an_error_at_once(server: geodesicd.LocalServer) -> None:
    with (
        trouble_before(server.url, [(503, {"Retry-After": "3600"})]) as (url, asked),
        geodesicd.Client(url) as client,
        pytest.raises(geodesicd.Overloaded) as caught,
    ):
        client.status()
    assert caught.value.retry_after == 3600
    assert len(asked) == 1


@pytest.mark.parametrize("status", [413, 422, 507])
def test_what_can_never_fit_is_not_asked_again(server: geodesicd.LocalServer, status: int) -> None:
    with (
        trouble_before(server.url, [(status, {"Retry-After": "0"})] * 3) as (url, asked),
        geodesicd.Client(url) as client,
        pytest.raises(geodesicd.GeodesicError) as caught,
    ):
        client.status()
    assert caught.value.status == status
    assert len(asked) == 1


def told_of(error: BaseException) -> str:
    return "".join(traceback.format_exception(error))


def test_a_server_that_is_not_there_is_named_in_one_traceback() -> None:
    with socket.socket() as unused:
        unused.bind(("127.0.0.1", 0))
        port = unused.getsockname()[1]
        for address in (f"http://127.0.0.1:{port}", f"127.0.0.1:{port}"):
            with (
                geodesicd.Client(address, retries=geodesicd.Retries(attempts=1)) as client,
                pytest.raises(geodesicd.ConnectionFailed) as caught,
            ):
                client.status()
            told = told_of(caught.value)
            assert told.count("Traceback") == 1
            assert "httpx" not in told
            assert f"127.0.0.1:{port} gave no reply to GET /v1/status" in told
            assert "geodesic serve" in told
            assert told_of(pickle.loads(pickle.dumps(caught.value))).endswith(told[-60:])


@pytest.mark.parametrize("wrong", ["ftp://127.0.0.1", "http://", "http://[::1"])
def test_what_is_no_address(wrong: str) -> None:
    with pytest.raises(ValueError, match="no server's address"):
        geodesicd.Client(wrong)


def test_a_refusal_says_who_refused_and_what_to_do(
    server: geodesicd.LocalServer, plane: geodesicd.Mesh
) -> None:
    with pytest.raises(geodesicd.NotFound) as caught:
        plane.client.mesh("0" * 64)
    told = told_of(caught.value)
    assert told.count("Traceback") == 1
    assert server.url.removeprefix("http://") in told
    assert "Upload it" in told
    small = geodesicd.serve(flags=["--store-max-bytes", "1000", "--max-body-bytes", "200000"])
    with small as client:
        with pytest.raises(geodesicd.GeodesicError, match="--store-max-bytes") as refused:
            client.upload(hills(20, 1))
        assert (refused.value.status, refused.value.limit) == (507, 1000)
        with pytest.raises(geodesicd.GeodesicError, match="too_large") as refused:
            client.upload(hills(300, 1))  # refused while it is still being sent
        assert refused.value.limit == 200000
        client.fetch("GET", "/v1/status")
        with pytest.raises(geodesicd.NotFound) as caught:
            client.fetch("GET", "/v1/nothing")
        assert caught.value.hint is None
    with (
        trouble_before(server.url, [(404, {})]) as (url, _),
        geodesicd.Client(url) as client,
        pytest.raises(geodesicd.NotFound, match="no reply of geodesicd's own"),
    ):
        client.status()


def test_an_upload_is_sent_again_in_full(server: geodesicd.LocalServer) -> None:
    data = geodesicd.glb_bytes(*hills(300, 8))
    # HEAD passes with 404, then PUT is cut, then refused, then taken.
    troubles: list[Any] = [(404, {}), None, (503, {"Retry-After": "0"})]
    with trouble_before(server.url, troubles) as (url, asked), geodesicd.Client(url) as client:
        assert client.upload(data).bytes == len(data)
    assert asked == ["HEAD", "PUT", "PUT", "PUT"]


def test_no_server_is_said_so() -> None:
    with (
        geodesicd.Client("http://127.0.0.1:1", retries=geodesicd.Retries(attempts=2)) as client,
        pytest.raises(geodesicd.ConnectionFailed) as caught,
    ):
        client.status()
    assert not caught.value.sent
    assert caught.value.status == 0


def test_silence_ends_and_is_not_asked_again(terrain: geodesicd.Mesh) -> None:
    with geodesicd.Client(terrain.client.url, timeout=0.05) as hasty:
        mesh = geodesicd.Mesh.__new__(geodesicd.Mesh)
        mesh.__dict__.update(vars(terrain) | {"client": hasty})
        with pytest.raises(geodesicd.ConnectionFailed) as caught:
            mesh.table(list(range(100)), method="chen_han")
    assert caught.value.timeout


def test_a_deadline_is_kept(terrain: geodesicd.Mesh) -> None:
    with pytest.raises(geodesicd.DeadlineExceeded) as caught:
        terrain.table(list(range(100)), method="chen_han", deadline=0.05)
    assert caught.value.code == "deadline"


def test_progress_rises_to_one(terrain: geodesicd.Mesh) -> None:
    told: list[float] = []
    field = terrain.distance(3, method="exact", progress=told.append)
    assert told[0] == 0
    assert told == sorted(told)
    assert told[-1] == 1
    assert len(told) > 3
    np.testing.assert_array_equal(field, terrain.distance(3, method="exact"))
    assert terrain.client.status()["jobs"]["ended"] == 0  # none is left lying about


def jobs(client: geodesicd.Client) -> int:
    counts = client.status()["jobs"]
    return int(counts["queued"] + counts["running"] + counts["ended"])


def jobs_under_way(client: geodesicd.Client) -> int:
    counts = client.status()["jobs"]
    return int(counts["queued"] + counts["running"])


def test_an_interrupt_cancels_the_job(terrain: geodesicd.Mesh) -> None:
    during: list[int] = []

    def interrupt(part: float) -> None:
        during.append(jobs(terrain.client))
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        terrain.table(list(range(200)), method="chen_han", progress=interrupt)
    assert during == [1]
    end = time.monotonic() + 60
    # First the computation leaves its slot, and then the job its thread.
    while time.monotonic() < end:
        status = terrain.client.status()
        if status["compute"]["running"] == status["jobs"]["running"] == 0:
            return
        time.sleep(0.05)
    raise AssertionError("the job goes on")


def test_cancelling_a_task_cancels_the_job(terrain: geodesicd.Mesh) -> None:
    async def ask() -> None:
        async with geodesicd.AsyncClient(terrain.client.url) as client:
            mesh = await client.mesh(terrain.id)
            begun = asyncio.Event()
            task = asyncio.create_task(
                mesh.table(
                    list(range(200, 400)), method="chen_han", progress=lambda part: begun.set()
                )
            )
            await begun.wait()
            task.cancel()
            with pytest.raises(asyncio.CancelledError):
                await task
            for _ in range(600):
                counts = (await client.status())["jobs"]
                if counts["queued"] + counts["running"] == 0:
                    return
                await asyncio.sleep(0.1)
            raise AssertionError("the job goes on")

    asyncio.run(ask())


class Hearing(geodesicd.Client):
    """One that knows the job it has begun, and can be made deaf to its events."""

    job = ""
    deaf_until: Callable[[], bool] | None = None

    def _send(self, request: Request) -> Reply:
        reply = super()._send(request)
        if reply.status == 202:
            self.job = reply.json()["id"]
        return reply

    def _watch(self, step: Watch) -> None:
        if self.deaf_until is None:
            super()._watch(step)
            return
        end = time.monotonic() + 60
        while not self.deaf_until():
            assert time.monotonic() < end
            time.sleep(0.05)
        raise geodesicd.ConnectionFailed("asleep", sent=True)


def slow_job(client: geodesicd.Client, mesh: str, progress: Callable[[float], None]) -> Any:
    return client.run(tables.table(mesh, list(range(200)), method="chen_han", progress=progress))


def test_a_job_that_somebody_cancels_says_so_in_the_servers_words(terrain: geodesicd.Mesh) -> None:
    with Hearing(terrain.client.url) as client:
        told: list[float] = []

        def cancel(part: float) -> None:
            if not told:  # a second time would make the server forget it
                terrain.client.fetch("DELETE", f"/v1/jobs/{client.job}")
            told.append(part)

        with pytest.raises(geodesicd.JobCancelled) as caught:
            slow_job(client, terrain.id, cancel)
    assert caught.value.detail == "the job was cancelled and has no result"


def test_a_job_that_nobody_asked_about_says_why_it_was_cancelled(samples: Path) -> None:
    with geodesicd.serve(flags=["--job-lease-seconds", "1"]) as other:
        mesh = other.upload(samples / "terrain.glb")
        with Hearing(other.url) as client:
            client.deaf_until = lambda: jobs_under_way(other) == 0
            with pytest.raises(geodesicd.JobCancelled, match="nobody asked about it") as caught:
                slow_job(client, mesh.id, lambda part: None)
        assert (caught.value.status, caught.value.code) == (409, "job_cancelled")
        assert jobs(other) == 0  # it is forgotten all the same


def test_a_job_that_is_forgotten_is_not_taken_for_a_missing_mesh(terrain: geodesicd.Mesh) -> None:
    class Forgetting(Hearing):
        def _send(self, request: Request) -> Reply:
            if request.target.endswith("/result"):
                terrain.client.fetch("DELETE", request.target.removesuffix("/result"))
            return super()._send(request)

    with (
        Forgetting(terrain.client.url) as client,
        pytest.raises(geodesicd.JobCancelled, match="not there any more"),
    ):
        client.run(queries.path(terrain.id, 0, 9, progress=lambda part: None))
    with pytest.raises(geodesicd.NotFound, match="mesh_unknown"):
        terrain.client.run(queries.path("0" * 64, 0, 9, progress=lambda part: None))


def test_a_job_that_fails_raises_its_error(plane: geodesicd.Mesh) -> None:
    with pytest.raises(geodesicd.GeodesicError) as caught:
        plane.path(0, 77777, progress=lambda part: None)
    assert caught.value.parameter == "to"


def test_a_field_of_a_million_vertices_is_in_memory_once(client: geodesicd.Client) -> None:
    mesh = client.upload(hills(1000, 1))
    assert mesh.vertices == 1_000_000
    mesh.distance_at(0, 1)  # what is imported and connected once is not to be counted
    tracemalloc.start()
    try:
        field = mesh.distance(0)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert field.nbytes == 8_000_000
    assert np.isfinite(field).all()
    assert peak < field.nbytes * 1.1
    assert not field.flags.owndata  # a view of what came
    mesh.delete()


def test_retry_after_may_be_a_date() -> None:
    assert seconds_of("3") == 3
    assert seconds_of("Wed, 21 Oct 2015 07:28:00 GMT") == 0
    later = seconds_of("Wed, 21 Oct 2099 07:28:00 GMT")
    assert later is not None
    assert later > 1e9
    assert seconds_of("soon") is None


def test_events_are_read_as_the_standard_says() -> None:
    reader = EventReader()
    lines = [": a comment", "", "event: progress", "data: one", "data:two", "id: 3", "", "data: x"]
    assert [reader.feed(line) for line in lines] == [None] * 6 + ["one\ntwo", None]
