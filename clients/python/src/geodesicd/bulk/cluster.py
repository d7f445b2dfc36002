"""The Dask cluster that does the work: the caller's, or processes on this machine. Dask decides
what runs where, and has what a worker took with it done again."""

from __future__ import annotations

import logging
import os
import signal
import uuid
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from itertools import islice
from multiprocessing import resource_tracker
from typing import Any, TypeVar

import dask
from dask.system import CPU_COUNT
from distributed import Client, LocalCluster, as_completed

from ..errors import ConnectionFailed, GeodesicError, Overloaded
from .servers import WorkersServer

T = TypeVar("T")


@dataclass(frozen=True)
class Cluster:
    """Workers that have a server each to ask.

    Attributes:
        server: the name of the plugin that has it.
        engine: the build of the servers.
        retries: how often a task is tried again.
    """

    dask: Any
    server: str
    engine: str
    retries: int

    def run(
        self, task: Callable[..., Any], jobs: Iterable[tuple[T, tuple[Any, ...]]]
    ) -> Iterator[tuple[T, Any]]:
        """Runs a task with the arguments of each job. As they end, each job's first part, and its
        future. Jobs are drawn as workers come free: two for each of their threads are underway."""
        most = 2 * max(1, sum(self.dask.nthreads().values()))
        waiting = iter(jobs)
        names: dict[str, T] = {}

        def begun() -> Iterator[Any]:
            for name, arguments in waiting:
                future = self.dask.submit(task, *arguments, pure=False, retries=self.retries)
                names[future.key] = name
                yield future

        running = as_completed(list(islice(begun(), most)))
        for future in running:
            yield names.pop(future.key), future
            running.update(list(islice(begun(), 1)))


@contextmanager
def cluster(
    client: Any,
    url: str | None,
    token: str | None,
    binary: str | os.PathLike[str] | None,
    flags: Sequence[str],
    workers: int | None,
    retries: int,
) -> Iterator[Cluster]:
    """The caller's cluster, or one for as long as the block runs, with servers to ask."""
    if (workers is not None and workers < 1) or retries < 0:
        raise ValueError("workers are 1 or more, retries 0 or more")
    url = url or os.environ.get("GEODESICD_URL") or None
    if url == os.environ.get("GEODESICD_URL"):
        token = token or os.environ.get("GEODESICD_TOKEN")
    plugin = WorkersServer(f"geodesicd-{uuid.uuid4().hex}", url, token, binary, flags)
    with _dask(client, workers, retries) as connected:
        try:
            connected.register_plugin(plugin)
            engines = sorted(set(connected.run(_engine, plugin.name).values()))
            if not engines:
                raise ValueError("that Dask cluster has no workers: start some")
            if len(engines) > 1:
                raise ValueError(
                    "the workers have servers of different builds, whose last digits may differ: "
                    f"give all of them the same ({', '.join(engines)})"
                )
            yield Cluster(connected, plugin.name, engines[0], retries)
        finally:
            with suppress(KeyError):  # of workers that have not come so far
                connected.unregister_worker_plugin(plugin.name)


def _engine(name: str, dask_worker: Any) -> str:
    engine: str = dask_worker.plugins[name].engine
    return engine


def running(address: str) -> Any:
    """A client of a Dask cluster that runs, by its scheduler's address."""
    return Client(address)


@contextmanager
def _dask(client: Any, workers: int | None, retries: int) -> Iterator[Any]:
    if client is not None:
        yield client
        return
    resource_tracker.ensure_running()  # or it begins below, and lets signals through again
    with ExitStack() as stack:
        # Ctrl-C at a terminal goes to all its processes, and is for this one, which stops the rest
        # in order. They are begun by threads that are begun here, and inherit this.
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            stack.enter_context(
                dask.config.set({"distributed.scheduler.allowed-failures": retries})
            )
            local = LocalCluster(
                n_workers=workers or CPU_COUNT,
                threads_per_worker=1,
                dashboard_address="127.0.0.1:0",
                silence_logs=logging.CRITICAL,
            )
            connected = stack.enter_context(Client(stack.enter_context(local)))
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
        yield connected


def reason(future: Any) -> str | None:
    """Why a task has failed, if it has."""
    error = future.exception()
    return None if error is None else _told(error)


def lasting(error: Exception) -> str:
    """Why something cannot be answered. What may go well at another time, or with another server,
    is raised again, so that Dask tries again."""
    passing = isinstance(error, ConnectionFailed | Overloaded)
    if passing or (isinstance(error, GeodesicError) and error.status in (500, 502)):
        raise error
    return _told(error)


def _told(error: BaseException) -> str:
    if isinstance(error, GeodesicError):  # which say of themselves what they are
        return str(error)
    return f"{type(error).__name__}: {error}"
