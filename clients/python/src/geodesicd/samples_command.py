"""``geodesic samples``: vertices spread evenly over the surface, as CSV or as a file."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

from .command_line import bar, exactness_of, mesh_of, people, points
from .digits import number, numbers
from .outputs import require, save_array, save_reply, save_rows
from .results import Samples


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments that are this command's own."""
    parser.add_argument("--count", type=int, required=True, metavar="N", help="how many")
    parser.add_argument(
        "--from", dest="sources", action="append", default=[], metavar="POINT",
        help="near which none is needed; or a line",
    )  # fmt: skip
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FILE",
        help=".csv, .json or .npy, of their numbers; else printed",
    )  # fmt: skip


def run(options: argparse.Namespace) -> int:
    """Runs the command; its exit status."""
    file: Path | None = options.output
    require(file, (".csv", ".npy", ".json"))
    asked = exactness_of(options)
    covered = points(options.sources)
    with mesh_of(options) as mesh, bar("samples") as progress:
        if file is not None and file.suffix == ".json":
            question = {"count": options.count, **({"from": covered} if covered else {}), **asked}
            save_reply(file, mesh, "samples", question, progress)
            told = str(file)
        else:
            found = mesh.samples(options.count, covered=covered, progress=progress, **asked)
            told = f"no vertex is farther than {number(found.covering_radius)} from one of these"
            if len(found.vertices) < options.count:
                told += f", {len(found.vertices)} and not {options.count}: there are no others"
            if file is not None and file.suffix == ".npy":
                save_array(file, found.vertices)
            else:
                save_rows(file, _rows(found))
    people.print(told, markup=False, soft_wrap=True)
    return 0


def _rows(found: Samples) -> Iterator[str]:
    """The lines of its CSV."""
    yield "vertex,x,y,z,radius"
    columns = (*found.points.T, found.radii)
    yield from map(
        ",".join, zip(map(str, found.vertices.tolist()), *map(numbers, columns), strict=True)
    )
