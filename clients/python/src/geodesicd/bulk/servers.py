"""The server that each worker of a cluster asks: one of its own, which ends with it, or one that
runs already."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Sequence
from typing import Any

from distributed import WorkerPlugin, get_worker

from ..client import Client
from ..local_server import LocalServer

# Has the kernel end the server when the thread that started it is no more, so that it also ends
# with a worker that is killed. The thread that sets up plugins lives as long as the worker.
_TIED = """
import ctypes, os, signal, sys
ctypes.CDLL(None).prctl(1, signal.SIGTERM)  # PR_SET_PDEATHSIG
if os.getppid() == int(sys.argv[1]):
    os.execv(sys.argv[2], sys.argv[2:])
"""


class _TiedServer(LocalServer):
    """A server that ends with this thread, whatever ends that. Its files are in a folder of the
    worker's, which Dask removes after workers that were killed."""

    def __init__(
        self, binary: str | os.PathLike[str] | None, flags: Sequence[str], folder: str
    ) -> None:
        super().__init__(binary, flags=flags)
        self._before = (sys.executable, "-I", "-S", "-c", _TIED, str(os.getpid()))
        self._within = folder


def _flags(threads: int, memory: int | None, given: Sequence[str]) -> list[str]:
    """Flags for a server that takes a worker's threads, and half of its memory: the other half is
    the worker's own. Those that were given go before."""
    chosen = {"--log-level": "warn", "--compute-threads": str(threads)}
    if memory:
        parts = {"compute-memory": 4, "adjacency-cache": 8, "mesh-cache": 16}
        parts |= {"field-cache": 32, "reply-cache": 32}
        chosen |= {f"--{name}-bytes": str(memory // part) for name, part in parts.items()}
    for flag in given:
        chosen.pop(flag.partition("=")[0], None)
    return [*(word for pair in chosen.items() for word in pair), *given]


class WorkersServer(WorkerPlugin):  # type: ignore[misc]
    """Gives each worker a client of the server at ``url``; without it, of one that is started
    there.

    Args:
        name: by which tasks find it.
        binary, flags: of a server to start, as :func:`geodesicd.serve` has them.
    """

    def __init__(
        self,
        name: str,
        url: str | None,
        token: str | None,
        binary: str | os.PathLike[str] | None = None,
        flags: Sequence[str] = (),
    ) -> None:
        self.name = name
        self.url = url
        self.own = url is None
        self._token = token
        self._binary = binary
        self._flags = list(flags)

    def setup(self, worker: Any) -> None:
        """Called by Dask when a worker starts."""
        self._lock = threading.Lock()
        self._folder = worker.local_directory
        memory = worker.memory_manager.memory_limit
        self._flags = _flags(worker.state.nthreads, memory, self._flags)
        self._server: LocalServer | None = None
        self._client: Client | None = None
        status = self.client().status()
        # Builds that do not tell it are known by their version.
        self.engine = str(status.get("engine", status["version"]))

    def teardown(self, worker: Any) -> None:
        """Called by Dask when a worker stops in order."""
        if self._client is not None:
            self._client.close()
        if self._server is not None:
            self._server.stop()

    def client(self) -> Client:
        """A client of the server, which is started anew if it has ended.

        Raises:
            FileNotFoundError, RuntimeError: as :func:`geodesicd.serve`.
        """
        with self._lock:
            ended = self._server is None or not self._server.running
            if self._client is not None and not (self.own and ended):
                return self._client
            self.teardown(None)
            if self.own:
                self._server = _TiedServer(self._binary, self._flags, self._folder)
                self.url = self._server.start()
            self._client = Client(self.url, token=self._token)
            return self._client


def server_of_worker(name: str) -> WorkersServer:
    """The plugin of the worker that runs this task."""
    found: WorkersServer = get_worker().plugins[name]
    return found
