"""``geodesic distance``: a distance field as a file, or distances at points, printed."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np

from .command_line import (
    bar,
    exactness_of,
    into,
    mesh_of,
    people,
    points,
    require_into,
    save_annotated,
    signed,
)
from .digits import numbers
from .encoding import milliseconds
from .errors import Misuse
from .outputs import require, save_array, save_csv


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments that are this command's own."""
    parser.add_argument("--at", action="append", default=[], metavar="POINT", help="only there")
    parser.add_argument("--max", type=float, metavar="N", help="farther is unreached")
    signed(parser)
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FILE", help="a .npy file, or .csv; else printed"
    )
    into(parser)


def run(options: argparse.Namespace) -> int:
    """Runs the command; its exit status."""
    require(options.output, (".npy", ".csv"))
    require_into(options)
    if options.into is not None and (options.at or options.output is not None):
        raise Misuse("--into has the whole field, and is a file of its own")
    with mesh_of(options) as mesh, bar("distances") as progress:
        asked: dict[str, Any] = {"max": options.max, "progress": progress, **exactness_of(options)}
        sources = points(options.sources)
        if options.into is not None:
            asked = {"max": options.max, **exactness_of(options), "from": sources}
            if options.signed:
                asked["signed"] = True
            asked["deadline_ms"] = milliseconds(asked.pop("deadline"))
            return save_annotated(options, mesh, "distance", asked, progress)
        asked["signed"] = options.signed
        if options.at:
            field = mesh.distance_at(sources, points(options.at), **asked)
        else:
            field = mesh.distance(sources, **asked)
    if options.output is None:
        print("\n".join(numbers(field)))
        return 0
    if options.output.suffix == ".csv":
        save_csv(options.output, "index,distance", map(str, range(len(field))), numbers(field))
    else:
        save_array(options.output, field)
    reached = field[np.isfinite(field)]
    farthest = f", the farthest {reached.max():.6g}" if len(reached) else ""
    people.print(f"{options.output}: {len(reached):,} of {len(field):,} reached{farthest}")
    return 0
