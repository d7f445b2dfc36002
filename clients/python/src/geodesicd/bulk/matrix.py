"""A distance matrix of one mesh, a run of its rows at a time."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, cast

import numpy as np

from ..client import Mesh
from ..errors import GeodesicError
from ..flows import Progress
from ..points import PointsLike, Vertex, points_of
from ..remarks import kept_remarks
from ..service import Reading
from . import questions
from .cluster import Cluster, cluster, lasting, reason
from .mapping import absolute, digest_of
from .output import Output, output_at
from .questions import Columns
from .report import Answered, Report
from .servers import server_of_worker

_MOST_BYTES = 64 << 20  # of a run of rows
_MOST_ROWS = 64


def distance_matrix(
    mesh: str | os.PathLike[str],
    sources: PointsLike,
    out: str | os.PathLike[str],
    *,
    targets: PointsLike | Literal["vertices"] | None = None,
    client: Any = None,
    url: str | None = None,
    token: str | None = None,
    binary: str | os.PathLike[str] | None = None,
    flags: Sequence[str] = (),
    workers: int | None = None,
    retries: int = 3,
    reading: Reading | None = None,
    progress: Progress | None = None,
    **asked: Any,
) -> Report:
    """Distances from each of many sources, which nobody has to have in memory as a whole: each run
    of rows is written as it comes. Rows that are there already are not computed again.

    Args:
        mesh: a file, where the workers find it, too.
        sources: points, one a row.
        out: a folder ``….zarr``, with the array ``distance``, (sources, targets) float64, infinite
            where unreached, NaN where not computed; or ``….parquet``, with a row a number.
        targets: points, one a column; ``"vertices"``: all vertices; without it, the sources.
        asked: ``max``, ``method``, ``points_per_edge``, ``bound``, ``tolerance`` and ``deadline``,
            which is for a request, as of :meth:`geodesicd.Mesh.table`.

    Other arguments and what is raised are as of :func:`map_meshes`.
    """
    output = output_at(out, of_matrix=True)
    file, rows = os.fspath(mesh), _packed(sources)
    every = isinstance(targets, str) and targets == "vertices"
    columns = None if every else rows if targets is None else _packed(targets)
    if len(rows) == 0 or (columns is not None and len(columns) == 0):
        raise ValueError("a matrix has at least one source and one target")
    words = {
        **questions.checked("table", {"sources": rows, "targets": columns, **asked}),
        "question": "matrix",
        "mesh": digest_of(file),
        "targets": targets if every or targets is None else questions.plain_points(columns),
        **(reading or {}),
    }
    with (
        output.opened(words) as manifest,
        cluster(client, url, token, binary, flags, workers, retries) as dask,
    ):
        output.note_engine(manifest, dask.engine)
        job = _Job(file, absolute(file), columns, asked, reading or {}, output, dask.server)
        if "shape" not in manifest:
            width = _vertices(dask, job) if columns is None else len(columns)
            manifest["shape"] = [len(rows), width]
        height, width = manifest["shape"]
        run = _rows_of_run(height, width)
        output.prepare(height, width, run)
        return _filled(job, dask, rows, run, manifest, progress)


@dataclass(frozen=True)
class _Job:
    """What is asked, as workers get it. ``targets``: None: all vertices."""

    file: str
    path: str
    targets: Any
    asked: Mapping[str, Any]
    reading: Reading
    output: Output
    server: str

    def mesh(self) -> Mesh:
        """The mesh on the server of this worker, which keeps it for the next run of rows."""
        return server_of_worker(self.server).client().upload(self.path, **self.reading)


def _packed(points: PointsLike) -> Any:
    """Points as they go to workers: vertices as an array of integers."""
    found = points_of(points)
    if all(isinstance(one, Vertex) and not one.offset for one in found):
        return np.array([cast("Vertex", one).index for one in found], dtype=np.int64)
    return found


def _rows_of_run(rows: int, columns: int) -> int:
    """How many rows are computed and written at a time: not so many that workers run dry, nor so
    large that they run out of memory."""
    return max(1, min(_MOST_ROWS, -(-rows // 32), _MOST_BYTES // (8 * columns)))


def _filled(
    job: _Job,
    dask: Cluster,
    rows: Any,
    run: int,
    manifest: dict[str, Any],
    progress: Progress | None,
) -> Report:
    """Computes the runs of rows that are missing."""
    report, done = Report(), 0
    there = job.output.keys()
    starts = range(0, len(rows), run)

    def missing() -> Iterator[tuple[int, tuple[Any, ...]]]:
        for start in starts:
            if str(start // run) not in there:
                yield start, (job, str(start // run), start, rows[start : start + run])

    report.there = done = len(there)
    manifest["failures"].clear()
    for start, future in dask.run(_block, missing()):
        outcome = reason(future) or future.result()
        name = f"rows {start} to {min(start + run, len(rows)) - 1}"
        if isinstance(outcome, Answered):
            report.computed += outcome.computed
            report.there += not outcome.computed
            if outcome.remarks:
                report.remarks[name] = outcome.remarks
        else:
            report.failures[name] = manifest["failures"][name] = outcome
        done += 1
        if progress is not None:
            progress(done / len(starts))
    return report


def _vertices(dask: Cluster, job: _Job) -> int:
    """How many vertices the mesh has."""
    for _, future in dask.run(_vertices_here, [(None, (job,))]):
        return int(future.result())
    raise AssertionError("one task has one end")


def _vertices_here(job: _Job) -> int:
    return job.mesh().vertices


def _block(job: _Job, key: str, first: int, rows: Any) -> Answered | str:
    """Computes and writes a run of rows; why not, if that would fail alike again."""
    if job.output.has(key):
        return Answered(job.file, False, [])
    with kept_remarks() as remarks:
        try:
            mesh = job.mesh()
            if job.targets is None:
                each = (rows[row : row + 1] for row in range(len(rows)))
                block = np.stack([mesh.distance(row, **job.asked) for row in each])
            else:
                block = mesh.table(rows, job.targets, **job.asked)
        except (GeodesicError, OSError, ValueError, TypeError) as error:
            return lasting(error)
    about = {"file": job.file, "mesh": mesh.id, "vertices": mesh.vertices, "remarks": remarks}
    found = Columns(("source", "target"), {"distance": block}, first)
    job.output.write(key, found, about)
    return Answered(job.file, True, remarks)
