"""A server of one's own on this machine: for as long as a block runs, or until Python ends.

with geodesicd.serve() as client:
    field = client.upload("bunny.glb").distance(0)

field = geodesicd.local(vertices, faces).distance(0)
"""

from __future__ import annotations

import atexit
import contextlib
import importlib
import os
import re
import shutil
import signal
import subprocess
import tempfile
import threading
import time
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Unpack

from . import service
from .async_client import AsyncClient
from .client import Client, Mesh
from .flows import Progress
from .mesh_input import body_of, warn_of_rounding
from .service import Reading


def find_server(binary: str | os.PathLike[str] | None = None) -> Path:
    """The server's program: the argument, else $GEODESICD_BINARY, else $GEODESICD, else that of the
    package geodesicd-server, else ``geodesicd`` on PATH.

    Raises:
        FileNotFoundError: there is none; the message says how to get one.
    """
    for variable in ("", "GEODESICD_BINARY", "GEODESICD"):
        named = os.environ.get(variable) if variable else binary
        if not named:
            continue
        found = shutil.which(os.fspath(named))
        if found is None:
            where = f"${variable}" if variable else "the argument"
            raise FileNotFoundError(f"{where} names no program: {os.fspath(named)}")
        return Path(found)
    try:
        return Path(importlib.import_module("geodesicd_server").PROGRAM)
    except ModuleNotFoundError:
        found = shutil.which("geodesicd")
    if found is None:
        raise FileNotFoundError(
            "there is no geodesicd to start here. Three ways to one: install its wheel, "
            "pip install 'geodesicd[server]'; put it on PATH, as Debian's package does; or name "
            "the program as binary= or in $GEODESICD_BINARY ('make build' in its repository makes "
            "build/release/geodesicd). A server that runs elsewhere needs none of them: "
            "geodesicd.Client(url)"
        )
    return Path(found)


def shared_folder(program: Path, name: str) -> Path | None:
    """The folder ``viewer``, ``docs`` or ``samples`` that was installed with a program, in
    ``share`` beside its ``bin``; None where there is none."""
    folder = program.resolve().parent.parent / "share" / "geodesicd" / name
    return folder if folder.is_dir() else None


class LocalServer:
    """A running ``geodesicd`` on a free port of this machine. As a context manager, ``with``
    gives a :class:`Client` and ``async with`` an :class:`AsyncClient`; both stop the server at
    the end."""

    _before: Sequence[str] = ()  # a program that starts it, with that one's arguments
    _within: str | None = None  # the folder to make its temporary one in

    def __init__(
        self,
        binary: str | os.PathLike[str] | None = None,
        *,
        store: str | os.PathLike[str] | None = None,
        flags: Sequence[str] = (),
        listen: str = "127.0.0.1:0",
    ) -> None:
        self._binary = find_server(binary)
        self._store = store
        self._flags = list(flags)
        self._listen = listen
        self._folder: Path | None = None
        self._process: subprocess.Popen[bytes] | None = None
        self._client: Client | None = None
        self._async_client: AsyncClient | None = None
        self._owner = os.getpid()
        self.url = ""

    def start(self) -> str:
        """Starts it and waits until it listens; its URL.

        Raises:
            RuntimeError: it did not start; the message ends with its log.
        """
        if self._process is not None:
            return self.url
        self._folder = Path(tempfile.mkdtemp(prefix="geodesicd-", dir=self._within))
        store = Path(self._store) if self._store is not None else self._folder / "store"
        program = [*self._before, str(self._binary)]
        command = [*program, "--listen", self._listen, "--store", str(store)]
        # Variables meant for some other server are none of this one's business.
        clean = {k: v for k, v in os.environ.items() if not k.startswith("GEODESICD")}
        with self._log_file().open("wb") as log:
            self._process = subprocess.Popen(
                [*command, *self._flags],
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                env=clean,
                # Ctrl-C is for us, who stop it in order, once what runs has been cancelled.
                start_new_session=True,
            )
        atexit.register(self.stop)
        while True:
            ended = self._process.poll() is not None
            if listening := re.search(r"^listening on (https?://\S+)", self.log(), re.MULTILINE):
                self.url = listening[1]
                return self.url
            if ended:
                log_end = self.log()[-2000:]
                self.stop()
                raise RuntimeError(f"the server did not start:\n{log_end}")
            time.sleep(0.02)

    def stop(self) -> None:
        """Stops it (SIGTERM, which lets running requests finish) and removes its temporary
        files. It changes nothing to do so again."""
        atexit.unregister(self.stop)
        if os.getpid() != self._owner:
            return  # a fork of the process that it belongs to
        if self._process is not None:
            self._process.send_signal(signal.SIGTERM)
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._process.wait(30)
            self._process.kill()
            self._process.wait()
            self._process = None
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)
            self._folder = None

    @property
    def running(self) -> bool:
        """Whether it has been started and has not ended."""
        return self._process is not None and self._process.poll() is None

    def wait(self) -> int:
        """Waits until it ends of itself; its exit status."""
        return 0 if self._process is None else self._process.wait()

    def log(self) -> str:
        """What it has written so far."""
        return self._log_file().read_text(encoding="utf-8", errors="replace")

    def _log_file(self) -> Path:
        if self._folder is None:
            raise RuntimeError("the server is not running")
        return self._folder / "log"

    def __enter__(self) -> Client:
        self._client = Client(self.start())
        return self._client

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._client is not None:
            self._client.close()
            self._client = None
        self.stop()

    async def __aenter__(self) -> AsyncClient:
        self._async_client = AsyncClient(self.start())
        return self._async_client

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._async_client is not None:
            await self._async_client.close()
            self._async_client = None
        self.stop()


def serve(
    binary: str | os.PathLike[str] | None = None,
    *,
    store: str | os.PathLike[str] | None = None,
    flags: Sequence[str] = (),
    listen: str = "127.0.0.1:0",
) -> LocalServer:
    """A local server for a ``with`` block, which gives a client of it.

    Args:
        binary: the server's program; without it $GEODESICD_BINARY or $GEODESICD, else
            that of the package geodesicd-server, else ``geodesicd`` on PATH.
        store: the folder of its meshes; without it a temporary one, removed at the end.
        flags: more flags for it, such as ``["--compute-threads", "2"]``.
        listen: HOST:PORT; port 0 is any free one.

    Raises:
        FileNotFoundError: there is no such program. RuntimeError: it did not start.
    """
    return LocalServer(binary, store=store, flags=flags, listen=listen)


_shared: dict[tuple[object, ...], tuple[LocalServer, Client]] = {}
_shared_lock = threading.Lock()


def _shared_client(
    binary: str | os.PathLike[str] | None = None, flags: Sequence[str] = ()
) -> Client:
    """A client of a server that all of this process share, and that ends with it."""
    key = (os.getpid(), find_server(binary), *flags)
    with _shared_lock:
        known = _shared.get(key)
        if known is not None and known[0].running:
            return known[1]
        server = LocalServer(binary, flags=flags)
        client = Client(server.start())
        _shared[key] = server, client
        return client


def local(
    mesh: Any,
    faces: Any = None,
    *,
    binary: str | os.PathLike[str] | None = None,
    flags: Sequence[str] = (),
    name: str | None = None,
    progress: Progress | None = None,
    **reading: Unpack[Reading],
) -> Mesh:
    """A mesh on a server of this process's own, which is started when first needed and ends with
    the process: ``geodesicd.local(vertices, faces).distance(0)``.

    Args:
        mesh: vertices (n, 3), with ``faces`` (m, 3); or alone anything that
            :meth:`Client.upload` takes.
        binary: the server's program, as of :func:`serve`.
        flags: more flags for it; other flags are another server.
        name, progress, reading: as of :meth:`Client.upload`.

    Raises:
        FileNotFoundError: there is no such program; the message says how to get one.
        RuntimeError: it did not start. Others: as :meth:`Client.upload`.
    """
    client = _shared_client(binary, flags)
    body = body_of(mesh, faces)
    found = client.run(service.upload(body, progress, reading=reading, name=name))
    warn_of_rounding(body, found, reading, stacklevel=3)  # which names the caller's line
    return Mesh(client, found)


def connect(url: str | None = None, **options: Any) -> Client:
    """A client of the server at ``url``, else of that at $GEODESICD_URL (with $GEODESICD_TOKEN, if
    there is one), else of one of this process's own: for scripts that are to run with a server and
    without.

    Args:
        options: those of :class:`Client`.
    """
    if not url and os.environ.get("GEODESICD_URL"):
        # Which is for that server, and for no other.
        options.setdefault("token", os.environ.get("GEODESICD_TOKEN"))
    elif not url:
        url = _shared_client().url
    return Client(url, **options)
