"""What can go wrong: every refusal of the server as an exception that carries all that
the server said, and subclasses for what a program handles differently."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

# What to do about a code, where the server's own sentence does not say it.
_HINTS = {
    "mesh_unknown": "Upload it, again if it was deleted; client.meshes() lists what is there",
    "unauthorized": "Give a token: Client(token=), --token or $GEODESICD_TOKEN",
    "forbidden": "Give a token with that scope: Client(token=), --token or $GEODESICD_TOKEN",
    "method_unknown": "client.methods() lists them",
    "too_large": "Asking again will not help: ask for less at once, or start the server with more",
    "too_many_vertices": "Simplify the mesh, or start the server with a larger --max-vertices",
    "too_many_faces": "Simplify the mesh, or start the server with a larger --max-faces",
    "too_much_memory": "Asking again will not help: give method='auto', a tolerance or a nearer "
    "max, or start the server with a larger --query-memory-bytes",
    "external_uri": "Upload the .gltf file by its path: the files that it names are sent with it",
    "store_full": "Asking again will not help: delete meshes, or start the server with a larger "
    "--store-max-bytes",
    "deadline": "Give a longer deadline=, or a method that is faster",
    "overloaded": "Ask later, or give Client more patience: retries=Retries(attempts=)",
    "too_many_requests": "Ask for less at a time, or later: retries=Retries(attempts=)",
    "draining": "The server is about to stop: ask again once it has been started",
}


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
        super().__init__(self._sentence())

    @property
    def hint(self) -> str | None:
        """What to do next."""
        if self.code.startswith("http_"):
            return "This is no reply of geodesicd's own: is that address one, and what is between?"
        return _HINTS.get(self.code)

    def __str__(self) -> str:
        return self._sentence()

    def _sentence(self) -> str:
        text = f"{self.code}: {self.detail}"
        notes = []
        if self.parameter is not None:
            notes.append(f"parameter {self.parameter}")
        if self.limit is not None:
            notes.append(f"limit {self.limit}")
        if self.actual is not None:
            notes.append(f"actual {self.actual}")
        if self.request_id is not None:
            notes.append(f"request {self.request_id}")
            if self.server is not None:
                notes.append(f"server {self.server}")
        if notes:
            text += f" ({', '.join(notes)})"
        return text if self.hint is None else f"{text}. {self.hint}."

    def __reduce__(self) -> tuple[Any, ...]:
        # Exceptions cross process pools by pickle, which would call __init__ with the sentence.
        return (type(self)._rebuilt, (dict(self.__dict__),))

    @classmethod
    def _rebuilt(cls, fields: dict[str, Any]) -> GeodesicError:
        error = cls.__new__(cls)
        error.__dict__.update(fields)
        error.args = (error._sentence(),)
        return error


class PrecisionWarning(UserWarning):
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

    ``sent`` tells whether the request may have reached it.
    """

    def __init__(
        self, detail: str, *, sent: bool, timeout: bool = False, hint: str | None = None
    ) -> None:
        self.sent = sent
        self.timeout = timeout
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
    )


def error_of_problem(
    problem: Mapping[str, Any], *, retry_after: float | None = None
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
        str(problem.get("detail") or problem.get("title") or f"the reply has status {status}"),
        parameter=problem.get("parameter"),
        limit=problem.get("limit"),
        actual=problem.get("actual"),
        request_id=problem.get("request_id"),
        retry_after=retry_after,
    )


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
