"""Questions about more points than the server takes at once: as several requests, one after the
other."""

from __future__ import annotations

import json
import re
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TypeVar

from . import service
from .errors import DeadlineExceeded, GeodesicError
from .flows import Flow, Progress, part_of
from .points import Point

T = TypeVar("T")

# What servers take that do not say otherwise: up to here none is asked for its limits.
LIMITS = {
    "max_sources": 1000,
    "max_points": 100_000,
    "max_table_entries": 1_000_000,
    "max_streamed_entries": 1_000_000_000,
    "max_json_bytes": 8 << 20,
}


def told_limits() -> Flow[dict[str, int]]:
    """What this server takes."""
    try:
        status = yield from service.status()
    except GeodesicError:  # a token may not allow to ask
        return LIMITS
    return {name: int(status["limits"].get(name, value)) for name, value in LIMITS.items()}


def body_limit(limits: Mapping[str, int]) -> int:
    """Bytes that the points of a request may take, with room for the rest of it."""
    return limits["max_json_bytes"] * 3 // 4


def sizes_of(points: Sequence[Point]) -> list[int]:
    """Bytes that each takes in a request's body."""
    return [len(json.dumps(point.json())) + 1 for point in points]


def cuts(sizes: list[int], most: int, room: int) -> Iterator[slice]:
    """Consecutive slices of at most so many points and bytes, though at least of one point."""
    begin = taken = 0
    for number, size in enumerate(sizes):
        if number > begin and (number - begin == most or taken + size > room):
            yield slice(begin, number)
            begin, taken = number, 0
        taken += size
    yield slice(begin, len(sizes))


def end_of(deadline: float | None) -> float | None:
    """When that many seconds from now are over, by time.monotonic(); None: never."""
    return None if deadline is None else time.monotonic() + deadline


def left(end: float | None) -> float | None:
    """Seconds up to then; None: no end.

    Raises:
        DeadlineExceeded: none are left.
    """
    if end is None:
        return None
    left = end - time.monotonic()
    if left <= 0:
        raise DeadlineExceeded(504, "deadline", "the time that deadline allowed is over")
    return left


def in_whole(parameter: str | None, starts: Mapping[str, int]) -> str | None:
    """``from[2]`` of a piece as it is called in the whole: each name with the first of its
    points."""
    found = re.fullmatch(r"(\w+)\[(\d+)\](.*)", parameter or "")
    if found is None or found[1] not in starts:
        return parameter
    return f"{found[1]}[{int(found[2]) + starts[found[1]]}]{found[3]}"


def in_pieces(
    points: list[Point],
    name: str,
    ask_for: Callable[[list[Point], float | None, Progress | None], Flow[T]],
    deadline: float | None,
    progress: Progress | None,
) -> Flow[list[T]]:
    """The answers to a question about many points: one, where the server takes them all at once.
    ``ask_for`` asks about some of them, in so many seconds; ``name`` is what the contract calls
    them."""
    limits, sizes = LIMITS, sizes_of(points)
    if len(points) > limits["max_points"] or sum(sizes) > body_limit(limits):
        limits = yield from told_limits()
    runs = list(cuts(sizes, limits["max_points"], body_limit(limits)))
    if len(runs) == 1:
        return [(yield from ask_for(points, deadline, progress))]
    end = end_of(deadline)
    found = []
    for run in runs:
        part = part_of(progress, run.start / len(points), (run.stop - run.start) / len(points))
        try:
            found.append((yield from ask_for(points[run], left(end), part)))
        except GeodesicError as error:
            error.parameter = in_whole(error.parameter, {name: run.start})
            raise
    return found
