"""``geodesic measure``: what geodesic discs measure, as CSV, as JSON, or cut out of the surface."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from .command_line import bar, exactness_of, mesh_of, people, points
from .digits import number, numbers
from .encoding import as_bound
from .outputs import require, save_reply, save_rows
from .results import Measure

_ENDINGS = (".csv", ".json", ".glb")


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments that are this command's own."""
    parser.add_argument(
        "--radius", action="append", type=float, default=[], metavar="N", help="of a disc"
    )
    parser.add_argument("--max", type=float, metavar="N", help="farther is not measured")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FILE",
        help=".csv, .json or .glb, strips; else printed",
    )  # fmt: skip


def run(options: argparse.Namespace) -> int:
    """Runs the command; its exit status."""
    file: Path | None = options.output
    require(file, _ENDINGS)
    asked: dict[str, Any] = {"radii": options.radius, "max": as_bound(options.max)}
    asked |= exactness_of(options)
    sources = points(options.sources)
    with mesh_of(options) as mesh, bar("measure") as progress:
        if file is not None and file.suffix != ".csv":
            save_reply(file, mesh, "measure", {"from": sources, **asked}, progress)
            told = str(file)
        else:
            found = mesh.measure(sources, progress=progress, **asked)
            told = f"{len(found)} discs; the farthest vertex is {found.farthest}, "
            told += f"{number(found.max)} away; the mean distance is {number(found.mean)}"
            save_rows(file, _rows(found))
    people.print(told, markup=False, soft_wrap=True)
    return 0


def _rows(found: Measure) -> Iterator[str]:
    """The lines of its CSV."""
    yield "radius,area,mean,perimeter,boundary,lines,vertices,euler,whole"
    lengths = (found.radii, found.areas, found.means, found.perimeters, found.boundaries)
    counts = (found.lines, found.vertices, found.euler, found.whole)
    wholes = [[str(int(x)) for x in column] for column in counts]
    yield from map(",".join, zip(*map(numbers, lengths), *wholes, strict=True))
