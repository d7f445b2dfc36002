"""What can go wrong: every refusal of the server as an exception that carries all that
the server said, and subclasses for what a program handles differently."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from . import hints


def printable(text: str) -> str:
    """A text from outside without what would steer a terminal."""
    return "".join(letter if letter.isprintable() else "?" for letter in text)


class Misuse(ValueError):
    """A command was asked wrongly, as its help tells."""


class GeodesicError(Exception):
    """A request that did not get what it asked for.

    Attributes:
        status: the HTTP status; 0 if no reply came.
        code: one of the server's closed set of codes, such as ``"mesh_unknown"``.
        detail: one sentence for a person.
        parameter: the offending parameter, such as ``"from[2]"``, or None.
        limit: the bound that was exceeded, or None.
        actual: by what it was exceeded, or None.
        request_id: finds the request in the server's log; None if no reply came.
        retry_after: seconds after which the server wants to be asked again, or None.
        server: host and port of who was asked, or None.
        hint: what to do next, or None.
    """

    def __init__(
        self,
        status: int,
        code: str,
        detail: str,
        *,
        parameter: str | None = None,
        limit: int | None = None,
        actual: int | None = None,
        request_id: str | None = None,
        retry_after: float | None = None,
    ) -> None:
        self.status = status
        self.code = code
        self.detail = detail
        self.parameter = parameter
        self.limit = limit
        self.actual = actual
        self.request_id = request_id
        self.retry_after = retry_after
        self.server: str | None = None
        super().__init__(self._sentence(self.hint))

    @property
    def hint(self) -> str | None:
        """What to do next."""
        return hints.of_error(self.status, self.code, self.detail, self.limit)

    def __str__(self) -> str:
        return self._sentence(self.hint)

    def in_shell(self) -> str:
        """The same for who asks from a shell: the hint names no Python."""
        return self._sentence(None if self.hint is None else hints.in_shell(self.hint))

    def _sentence(self, hint: str | None) -> str:
        text = f"{self.code}: {self.detail}".rstrip(".")
        notes = []
        if self.parameter is not None:
            notes.append(f"parameter {self.parameter}")
        if self.limit is not None:
            notes.append(f"limit {self.limit}")
        if self.actual is not None:
            notes.append(f"actual {self.actual}")
        if self.request_id is not None:
            notes.append(f"request {self.request_id}")
        if self.server is not None and self.server not in self.detail:
            notes.append(f"server {self.server}")
        if notes:
            text += f" ({', '.join(notes)})"
        if hint is not None:
            text += f". {hint}{'' if hint.endswith('?') else '.'}"
        return printable(text)

    def __reduce__(self) -> tuple[Any, ...]:
        # Exceptions cross process pools by pickle, which would call __init__ with the sentence.
        return (type(self)._rebuilt, (dict(self.__dict__),))

    @classmethod
    def _rebuilt(cls, fields: dict[str, Any]) -> GeodesicError:
        error = cls.__new__(cls)
        error.__dict__.update(fields)
        error.args = (error._sentence(error.hint),)
        return error


class GeodesicWarning(UserWarning):
    """An answer that may not be what was meant, such as of a point far from the surface."""


class PrecisionWarning(GeodesicWarning):
    """The positions of an upload are too coarse for its edges, so distances are wrong."""


class NotFound(GeodesicError):
    """404: no such mesh, job or route."""


class NotAllowed(GeodesicError):
    """401 or 403: no valid token, or one without the scope that this needs."""


class Overloaded(GeodesicError):
    """429 or 503, still after all retries: too much to do, or about to stop."""


class DeadlineExceeded(GeodesicError):
    """504: the time that ``deadline`` allowed was over."""


class JobCancelled(GeodesicError):
    """The job whose result was awaited was cancelled, here or by someone else."""


class ConnectionFailed(GeodesicError):
    """No reply: the server is not there, hung up, or was silent for too long.

    ``sent`` tells whether the request may have reached it, ``timeout`` whether it was silent for
    too long, and ``lasting`` whether it would fail alike if it were asked again.
    """

    def __init__(
        self,
        detail: str,
        *,
        sent: bool,
        timeout: bool = False,
        lasting: bool = False,
        hint: str | None = None,
    ) -> None:
        self.sent = sent
        self.timeout = timeout
        self.lasting = lasting
        self._hint = hint
        super().__init__(0, "connection_failed", detail)

    @property
    def hint(self) -> str | None:
        """What to do next."""
        return self._hint


def error_of(status: int, headers: Mapping[str, str], body: bytes | bytearray) -> GeodesicError:
    """The exception for an error reply, be it a problem document or, from something between,
    any other body."""
    problem: dict[str, Any] = {}
    if headers.get("content-type", "").startswith("application/problem+json"):
        try:
            decoded = json.loads(body)
        except ValueError:
            decoded = None
        if isinstance(decoded, dict):
            problem = decoded
    return error_of_problem(
        {"status": status, "request_id": headers.get("x-request-id"), **problem},
        retry_after=seconds_of(headers.get("retry-after")),
        location=headers.get("location"),
    )


def error_of_problem(
    problem: Mapping[str, Any], *, retry_after: float | None = None, location: str | None = None
) -> GeodesicError:
    """The exception for a problem document, such as a batch has for a line."""
    status = int(problem.get("status", 0))
    code = str(problem.get("code") or f"http_{status}")
    kind = GeodesicError
    if code == "job_cancelled":
        kind = JobCancelled
    elif status == 404:
        kind = NotFound
    elif status in (401, 403):
        kind = NotAllowed
    elif status in (429, 503):
        kind = Overloaded
    elif status == 504:
        kind = DeadlineExceeded
    return kind(
        status,
        code,
        str(problem.get("detail") or problem.get("title") or _bare(status, location)),
        parameter=problem.get("parameter"),
        limit=problem.get("limit"),
        actual=problem.get("actual"),
        request_id=problem.get("request_id"),
        retry_after=retry_after,
    )


def _bare(status: int, location: str | None) -> str:
    """What can be told of a reply without a problem document."""
    where = f" and sends to {location}" if location and 300 <= status < 400 else ""
    return f"the reply has status {status}{where}"


def not_understood(status: int, error: Exception) -> GeodesicError:
    """The exception for a reply that should be an answer, and is none."""
    detail = f"the reply is not what was asked for ({type(error).__name__}: {error})"
    return GeodesicError(status, f"http_{status}", detail)


def refusal(error: GeodesicError, where: str) -> GeodesicError:
    """The same error, of one line of a batch: ``parameter`` tells which."""
    parameter = where if error.parameter is None else f"{where}.{error.parameter}"
    told = type(error)(
        error.status,
        error.code,
        error.detail,
        parameter=parameter,
        limit=error.limit,
        actual=error.actual,
        request_id=error.request_id,
    )
    told.server = error.server
    return told


def seconds_of(retry_after: str | None) -> float | None:
    """A Retry-After header in seconds: it is a number or, from a proxy, a date."""
    if retry_after is None:
        return None
    try:
        return max(0.0, float(retry_after))
    except ValueError:
        pass
    from datetime import UTC, datetime
    from email.utils import parsedate_to_datetime

    try:
        date = parsedate_to_datetime(retry_after)
    except ValueError:
        return None
    if date.tzinfo is None:
        date = date.replace(tzinfo=UTC)
    return max(0.0, (date - datetime.now(UTC)).total_seconds())
