"""Sends the load. In a closed loop, each of N clients sends its next request when it has the
reply to the last: a slow server is asked less, and its slow moments hide the requests that would
have met them. In an open loop, requests are due at a fixed rate whatever the server does, and
latency counts from the time at which a request was due, not from when it could be sent: nothing
is hidden (no coordinated omission)."""

from __future__ import annotations

import asyncio
import contextlib
import math
import time
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count

from ..async_client import AsyncClient
from ..errors import GeodesicError
from .mixes import Workload
from .records import Records


@dataclass(frozen=True)
class Settings:
    """How to send it.

    Attributes:
        seconds: for how long requests are sent.
        clients: the closed loop's clients; None: an open loop.
        rate: the open loop's requests a second; None: a closed loop.
        ramp: seconds over which clients or rate grow evenly from nothing.
        grace: seconds to wait at the end for replies that are still due; those that do not
            come are errors.
    """

    seconds: float
    clients: int | None = None
    rate: float | None = None
    ramp: float = 0.0
    grace: float = 30.0

    def __post_init__(self) -> None:
        if (self.clients is None) == (self.rate is None):
            raise ValueError("a load has either clients or a rate")
        for name in ("seconds", "clients", "rate"):
            value = getattr(self, name)
            if value is not None and not (0 < value < math.inf):
                raise ValueError(f"{name} has to be positive, not {value}")
        if not 0 <= self.ramp <= self.seconds:
            raise ValueError("the ramp is part of the time")


def due_times(settings: Settings) -> Iterator[float]:
    """When requests of an open loop are due, seconds after its start."""
    rate, ramp = settings.rate or 1.0, settings.ramp
    for number in count():
        # While the rate grows evenly, the number sent grows with the time's square.
        if number < rate * ramp / 2:
            due = math.sqrt(2 * ramp * number / rate)
        else:
            due = ramp / 2 + number / rate
        if due >= settings.seconds:
            return
        yield due


async def drive(
    client: AsyncClient,
    workload: Workload,
    settings: Settings,
    records: Records,
    stop: asyncio.Event | None = None,
) -> None:
    """Sends the load and fills the records, until the time is over or ``stop`` is set. The
    client should not retry: what it is refused is to be counted."""
    run = _Run(client, workload, settings, records, stop or asyncio.Event())
    await (run.closed() if settings.clients is not None else run.open())


class _Run:
    def __init__(
        self,
        client: AsyncClient,
        workload: Workload,
        settings: Settings,
        records: Records,
        stop: asyncio.Event,
    ) -> None:
        self._client = client
        self._workload = workload
        self._settings = settings
        self._records = records
        self._stop = stop
        self._start = time.perf_counter()

    def _now(self) -> float:
        return time.perf_counter() - self._start

    async def _pause_until(self, at: float) -> None:
        """Sleeps till then, or until the run is stopped."""
        wait = at - self._now()
        if wait > 0:
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(self._stop.wait(), wait)

    async def _one(self, due: float | None) -> None:
        """One request; its latency from when it was due, else from now."""
        kind, flow = self._workload.draw()
        begin = self._now() if due is None else due
        error: str | None = None
        try:
            await self._client.run(flow)
        except GeodesicError as refused:
            error = refused.code
        except asyncio.CancelledError:
            self._records.add(kind, self._now() - begin, "unfinished", self._now())
            raise
        now = self._now()
        self._records.add(kind, now - begin, error, now)

    async def closed(self) -> None:
        clients = self._settings.clients or 1

        async def loop(number: int) -> None:
            await self._pause_until(self._settings.ramp * number / clients)
            while not self._stop.is_set() and self._now() < self._settings.seconds:
                await self._one(None)

        await self._finish({asyncio.create_task(loop(number)) for number in range(clients)})

    async def open(self) -> None:
        tasks: set[asyncio.Task[None]] = set()
        for due in due_times(self._settings):
            await self._pause_until(due)
            if self._stop.is_set():
                break
            self._records.lag.add(max(0.0, self._now() - due))
            task = asyncio.create_task(self._one(due))
            tasks.add(task)
            task.add_done_callback(tasks.discard)
            # Also when it is behind, the loop has to come round to read replies.
            await asyncio.sleep(0)
        await self._finish(tasks)

    async def _finish(self, tasks: set[asyncio.Task[None]]) -> None:
        left = set(tasks)
        end = self._settings.seconds + self._settings.grace
        while left and self._now() < end:
            _, left = await asyncio.wait(left, timeout=min(0.5, max(0.0, end - self._now())))
            if self._stop.is_set():
                end = min(end, self._now() + 1)
        for task in left:
            task.cancel()
        for outcome in await asyncio.gather(*tasks, *left, return_exceptions=True):
            if isinstance(outcome, Exception):  # a fault of this program is not the server's
                raise outcome
