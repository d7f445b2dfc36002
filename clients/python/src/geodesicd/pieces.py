"""Questions about more points than the server takes at once: as several requests, one after the
other."""

from __future__ import annotations

import json
import re
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple, TypeVar

from . import service
from .errors import DeadlineExceeded, GeodesicError
from .flows import Flow, Progress, part_of
from .points import Point

T = TypeVar("T")

# What servers take that do not say otherwise: up to here none is asked for its limits.
LIMITS = {
    "max_sources": 1000,
    "max_points": 100_000,
    "max_curve_points": 1000,
    "max_table_entries": 1_000_000,
    "max_streamed_entries": 1_000_000_000,
    "max_line_entries": 10_000_000,
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


class Size(NamedTuple):
    """What points, lines and faces take of what a request may have."""

    number: int  # of them
    bytes: int  # in its body
    lines: int = 0  # how many are no points
    curve_points: int = 0  # of the curves among them

    def plus(self, other: Size) -> Size:
        """Both together."""
        return Size(*map(int.__add__, self, other))

    def fits(self, most: Size) -> bool:
        """Whether it is no more of anything."""
        return all(map(int.__le__, self, most))


def sizes_of(points: Sequence[Point]) -> list[Size]:
    """The size of each."""
    return [_size_of(point.json()) for point in points]


def total(points: Sequence[Point]) -> Size:
    """The size of all."""
    return Size(*map(sum, zip(*sizes_of(points), strict=True))) if points else Size(0, 0)


def _size_of(asked: Any) -> Size:
    """Of what stands in a body, a text of the URL grammar or an object."""
    written = len(json.dumps(asked)) + 1
    if isinstance(asked, str):
        kind, _, corners = asked.partition(":")
        if kind in ("v", "f", "p", "ray"):
            return Size(1, written)
        of_curve = corners.removeprefix("closed;").count(";") + 1 if kind == "curve" else 0
        return Size(1, written, 1, of_curve)
    if not _POINTS.isdisjoint(asked):
        return Size(1, written)
    curve = asked.get("curve")
    return Size(1, written, 1, len(curve.get("points", ())) if isinstance(curve, Mapping) else 0)


_POINTS = {"vertex", "face", "xyz", "ray"}  # the names by which objects are points
NO_LIMIT = 1 << 62


def cuts(sizes: Sequence[Size], most: Size) -> Iterator[slice]:
    """Consecutive slices of at most that size together, though at least of one."""
    begin, taken = 0, Size(0, 0)
    for number, size in enumerate(sizes):
        both = taken.plus(size)
        if number > begin and not both.fits(most):
            yield slice(begin, number)
            begin, both = number, size
        taken = both
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
    sizes = sizes_of(points)
    runs = list(cuts(sizes, _most_points(LIMITS)))
    if len(runs) > 1:
        runs = list(cuts(sizes, _most_points((yield from told_limits()))))
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


def _most_points(limits: Mapping[str, int]) -> Size:
    return Size(limits["max_points"], body_limit(limits), NO_LIMIT, NO_LIMIT)
