"""What an error says: who was asked, in one traceback, and what to do next."""

from __future__ import annotations

import asyncio
import contextlib
import http.server
import pickle
import socket
import ssl
import subprocess
import threading
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

import geodesicd
from geodesicd import service
from geodesicd.bench.mixes import hills

ONCE = geodesicd.Retries(attempts=1)


class Stub(http.server.BaseHTTPRequestHandler):
    """Answers with the status that the path ends with, or not at all."""

    asked = 0

    def _answer(self) -> None:
        type(self).asked += 1
        wanted = self.path.rpartition("/")[2]
        body = b"<html>no problem document"
        if wanted == "nothing":
            self.close_connection = True
            return
        if wanted == "silence":
            self.server.silent.wait(10)  # type: ignore[attr-defined]
            return
        if wanted == "nonsense":
            self.wfile.write(b"nonsense\r\n\r\n")
            self.close_connection = True
            return
        self.send_response(200 if wanted in ("gzip", "half") else int(wanted))
        if wanted == "gzip":
            self.send_header("Content-Encoding", "gzip")
        self.send_header("Content-Type", "text/html")
        self.send_header("Location", "https://elsewhere.example/\x9b2J")
        self.send_header("Retry-After", "0")
        self.send_header("Content-Length", str(len(body) + (9 if wanted == "half" else 0)))
        self.end_headers()
        self.wfile.write(body)
        self.close_connection = True

    do_GET = do_PUT = do_POST = do_PATCH = do_HEAD = _answer

    def log_message(self, *_: Any) -> None:
        pass


class StubServer(http.server.ThreadingHTTPServer):
    def __init__(self) -> None:
        self.silent = threading.Event()
        super().__init__(("127.0.0.1", 0), Stub)

    def handle_error(self, *_: Any) -> None:
        pass


def running(server: StubServer) -> Iterator[int]:
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield server.server_port
    server.silent.set()
    server.shutdown()
    thread.join()
    server.server_close()


@pytest.fixture(scope="module")
def stub() -> Iterator[int]:
    """The port of a server that answers as its path says."""
    yield from running(StubServer())


@pytest.fixture(scope="module")
def certified(tmp_path_factory: pytest.TempPathFactory) -> ssl.SSLContext:
    """What a server needs to speak TLS, with a certificate that nobody trusts."""
    folder = tmp_path_factory.mktemp("tls")
    key, certificate = folder / "key.pem", folder / "certificate.pem"
    subprocess.run(
        ["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "1", "-subj",
         "/CN=localhost", "-keyout", key, "-out", certificate], check=True, capture_output=True,
    )  # fmt: skip
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(certificate, key)
    return context


@pytest.fixture(scope="module")
def secure(certified: ssl.SSLContext) -> Iterator[int]:
    """The port of the same with that."""
    server = StubServer()
    server.socket = certified.wrap_socket(server.socket, server_side=True)
    yield from running(server)


def caught(ask: Callable[[], Any]) -> geodesicd.GeodesicError:
    """The error of a call, which has one traceback, in which no library shows."""
    with pytest.raises(geodesicd.GeodesicError) as info:
        ask()
    error = info.value
    told = "".join(traceback.format_exception(error))
    assert told.count("Traceback") == 1
    assert "httpx" not in told
    assert "During handling" not in told
    assert ".." not in str(error).replace("...", "")
    assert str(error).isprintable()
    assert str(pickle.loads(pickle.dumps(error))) == str(error)
    return error


def of_both(url: str, target: str, **options: Any) -> list[geodesicd.GeodesicError]:
    """The errors of both clients."""

    async def ask() -> None:
        async with geodesicd.AsyncClient(url, retries=ONCE, **options) as client:
            await client.fetch("GET", target)

    with geodesicd.Client(url, retries=ONCE, **options) as client:
        return [caught(lambda: client.fetch("GET", target)), caught(lambda: asyncio.run(ask()))]


NO_USE = "Asking again will not help"


@pytest.mark.parametrize(
    ("status", "kind", "says"),
    [
        (302, geodesicd.GeodesicError, "sends to https://elsewhere.example"),
        (401, geodesicd.NotAllowed, "--token or $GEODESICD_TOKEN"),
        (403, geodesicd.NotAllowed, "does not let this through"),
        (404, geodesicd.NotFound, "is that address one"),
        (413, geodesicd.GeodesicError, f"{NO_USE}: what is before the server takes no body"),
        (415, geodesicd.GeodesicError, "is that address one"),
        (422, geodesicd.GeodesicError, "is that address one"),
        (429, geodesicd.Overloaded, "Ask later"),
        (502, geodesicd.GeodesicError, "Is it running?"),
        (503, geodesicd.Overloaded, "Ask later"),
        (504, geodesicd.DeadlineExceeded, "progress="),
        (507, geodesicd.GeodesicError, f"{NO_USE}: what is before the server has no room"),
    ],
)
def test_a_reply_of_what_is_between(stub: int, status: int, kind: type, says: str) -> None:
    for error in of_both(f"http://127.0.0.1:{stub}", f"/x/{status}"):
        assert type(error) is kind
        assert (error.status, error.code) == (status, f"http_{status}")
        assert error.server == f"127.0.0.1:{stub}"
        assert f"(server 127.0.0.1:{stub})" in str(error)
        assert says in str(error)


@pytest.mark.parametrize("status", [302, 401, 403, 404, 413, 415, 422, 500, 502, 504, 507])
def test_only_what_passes_is_asked_again(stub: int, status: int) -> None:
    with geodesicd.Client(f"http://127.0.0.1:{stub}") as client:
        before = Stub.asked
        caught(lambda: client.fetch("GET", f"/x/{status}"))
        assert Stub.asked == before + 1
        caught(lambda: client.fetch("GET", "/x/503"))
        assert Stub.asked == before + 1 + 5


@pytest.mark.parametrize(
    ("target", "says"),
    [("nothing", "ask again"), ("nonsense", "ask again"), ("half", "ask again"),
     ("gzip", "ask again"), ("silence", "longer timeout=")],
)  # fmt: skip
def test_no_whole_reply(stub: int, target: str, says: str) -> None:
    patience = 0.2 if target == "silence" else 10
    for error in of_both(f"http://127.0.0.1:{stub}", f"/x/{target}", timeout=patience):
        assert isinstance(error, geodesicd.ConnectionFailed)
        assert (error.sent, error.timeout, error.lasting) == (True, target == "silence", False)
        assert f"127.0.0.1:{stub} gave no reply to GET /x/{target}" in str(error)
        assert says in str(error)


def test_an_answer_that_is_none(stub: int) -> None:
    with geodesicd.Client(f"http://127.0.0.1:{stub}", retries=ONCE) as client:
        error = caught(lambda: client.run(service.metadata("200")))
    assert (error.status, error.code) == (200, "http_200")
    assert "not what was asked for" in str(error)
    assert f"server 127.0.0.1:{stub}" in str(error)


def test_no_server_there() -> None:
    with socket.socket() as unused:
        unused.bind(("127.0.0.1", 0))
        port = unused.getsockname()[1]
        for error in of_both(f"http://127.0.0.1:{port}", "/v1/status"):
            assert isinstance(error, geodesicd.ConnectionFailed)
            assert (error.sent, error.lasting) == (False, False)
            assert f"127.0.0.1:{port} gave no reply to GET /v1/status" in str(error)
            assert "geodesic serve" in str(error)


def test_no_such_name(monkeypatch: pytest.MonkeyPatch) -> None:
    def unknown(*_: Any, **__: Any) -> None:
        raise socket.gaierror(socket.EAI_NONAME, "Name or service not known")

    # As a resolver that answers at once; the machine may have none, or a slow one.
    monkeypatch.setattr(socket, "getaddrinfo", unknown)
    for error in of_both("http://no-such-host.invalid:8080", "/v1/status"):
        assert isinstance(error, geodesicd.ConnectionFailed)
        assert "no-such-host.invalid:8080" in str(error)
        assert "Is the name of the server right" in str(error)


def test_a_certificate_that_is_not_trusted(secure: int) -> None:
    url = f"https://127.0.0.1:{secure}"
    for error in of_both(url, "/x/200"):
        assert isinstance(error, geodesicd.ConnectionFailed)
        assert error.lasting
        assert "$SSL_CERT_FILE" in str(error)
        assert f"127.0.0.1:{secure}" in str(error)
    with geodesicd.Client(url) as client:  # which would ask again
        caught(lambda: client.fetch("GET", "/x/200"))
    with geodesicd.Client(url, verify=False) as client:
        assert client.fetch("GET", "/x/200").status == 200


def test_with_tls_where_there_is_none_and_without_where_there_is(stub: int, secure: int) -> None:
    for error in of_both(f"https://127.0.0.1:{stub}", "/x/200"):
        assert "begins with http://" in str(error)
    for error in of_both(f"http://127.0.0.1:{secure}", "/x/200"):
        assert "begins with https://" in str(error)


@contextmanager
def greeting(
    greetings: list[bytes | None], certified: ssl.SSLContext
) -> Iterator[tuple[int, list[str]]]:
    """A server that reads TLS's greeting and replies so, one connection after the other, before it
    hangs up; None: it speaks TLS and answers. Gives its port and what it did."""
    done: list[str] = []
    listener = socket.create_server(("127.0.0.1", 0))

    def serve() -> None:
        for reply in greetings:
            try:
                peer, _ = listener.accept()
            except OSError:  # no more are wanted
                return
            with peer, contextlib.suppress(OSError):
                peer.settimeout(60)
                if reply is None:
                    with certified.wrap_socket(peer, server_side=True) as secured:
                        secured.recv(65536)
                        done.append("answered")
                        secured.sendall(b"HTTP/1.1 200 OK\r\nContent-Length: 0\r\n\r\n")
                else:
                    peer.recv(65536)
                    done.append("hung up")
                    peer.sendall(reply)

    thread = threading.Thread(target=serve)
    thread.start()
    try:
        yield listener.getsockname()[1], done
    finally:
        listener.shutdown(socket.SHUT_RDWR)
        thread.join()
        listener.close()


ALERT = bytes([21, 3, 3, 0, 2, 2])  # fatal; the code follows


@pytest.mark.parametrize("asynchronous", [False, True])
@pytest.mark.parametrize(
    ("greeted", "lasting"),
    [(b"", False), (ALERT[:3], False), (ALERT + b"\x50", False), (ALERT + b"\x28", False),
     (b"HTTP/1.1 400 Bad Request\r\n\r\n", True), (b"<html>", True)],
    ids=["end", "half an alert", "internal error", "no handshake", "HTTP", "HTML"],
)  # fmt: skip
def test_tls_that_breaks_is_tried_again_and_what_is_none_is_not(
    certified: ssl.SSLContext, greeted: bytes, lasting: bool, asynchronous: bool
) -> None:
    retries = geodesicd.Retries(attempts=3, first_pause=0.01)

    async def ask(url: str) -> int:
        async with geodesicd.AsyncClient(url, retries=retries, verify=False) as client:
            return (await client.fetch("GET", "/")).status

    def asked(url: str) -> int:
        if asynchronous:
            return asyncio.run(ask(url))
        with geodesicd.Client(url, retries=retries, verify=False) as client:
            return client.fetch("GET", "/").status

    with greeting([greeted, greeted, None], certified) as (port, done):
        url = f"https://127.0.0.1:{port}"
        if lasting:
            assert "begins with http://" in str(caught(lambda: asked(url)))
            assert done == ["hung up"]
        else:
            assert asked(url) == 200
            assert done == ["hung up", "hung up", "answered"]
    with greeting([greeted] * 3, certified) as (port, done):
        error = caught(lambda: asked(f"https://127.0.0.1:{port}"))
        assert isinstance(error, geodesicd.ConnectionFailed)
        assert (error.lasting, len(done)) == (lasting, 1 if lasting else 3)
        assert ("geodesic serve" in str(error)) == (len(greeted) < len(ALERT))


def test_the_servers_own_refusals_say_the_limit_and_the_way_out(tmp_path: Path) -> None:
    def refused(
        ask: Callable[[], Any], status: int, code: str, says: str, limit: int | None = None
    ) -> None:
        error = caught(ask)
        assert (error.status, error.code) == (status, code)
        assert says in str(error)
        assert f"server {error.server}" in str(error)
        if limit is not None:
            assert error.limit == limit
            assert f"limit {limit}, actual " in str(error)

    flags = ["--max-body-bytes", "20000", "--max-vertices", "100"]
    with geodesicd.serve(flags=[*flags, "--store-max-bytes", "3000"]) as client:
        triangle = client.upload(([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]))
        refused(lambda: client.upload(hills(30, 1)), 413, "too_large", "--max-body-bytes", 20000)
        refused(lambda: client.upload(hills(11, 1)), 422, "too_many_vertices", "--max-v", 100)
        refused(lambda: client.upload(hills(9, 1)), 507, "store_full", "--store-max-bytes", 3000)
        refused(lambda: client.upload(b"nonsense"), 415, "format_unknown", "trimesh")
        refused(lambda: client.mesh("0" * 64), 404, "mesh_unknown", "client.meshes()")
        refused(lambda: triangle.path(0, 7), 422, "index_out_of_range", "the last is 2", 2)
        refused(lambda: triangle.path(0, 1, method="x"), 422, "method_unknown", "client.methods()")
        near = geodesicd.Xyz((0, 0, 9), max_snap=1)
        refused(lambda: triangle.path(near, 1), 422, "snap_too_far", "larger max_snap")
        up = geodesicd.Ray((0, 0, 9), (0, 0, 1))
        refused(lambda: triangle.nearest(up), 422, "no_hit", "mesh.bbox")
    scant = ["--query-memory-bytes", "100KiB", "--reply-memory-bytes", "16MiB"]
    with geodesicd.serve(flags=scant) as client:
        mesh = client.upload(hills(400, 1))
        refused(
            lambda: mesh.path(0, 9999, method="exact"), 422, "too_much_memory",
            "--query-memory-bytes", 100 << 10,
        )  # fmt: skip
        refused(lambda: mesh.geometry(), 422, "too_much_memory", "--reply-memory-bytes", 16 << 20)
    with geodesicd.serve(flags=["--job-result-bytes", "1MiB"]) as client:
        mesh = client.upload(hills(400, 1))
        error = caught(lambda: mesh.distance(0, progress=lambda part: None))
        assert (error.status, error.code) == (413, "too_large")
        assert "--job-result-bytes" in str(error)
