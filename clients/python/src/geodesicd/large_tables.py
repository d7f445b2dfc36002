"""Tables of thousands: rows that are written to a file as they come, and go on where they broke
off; and tables of which only what is near is kept."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, Unpack

import numpy as np
from numpy.typing import DTypeLike

from . import hints, pieces, wire
from .encoding import as_bound, encode, format_of, milliseconds
from .errors import ConnectionFailed, GeodesicError, Overloaded
from .flows import AskRules, Flow, Progress, Retries, Sleep, Stream, ask, part_of
from .growing_file import GrowingFile
from .options import CostOptions, asked_by, spelled_out
from .points import Point, PointsLike, points_of
from .results import FloatArray, SparseTable


@spelled_out
def table_file(
    mesh: str,
    file: str | os.PathLike[str],
    sources: PointsLike,
    targets: PointsLike | None = None,
    *,
    resume: bool = True,
    max: float | None = None,
    landmarks: int | None = None,
    estimated: Callable[[dict[str, float]], None] | None = None,
    dtype: DTypeLike = np.float64,
    **options: Unpack[CostOptions],
) -> Flow[FloatArray]:
    """Distances from each of several points to each of several others (without ``targets``: to
    each of the same), written to a .npy file row by row as they are computed: a table that need
    not fit into memory. When the connection breaks, it goes on with the row that is missing: as
    often in a row as the client's ``retries`` say, until a row comes. When this fails or is
    interrupted, the same call goes on with what the file has; how far that is stands beside it, in
    ``<file>.part``, until it is whole. Rows that are not there yet are NaN.

    Args:
        file: where to; another file there is replaced once the first row has come, unless it is a
            part of this table. A request that is refused leaves it as it is.
        sources: points, and curves, boundaries and faces, one a row. targets: the same, one a
            column; the distance of a line is the least of all of it.
        resume: whether to go on with a part that is there.
        max: what is farther counts as unreached; mesh units. Fields end there.
        landmarks: from how many of the columns, from 8 to 300, whole fields are computed. What is
            far is estimated from these: many times as quick, and up to some percent off.
        estimated: called with what the server has found of that: ``mean``, ``percentile_99`` and
            ``max`` are errors of ``entries`` distances, as parts of these; others may be further
            off.
        dtype: float64 or float32, which is half to send and to keep.
        deadline: seconds for the whole.
        progress: called with the part of the rows that is written, from 0 to 1.

    Returns:
        (sources, targets) distances, infinite where unreached: the file, mapped into memory.
    """
    rows, columns = _sides(sources, targets)
    deadline, progress = options.pop("deadline", None), options.get("progress")
    parameters = {
        "max": as_bound(max),
        "landmarks": landmarks,
        **asked_by(**options),
        "format": format_of(dtype),
        "stream": True,
    }
    end = pieces.end_of(deadline)  # each request has a deadline of its own, what is left then
    part = GrowingFile(Path(file), mesh, {"from": rows, "to": columns, **parameters}, dtype, resume)
    if progress is not None:
        progress(part.rows / len(rows))
    try:
        yield from _receive(mesh, part, rows, columns, parameters, end, progress, estimated)
    finally:
        part.note()
    return part.finished()


def _receive(
    mesh: str,
    part: GrowingFile,
    rows: list[Point],
    columns: list[Point],
    parameters: dict[str, Any],
    end: float | None,
    progress: Progress | None,
    estimated: Callable[[dict[str, float]], None] | None,
) -> Flow[None]:
    """Asks for what is missing until nothing is."""
    retries: Retries = yield AskRules()
    attempt = 0

    def take(data: bytes) -> None:
        part.write(data)
        if progress is not None:
            progress(part.rows / len(rows))

    runs = _runs(rows, columns, pieces.LIMITS)
    if len(runs) > 1:
        runs = _runs(rows, columns, (yield from pieces.told_limits()))
    for run in runs:
        while part.rows < run.stop:
            before = part.rows
            asked = {"from": rows[run], "to": columns, "rows": f"{before - run.start}-"}
            left = milliseconds(pieces.left(end))
            request = encode(mesh, "table", {**asked, **parameters, "deadline_ms": left})
            expected = {
                "Geo-Dtype": "<f4" if parameters["format"] == "f32" else "<f8",
                "Geo-Shape": f"{run.stop - before},{len(columns)}",
            }
            part.begin_again()
            failed: GeodesicError | None = None
            try:
                yield Stream(request, partial(_take_head, expected, estimated), take)
            except (ConnectionFailed, Overloaded) as error:
                vain = isinstance(error, ConnectionFailed) and (error.lasting or error.timeout)
                if vain:
                    raise
                failed = error
            except GeodesicError as error:
                error.parameter = pieces.in_whole(error.parameter, {"from": run.start})
                raise
            if part.rows == run.stop:
                break
            # Who got some rows may hope for more.
            attempt = 1 if part.rows > before else attempt + 1
            pause = retries.pause(attempt, getattr(failed, "retry_after", None))
            if pause is None:
                raise failed or ConnectionFailed("the rows ended before the table did", sent=True)
            yield Sleep(pause)


def _take_head(
    expected: Mapping[str, str],
    estimated: Callable[[dict[str, float]], None] | None,
    status: int,
    headers: Mapping[str, str],
) -> None:
    """Looks at what comes before the rows.

    Raises:
        ConnectionFailed: these are none of that kind and number, such as the page of somebody on
            the way, who may be gone when they are asked for again.
    """
    found = {name: headers.get(name) for name in expected}
    if status != 200 or found != expected:
        told = " and ".join(f"{name} {value}" for name, value in found.items())
        wanted = " and ".join(expected.values())
        raise ConnectionFailed(
            f"the reply has status {status}, {told}, and is not the rows of {wanted}",
            sent=True,
            hint=hints.OF_OTHERS,
        )
    if estimated is not None and "Geo-Estimated" in headers:
        estimated(json.loads(headers["Geo-Estimated"]))


def _runs(rows: list[Point], columns: list[Point], limits: Mapping[str, int]) -> list[slice]:
    """Rows of each request, which has all columns."""
    of_columns = pieces.total(columns)
    count = min(limits["max_points"], max(1, limits["max_streamed_entries"] // len(columns)))
    if of_columns.lines > 0:
        count = min(count, max(1, limits["max_line_entries"] // of_columns.lines))
    room = pieces.body_limit(limits) - of_columns.bytes
    most = pieces.Size(count, room, count, limits["max_curve_points"])
    return list(pieces.cuts(pieces.sizes_of(rows), most))


@spelled_out
def sparse_table(
    mesh: str,
    sources: PointsLike,
    targets: PointsLike | None = None,
    *,
    max: float | None = None,
    **options: Unpack[CostOptions],
) -> Flow[SparseTable]:
    """The distances from each of several points to those of several others (without ``targets``:
    of the same) that are within ``max``. Fields end there, so that near ones are quick. Where the
    server has too much for one reply, it is asked for fewer rows at once.

    Args:
        sources: points, and curves, boundaries and faces, one a row. targets: the same, one a
            column; the distance of a line is the least of all of it.
        max: the greatest distance that is wanted, mesh units.
        deadline: seconds for the whole.
        progress: called with the part that is done, from 0 to 1.
    """
    rows, columns = _sides(sources, targets)
    deadline, progress = options.pop("deadline", None), options.get("progress")
    parameters = {
        "max": as_bound(max),
        **asked_by(**options),
        "sparse": True,
        "format": "frame",
    }
    end = pieces.end_of(deadline)  # each request has a deadline of its own, what is left then
    found: list[SparseTable] = []
    begin, step = 0, len(rows)
    while begin < len(rows):
        some = rows[begin : begin + step]
        left = milliseconds(pieces.left(end))
        asked = {"from": some, "to": columns, **parameters, "deadline_ms": left}
        own = part_of(progress, begin / len(rows), len(some) / len(rows))
        try:
            found.append((yield from ask(encode(mesh, "table", asked), wire.sparse_of_frame, own)))
        except GeodesicError as error:
            too_large = error.code == "too_large" and error.parameter in ("max", "to", "from")
            if too_large and len(some) > 1:
                step = -(-len(some) // 2)
                continue
            error.parameter = pieces.in_whole(error.parameter, {"from": begin})
            raise
        begin += len(some)
    return SparseTable.joined(found)


def _sides(sources: PointsLike, targets: PointsLike | None) -> tuple[list[Point], list[Point]]:
    """A table's rows and columns."""
    rows = points_of(sources)
    columns = rows if targets is None else points_of(targets)
    if not rows or not columns:
        raise ValueError("a table has at least one row and one column")
    return rows, columns
