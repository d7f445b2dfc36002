"""Tables of any size: what the server's limits do not let into one request is asked for in
blocks, and put together here."""

from __future__ import annotations

import json
import re
import time
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import DTypeLike

from . import service, wire
from .encoding import as_bound, encode, format_of, milliseconds
from .errors import DeadlineExceeded, GeodesicError
from .flows import Flow, Progress, ask, part_of
from .points import Point, PointsLike, points_of
from .results import FloatArray

# What servers take that do not say otherwise: up to here none is asked for its limits.
_LIMITS = {
    "max_sources": 1000,
    "max_points": 100_000,
    "max_table_entries": 1_000_000,
    "max_json_bytes": 8 << 20,
}


def table(
    mesh: str,
    sources: PointsLike,
    targets: PointsLike | None = None,
    *,
    max: float | None = None,
    dtype: DTypeLike = np.float64,
    method: str | None = None,
    points_per_edge: int | None = None,
    bound: str | None = None,
    tolerance: float | None = None,
    deadline: float | None = None,
    progress: Progress | None = None,
) -> Flow[FloatArray]:
    """Distances from each of several points to each of several others (without ``targets``: to
    each of the same). A table of any size that fits into memory here: one that is over the
    server's limits is several requests, one after the other.

    Args:
        sources: points, one a row. targets: points, one a column.
        max: what is farther counts as unreached; mesh units.
        dtype: float64 or float32, which is half to send and to keep.
        deadline: seconds for the whole.
        progress: called with the part that is done, from 0 to 1.

    Returns:
        (sources, targets) distances, infinite where unreached.
    """
    rows = points_of(sources)
    columns = rows if targets is None else points_of(targets)
    parameters = {
        "max": as_bound(max),
        "method": method,
        "points_per_edge": points_per_edge,
        "bound": bound,
        "tolerance": tolerance,
        "deadline_ms": milliseconds(deadline),
        "format": format_of(dtype),
    }
    limits = _LIMITS
    if not _fits(rows, columns, limits):
        limits = yield from _told_limits()
    if not rows or not columns or _fits(rows, columns, limits):
        asked = {"from": rows, "to": None if targets is None else columns, **parameters}
        return (yield from ask(encode(mesh, "table", asked), wire.array, progress))
    found = np.empty((len(rows), len(columns)), dtype=np.dtype(dtype))
    end = None if deadline is None else time.monotonic() + deadline
    done = 0
    for row, column in _blocks(rows, columns, limits):
        if end is not None:
            parameters["deadline_ms"] = milliseconds(_left(end))
        asked = {"from": rows[row], "to": columns[column], **parameters}
        size = found[row, column].size
        part = part_of(progress, done / found.size, size / found.size)
        try:
            found[row, column] = yield from ask(encode(mesh, "table", asked), wire.array, part)
        except GeodesicError as error:
            error.parameter = _in_whole(error.parameter, row.start, column.start)
            raise
        done += size
    return found


def _told_limits() -> Flow[dict[str, int]]:
    try:
        status = yield from service.status()
    except GeodesicError:  # a token may not allow to ask
        return _LIMITS
    return {name: int(status["limits"].get(name, value)) for name, value in _LIMITS.items()}


def _body_limit(limits: Mapping[str, int]) -> int:
    return limits["max_json_bytes"] * 3 // 4


def _sizes(points: Sequence[Point]) -> list[int]:
    """Bytes that each takes in a request's body."""
    return [len(json.dumps(point.json())) + 1 for point in points]


def _fits(rows: list[Point], columns: list[Point], limits: Mapping[str, int]) -> bool:
    if (
        len(rows) > limits["max_sources"]
        or len(columns) > limits["max_points"]
        or len(rows) * len(columns) > limits["max_table_entries"]
    ):
        return False
    few = len(rows) + len(columns) < 2000  # far below the limit, whatever they are
    return few or sum(_sizes(rows)) + sum(_sizes(columns)) <= _body_limit(limits)


def _blocks(
    rows: list[Point], columns: list[Point], limits: Mapping[str, int]
) -> Iterator[tuple[slice, slice]]:
    """Rows and columns of each request. Blocks are as wide as can be, and those of the same rows
    follow each other: each row costs a field, which the server may still have then."""
    room = _body_limit(limits) // 2
    widths = list(
        _cuts(_sizes(columns), min(limits["max_points"], limits["max_table_entries"]), room)
    )
    widest = max(width.stop - width.start for width in widths)
    most = min(limits["max_sources"], max(1, limits["max_table_entries"] // widest))
    for row in _cuts(_sizes(rows), most, room):
        for column in widths:
            yield row, column


def _cuts(sizes: list[int], most: int, room: int) -> Iterator[slice]:
    """Consecutive slices of at most so many points and bytes, though at least of one point."""
    begin = taken = 0
    for number, size in enumerate(sizes):
        if number > begin and (number - begin == most or taken + size > room):
            yield slice(begin, number)
            begin, taken = number, 0
        taken += size
    yield slice(begin, len(sizes))


def _left(end: float) -> float:
    left = end - time.monotonic()
    if left <= 0:
        raise DeadlineExceeded(504, "deadline", "the time that deadline allowed is over")
    return left


def _in_whole(parameter: str | None, row: int, column: int) -> str | None:
    """``from[2]`` of a block as it is called in the whole."""
    found = re.fullmatch(r"(from|to)\[(\d+)\](.*)", parameter or "")
    if found is None:
        return parameter
    first = row if found[1] == "from" else column
    return f"{found[1]}[{int(found[2]) + first}]{found[3]}"
