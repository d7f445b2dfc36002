"""Many queries in one request: a line of JSON each, answered in their order, each with a
status of its own."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Unpack

from . import pieces, wire
from .encoding import as_points, body_json, milliseconds
from .errors import DeadlineExceeded, error_of_problem, refusal
from .flows import Flow, Progress, Request, ask, part_of
from .masks import check_masks
from .options import CostOptions, asked_by, spelled_out
from .points import PointLike
from .queries import Refine
from .remarks import remark
from .results import BatchReply, Path
from .wire import Reply

# Well below the server's own limit on a body (8 MiB unless it is set otherwise).
_LARGEST = 4 << 20


def batch(
    mesh: str, queries: Iterable[Mapping[str, Any]], *, progress: Progress | None = None
) -> Flow[list[BatchReply]]:
    """Many queries in one request, over one connection.

    Args:
        queries: each a mapping with ``"query"`` (``"distance"``, ``"path"``, ``"table"``,
            ``"isolines"``, ``"samples"``, ``"measure"``, ``"extent"``, ``"voronoi"``,
            ``"trace"``, ``"loop"``, ``"logmap"`` or ``"nearest"``) and that query's parameters as
            a JSON body has them; points may be as everywhere here.

    Returns:
        One reply a query, in their order: the query's JSON or its error. One that fails
        harms no other.
    """
    replies = yield from _replies(mesh, queries, progress)
    remark(_remarks(replies, "queries"))
    return replies


def _replies(
    mesh: str,
    queries: Iterable[Mapping[str, Any]],
    progress: Progress | None,
    deadline: float | None = None,
) -> Flow[list[BatchReply]]:
    """The replies to all of them. When the time is over, DeadlineExceeded is raised, or is the last
    reply, in place of those to the rest."""
    lines = [
        json.dumps(_line(mesh, query), allow_nan=False, separators=(",", ":")).encode() + b"\n"
        for query in queries
    ]
    replies: list[BatchReply] = []
    end = pieces.end_of(deadline)
    for body in _bodies(lines):
        # Several requests only where one would be larger than the server takes.
        base, part = len(replies) / max(1, len(lines)), body.count(b"\n") / max(1, len(lines))
        left = milliseconds(pieces.left(end))
        request = Request(
            "POST",
            f"/v1/meshes/{mesh}/batch" + ("" if left is None else f"?deadline_ms={left}"),
            {"Content-Type": "application/x-ndjson", "Accept": "application/x-ndjson"},
            body,
        )
        replies += yield from ask(request, _decode, part_of(progress, base, part))
    return replies


@spelled_out
def paths(
    mesh: str,
    pairs: Iterable[tuple[PointLike, PointLike]],
    *,
    refine: Refine | None = None,
    **options: Unpack[CostOptions],
) -> Flow[list[Path]]:
    """The shortest paths of many pairs (source, target) in one request. Pairs that share a
    source cost one field if they follow each other.

    Args:
        tolerance: for ``method="steiner"`` only, relative.
        deadline: seconds for the whole.

    Raises:
        GeodesicError: the first pair that the server refuses; ``parameter`` begins with
            ``pairs[i]``. DeadlineExceeded is about none of them.
    """
    deadline, progress = options.pop("deadline", None), options.get("progress")
    common = {"query": "path", "refine": refine, **asked_by(**options)}
    queries = [{**common, "from": source, "to": target} for source, target in pairs]
    answers = yield from _replies(mesh, queries, progress, deadline)
    remark(_remarks(answers, "pairs"))
    found = []
    for number, answer in enumerate(answers):
        if answer.reply is None:
            error = answer.error or error_of_problem({"status": answer.status})
            if isinstance(error, DeadlineExceeded):  # of the whole, and no fault of this pair's
                raise error
            raise refusal(error, f"pairs[{number}]")
        found.append(wire.path_of_json(answer.reply))
    return found


def _remarks(replies: Iterable[BatchReply], name: str) -> Iterator[str]:
    """What the server remarks on the lines, each with its line: ``pairs[3]: …``."""
    for number, answer in enumerate(replies):
        for sentence in (answer.reply or {}).get("warnings") or ():
            yield f"{name}[{number}]: {sentence}"


def _line(mesh: str, query: Mapping[str, Any]) -> dict[str, Any]:
    asked = as_points(query)
    check_masks(mesh, asked)
    return body_json(asked)


def _bodies(lines: list[bytes]) -> Iterator[bytes]:
    gathered: list[bytes] = []
    size = 0
    for line in lines:
        if gathered and size + len(line) > _LARGEST:
            yield b"".join(gathered)
            gathered, size = [], 0
        gathered.append(line)
        size += len(line)
    if gathered:
        yield b"".join(gathered)


def _decode(reply: Reply) -> list[BatchReply]:
    answers = []
    for line in reply.body.splitlines():
        answer = json.loads(line)
        problem = answer.get("problem")
        error = None if problem is None else error_of_problem(problem)
        answers.append(BatchReply(answer["status"], answer.get("reply"), error, answer.get("id")))
    return answers
