"""How the client talks to the server, without a socket. A flow is a generator: it yields steps
(send this request, wait so long, watch this stream) and returns what the caller wants. The
synchronous and the asynchronous client only carry out steps, so retries, jobs and their
cancelling are written once, here."""

from __future__ import annotations

import contextlib
import json
import random
import struct
from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, TypeAlias, TypeVar

from .errors import (
    ConnectionFailed,
    JobCancelled,
    NotFound,
    Overloaded,
    error_of,
    not_understood,
)
from .mesh_input import UploadBody
from .remarks import remark, remarks_in
from .wire import Reply

T = TypeVar("T")
Progress: TypeAlias = Callable[[float], None]


@dataclass(frozen=True)
class Request:
    """One request. ``idempotent``: sending it twice does no more than sending it once, as with
    all queries, also those by POST."""

    method: str
    target: str
    headers: dict[str, str] = field(default_factory=dict)
    body: bytes | UploadBody | None = None
    idempotent: bool = True


@dataclass(frozen=True)
class Send:
    """The step: send this and gather the reply. Its outcome is a :class:`~.wire.Reply`,
    whatever its status; ConnectionFailed is raised where there is none."""

    request: Request


@dataclass(frozen=True)
class Sleep:
    """The step: wait."""

    seconds: float


@dataclass(frozen=True)
class Watch:
    """The step: read a stream of server-sent events to its end, a line at a time."""

    request: Request
    on_line: Callable[[str], None]


@dataclass(frozen=True)
class Stream:
    """The step: send this, hand on the reply's status and headers, and the body as it comes. Raises
    what the reply says, where that is an error, and ConnectionFailed where the body breaks off. It
    is not sent again: what has come already, only the flow knows."""

    request: Request
    on_head: Callable[[int, Mapping[str, str]], None]
    on_bytes: Callable[[bytes], None]


@dataclass(frozen=True)
class AskRules:
    """The step: tell when the client asks again. Its outcome is :class:`Retries`."""


Step: TypeAlias = Send | Sleep | Watch | Stream  # what a client carries out
Steps: TypeAlias = Generator[Step, Any, T]
Flow: TypeAlias = Generator[Step | AskRules, Any, T]


@dataclass(frozen=True)
class Retries:
    """When to ask again: on 429 and 503 after the time that the server names (else after twice
    as long each time, with some chance), and when no reply came to an idempotent request.

    Attributes:
        attempts: how often to send a request at most; 1: never again.
        first_pause: seconds before the second attempt, unless the server says.
        longest_pause: seconds; if the server names a longer time, its error is raised at once.
    """

    attempts: int = 5
    first_pause: float = 0.2
    longest_pause: float = 30.0

    def pause(self, attempt: int, retry_after: float | None) -> float | None:
        """Seconds to wait after this attempt (counted from 1), or None: give up."""
        if attempt >= self.attempts:
            return None
        if retry_after is not None:
            if retry_after > self.longest_pause:
                return None
            # Clients that were turned away together should not come back together.
            return float(retry_after) + random.uniform(0, 0.1)
        pause = min(self.longest_pause, self.first_pause * 2.0 ** (attempt - 1))
        return pause * random.uniform(0.5, 1)


def _sent(request: Request, retries: Retries) -> Steps[Reply]:
    """Sends until there is a reply that is no error, or no hope."""
    attempt = 0
    while True:
        attempt += 1
        try:
            reply: Reply = yield Send(request)
        except ConnectionFailed as failure:
            # A silence was an answer that took too long: asking again would only double it.
            vain = failure.timeout or failure.lasting
            again = not vain and (request.idempotent or not failure.sent)
            pause = retries.pause(attempt, None) if again else None
            if pause is None:
                raise
        else:
            if reply.status < 300 or reply.status == 304:
                return reply
            error = error_of(reply.status, reply.headers, reply.body)
            again = isinstance(error, Overloaded)
            pause = retries.pause(attempt, error.retry_after) if again else None
            if pause is None:
                raise error
        yield Sleep(pause)


def with_retries(flow: Flow[T], retries: Retries) -> Steps[T]:
    """The flow, with each of its requests sent again as ``retries`` say, and replies that are
    errors raised in it as exceptions. One that streams is told the ``retries``."""
    try:
        step = next(flow)
        while True:
            try:
                if isinstance(step, Send):
                    outcome: Any = yield from _sent(step.request, retries)
                elif isinstance(step, AskRules):
                    outcome = retries
                else:
                    outcome = yield step
            except BaseException as error:
                # KeyboardInterrupt too: the flow may have a job to cancel.
                step = flow.throw(error)
            else:
                step = flow.send(outcome)
    except StopIteration as end:
        value: T = end.value
        return value
    finally:
        flow.close()


def ask(
    request: Request, decode: Callable[[Reply], T], progress: Progress | None = None
) -> Flow[T]:
    """Sends a request and decodes its reply, warning of what the server remarks on it. With
    ``progress``, the server makes it a job."""
    if progress is None:
        reply = yield Send(request)
    else:
        reply = yield from _as_job(request, progress)
    remark(remarks_in(reply.headers))
    try:
        return decode(reply)
    except (ValueError, LookupError, TypeError, struct.error) as error:
        raise not_understood(reply.status, error) from None


def part_of(progress: Progress | None, base: float, part: float) -> Progress | None:
    """The progress of one request of several: from ``base`` on, ``part`` of the whole."""
    return None if progress is None else lambda done: progress(base + part * done)


def _as_job(request: Request, progress: Progress) -> Flow[Reply]:
    """Has a request answered as a job, telling its progress from 0 to 1. Whatever ends this
    early, be it Ctrl-C, cancels the job."""
    begin = replace(
        request, headers={**request.headers, "Prefer": "respond-async"}, idempotent=False
    )
    accepted: Reply = yield Send(begin)
    if accepted.status != 202:  # a server that has the answer already need not make it a job
        progress(1.0)
        return accepted
    # Not by its Location: with --base-path that begins with what the client's URL may end with.
    try:
        where = f"/v1/jobs/{accepted.json()['id']}"
    except (ValueError, LookupError, TypeError) as error:
        raise not_understood(accepted.status, error) from None
    try:
        progress(0.0)
        yield from _watched(where, progress)
        # Of a job that was cancelled this raises JobCancelled, with the server's reason.
        result = yield from _result(where)
    except BaseException:
        # Also a job that is done is forgotten, so that it takes no room; and what ends this
        # is not to be hidden by a server that is gone.
        with contextlib.suppress(Exception):
            yield Send(Request("DELETE", where))
        raise
    with contextlib.suppress(Exception):
        yield Send(Request("DELETE", where))
    progress(1.0)
    return result


def _result(where: str) -> Flow[Reply]:
    """The reply that a job has come to."""
    try:
        reply: Reply = yield Send(Request("GET", f"{where}/result"))
    except NotFound as error:
        if error.code != "job_unknown":  # the query's own answer
            raise
        raise _forgotten() from None
    return reply


def _forgotten() -> JobCancelled:
    return JobCancelled(404, "job_unknown", "the job is not there any more")


def _watched(where: str, progress: Progress) -> Flow[None]:
    """Follows a job's events to its end."""
    while True:
        events = EventReader()
        job: dict[str, Any] = {}

        def on_line(line: str, events: EventReader = events, job: dict[str, Any] = job) -> None:
            if data := events.feed(line):
                job.update(json.loads(data))
                progress(float(job["progress"]))

        with contextlib.suppress(ConnectionFailed, Overloaded):
            yield Watch(Request("GET", f"{where}/events"), on_line)
        if job.get("state") in ("done", "failed", "cancelled"):
            return
        # The stream was cut, by a proxy perhaps. Asking says whether the job is still there.
        try:
            reply: Reply = yield Send(Request("GET", where))
        except NotFound:
            raise _forgotten() from None
        now: dict[str, Any] = reply.json()
        if now["state"] in ("done", "failed", "cancelled"):
            return
        yield Sleep(0.5)


class EventReader:
    """Server-sent events from their lines (the rules of the HTML standard)."""

    def __init__(self) -> None:
        self._data: list[str] = []

    def feed(self, line: str) -> str | None:
        """Takes a line without its end; an event's data once it is complete."""
        if line:
            name, _, value = line.partition(":")
            if name == "data":
                self._data.append(value.removeprefix(" "))
            return None
        data, self._data = "\n".join(self._data), []
        return data or None
