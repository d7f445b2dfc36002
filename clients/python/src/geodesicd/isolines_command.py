"""``geodesic isolines``: lines of equal distance, as rows or as a file."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from .command_line import bar, exactness_of, mesh_of, people, points
from .digits import number, numbers
from .encoding import as_bound
from .outputs import require, save_reply, save_rows
from .results import Isoline


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments that are this command's own."""
    which = parser.add_mutually_exclusive_group(required=True)
    which.add_argument("--level", action="append", type=float, metavar="N", help="at a distance")
    which.add_argument("--step", type=float, metavar="N", help="or at all multiples of one")
    which.add_argument("--count", type=int, metavar="N", help="or at so many, evenly spread")
    parser.add_argument("--max", type=float, metavar="N", help="none is farther")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FILE", help=".csv, .json or .glb; else told in rows"
    )


def run(options: argparse.Namespace) -> int:
    """Runs the command; its exit status."""
    file: Path | None = options.output
    require(file, (".csv", ".json", ".glb"))
    asked: dict[str, Any] = {"levels": options.level, "step": options.step, "count": options.count}
    asked |= {"max": as_bound(options.max), **exactness_of(options)}
    sources = points(options.sources)
    with mesh_of(options) as mesh, bar("isolines") as progress:
        if file is not None and file.suffix != ".csv":
            save_reply(file, mesh, "isolines", {"from": sources, **asked}, progress)
            told = str(file)
        else:
            found = mesh.isolines(sources, progress=progress, **asked)
            told = f"{len(found):,} lines"
            save_rows(file, _lines(found) if file is None else _points(found))
    people.print(told, markup=False, soft_wrap=True)
    return 0


def _lines(found: Sequence[Isoline]) -> Iterator[str]:
    """A row for each line."""
    yield "level,length,closed,points"
    for line in found:
        yield f"{number(line.level)},{number(line.length)},{int(line.closed)},{len(line.points)}"


def _points(found: Sequence[Isoline]) -> Iterator[str]:
    """A row for each point of each line; the first of a closed one comes once more at its end."""
    yield "line,level,x,y,z"
    for index, line in enumerate(found):
        begin = f"{index},{number(line.level)}"
        for place in zip(*(numbers(axis) for axis in line.polyline.T), strict=True):
            yield f"{begin},{','.join(place)}"
