"""Tables of any size: what the server's limits do not let into one request is asked for in
blocks, and put together here."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Unpack

import numpy as np
from numpy.typing import DTypeLike

from . import pieces, wire
from .encoding import as_bound, encode, format_of, milliseconds
from .errors import GeodesicError
from .flows import Flow, ask, part_of
from .options import CostOptions, asked_by, spelled_out
from .points import Point, PointsLike, points_of
from .results import FloatArray


@spelled_out
def table(
    mesh: str,
    sources: PointsLike,
    targets: PointsLike | None = None,
    *,
    max: float | None = None,
    dtype: DTypeLike = np.float64,
    **options: Unpack[CostOptions],
) -> Flow[FloatArray]:
    """Distances from each of several points to each of several others (without ``targets``: to
    each of the same). A table of any size that fits into memory here: one that is over the
    server's limits is several requests, one after the other.

    Args:
        sources: points, and curves, boundaries and faces, one a row. targets: the same, one a
            column; the distance of a line is the least of all of it.
        max: what is farther counts as unreached; mesh units.
        dtype: float64 or float32, which is half to send and to keep.
        deadline: seconds for the whole.
        progress: called with the part that is done, from 0 to 1.

    Returns:
        (sources, targets) distances, infinite where unreached.
    """
    rows = points_of(sources)
    columns = rows if targets is None else points_of(targets)
    progress = options.get("progress")
    parameters = {
        "max": as_bound(max),
        **asked_by(**options),
        "format": format_of(dtype),
    }
    limits = pieces.LIMITS
    if not _fits(rows, columns, limits):
        limits = yield from pieces.told_limits()
    if not rows or not columns or _fits(rows, columns, limits):
        asked = {"from": rows, "to": None if targets is None else columns, **parameters}
        return (yield from ask(encode(mesh, "table", asked), wire.array, progress))
    found = np.empty((len(rows), len(columns)), dtype=np.dtype(dtype))
    end = pieces.end_of(options.get("deadline"))
    done = 0
    for row, column in _blocks(rows, columns, limits):
        left = milliseconds(pieces.left(end))
        asked = {"from": rows[row], "to": columns[column], **parameters, "deadline_ms": left}
        size = found[row, column].size
        part = part_of(progress, done / found.size, size / found.size)
        try:
            found[row, column] = yield from ask(encode(mesh, "table", asked), wire.array, part)
        except GeodesicError as error:
            error.parameter = pieces.in_whole(
                error.parameter, {"from": row.start, "to": column.start}
            )
            raise
        done += size
    return found


def _fits(rows: list[Point], columns: list[Point], limits: Mapping[str, int]) -> bool:
    of_rows, of_columns = pieces.total(rows), pieces.total(columns)
    return (
        of_rows.fits(_most_rows(limits, pieces.NO_LIMIT))
        and of_columns.fits(_most_columns(limits, pieces.NO_LIMIT))
        and of_rows.number * of_columns.number <= limits["max_table_entries"]
        and of_rows.bytes + of_columns.bytes <= pieces.body_limit(limits)
    )


def _most_rows(limits: Mapping[str, int], room: int) -> pieces.Size:
    """Of one request."""
    most = limits["max_sources"]
    return pieces.Size(most, room, most, limits["max_curve_points"])


def _most_columns(limits: Mapping[str, int], room: int) -> pieces.Size:
    """Of one request. A column that is a line takes a field, as a row does."""
    most = min(limits["max_points"], limits["max_table_entries"])
    return pieces.Size(most, room, limits["max_sources"], limits["max_curve_points"])


def _blocks(
    rows: list[Point], columns: list[Point], limits: Mapping[str, int]
) -> Iterator[tuple[slice, slice]]:
    """Rows and columns of each request. Blocks are as wide as can be, and those of the same rows
    follow each other: each row costs a field, which the server may still have then."""
    room = pieces.body_limit(limits) // 2
    widths = list(pieces.cuts(pieces.sizes_of(columns), _most_columns(limits, room)))
    widest = max(width.stop - width.start for width in widths)
    most = _most_rows(limits, room)
    most = most._replace(number=min(most.number, max(1, limits["max_table_entries"] // widest)))
    for row in pieces.cuts(pieces.sizes_of(rows), most):
        for column in widths:
            yield row, column
