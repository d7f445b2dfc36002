"""``geodesic map``: one question to many meshes, or a distance matrix, by a Dask cluster. Exit
status 1: something could not be answered."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .command_line import (
    Once,
    Parser,
    bar,
    exactness,
    exactness_of,
    listed,
    people,
    point,
    points,
    sources,
)
from .errors import printable
from .hints import in_shell

if TYPE_CHECKING:
    from .bulk import Report

_MOST_SHOWN = 10


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the questions, and the arguments of each."""
    questions = parser.add_subparsers(required=True, metavar="QUESTION", parser_class=Parser)

    def question(name: str, usage: str, help: str, several: bool = True) -> Any:
        files = "FILE..." if several else "FILE"
        full = f"geodesic map {name} [options] {usage} -o FOLDER {files}"
        made = questions.add_parser(
            name, prog=f"geodesic map {name}", help=help, description=help, usage=full
        )
        made.set_defaults(asking=_ASKING[name])
        text = ".glb, .gltf, .drc, .obj, .ply or .stl"
        made.add_argument("file", nargs="+" if several else 1, metavar="FILE", help=text)
        return made

    distance = question("distance", "--from POINT", "Distance fields, or distances of points.")
    sources(distance, **_SEVERAL)
    distance.add_argument("--at", action="append", metavar="POINT", help="only there")
    distance.add_argument("--max", type=float, metavar="N", help="farther is unreached")
    _common(distance)

    path = question("path", "--from POINT --to POINT", "Shortest paths between two points.")
    sources(path, required=True)
    path.add_argument("--to", action=Once, required=True, metavar="POINT", help="where it ends")
    path.add_argument("--via", action="append", default=[], metavar="POINT", help="on the way")
    _common(path)

    table = question("table", "--from POINT", "Distances among points.")
    sources(table, **_SEVERAL)
    table.add_argument("--to", action="append", metavar="POINT", help="a column; else the rows")
    table.add_argument("--max", type=float, metavar="N", help="farther is unreached")
    _common(table)

    samples = question("samples", "--count N", "Vertices that are far from each other.")
    samples.add_argument("--count", type=int, required=True, metavar="N", help="how many")
    _common(samples)

    matrix = question("matrix", "--from POINT", "Of one mesh, a matrix of many rows.", False)
    sources(matrix, action="append", default=[])
    matrix.add_argument(
        "--from-file", action="append", default=[], type=Path, metavar="FILE",
        help="of points, spaces or lines between",
    )  # fmt: skip
    matrix.add_argument(
        "--to", action="append", metavar="POINT", help='a column; "vertices": all; else the rows'
    )
    matrix.add_argument("--max", type=float, metavar="N", help="farther is unreached")
    _common(matrix)


_SEVERAL: dict[str, Any] = {"action": "append", "required": True}


def _common(parser: argparse.ArgumentParser) -> None:
    """What all questions take."""
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="FOLDER", help="a .zarr or .parquet"
    )
    exactness(parser)
    parser.add_argument("--up", choices="xyz", metavar="AXIS", help="in the files: x, y or z")
    parser.add_argument("--scale", type=float, metavar="N", help="multiply all positions by this")
    parser.add_argument("--workers", type=int, metavar="N", help="processes; else one a processor")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="of a Dask cluster that runs")
    parser.add_argument("--retries", type=int, default=3, metavar="N", help="each (%(default)s)")
    parser.add_argument("--url", help="a server; else $GEODESICD_URL, or one a worker")
    parser.add_argument("--token", help="else $GEODESICD_TOKEN")


def run(options: argparse.Namespace) -> int:
    """Runs the command; its exit status."""
    names = ("up", "scale")
    reading = {name: getattr(options, name) for name in names if getattr(options, name) is not None}
    common: dict[str, Any] = {
        "url": options.url,
        "token": options.token or os.environ.get("GEODESICD_TOKEN"),
        "workers": options.workers,
        "retries": options.retries,
        "reading": reading,
        **exactness_of(options),
    }
    ask: Callable[..., Report] = options.asking
    with bar(f"{len(options.file):,} meshes") as progress:
        if options.scheduler is None:
            report = ask(options, progress=progress, **common)
        else:
            from .bulk.cluster import running

            with running(options.scheduler) as dask:
                report = ask(options, client=dask, progress=progress, **common)
    return _told(report, options.output)


def _told(report: Report, out: Path) -> int:
    """Says what became of it; the exit status."""
    _list(report.remarks.items(), "yellow")
    _list(((name, [in_shell(why)]) for name, why in report.failures.items()), "red")
    failed = f", {len(report.failures):,} failed" if report.failures else ""
    counts = f"{report.computed:,} computed, {report.there:,} there already{failed}"
    people.print(f"{out}: {counts}", markup=False, soft_wrap=True)
    return 1 if report.failures else 0


def _list(told: Any, style: str) -> None:
    lines = [f"{name}: {one}" for name, sentences in told for one in sentences]
    if len(lines) > _MOST_SHOWN:
        lines[_MOST_SHOWN:] = [f"and {len(lines) - _MOST_SHOWN:,} more, which the output names"]
    for line in lines:
        people.print(printable(line), style=style, markup=False, highlight=False, soft_wrap=True)


def _map(*arguments: Any, **named: Any) -> Report:
    from .bulk import map_meshes

    return map_meshes(*arguments, **named)


def _distance(options: argparse.Namespace, **common: Any) -> Report:
    at = {"at": points(options.at)} if options.at else {}
    name = "distance_at" if at else "distance"
    asked = {"sources": points(options.sources), "max": options.max, **at}
    return _map(name, options.file, options.output, **asked, **common)


def _path(options: argparse.Namespace, **common: Any) -> Report:
    ends = {"source": point(options.sources), "target": point(options.to)}
    asked: dict[str, Any] = {**ends, "via": points(options.via)}
    return _map("path", options.file, options.output, **asked, **common)


def _table(options: argparse.Namespace, **common: Any) -> Report:
    targets = points(options.to) if options.to else None
    asked = {"sources": points(options.sources), "targets": targets, "max": options.max}
    return _map("table", options.file, options.output, **asked, **common)


def _samples(options: argparse.Namespace, **common: Any) -> Report:
    return _map("samples", options.file, options.output, count=options.count, **common)


def _matrix(options: argparse.Namespace, **common: Any) -> Report:
    texts = listed(options.sources, options.from_file)
    targets: Any = None
    if options.to == ["vertices"]:
        targets = "vertices"
    elif options.to:
        targets = points(options.to)
    asked = {"sources": points(texts), "targets": targets, "max": options.max}
    from .bulk import distance_matrix

    return distance_matrix(options.file[0], out=options.output, **asked, **common)


_ASKING: dict[str, Callable[..., Report]] = {
    "distance": _distance,
    "path": _path,
    "table": _table,
    "samples": _samples,
    "matrix": _matrix,
}
