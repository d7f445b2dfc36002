"""``geodesic table``: distances among points, as CSV or as a file."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from .command_line import (
    bar,
    cell,
    exactness_of,
    listed,
    mesh_of,
    people,
    points,
    require,
    save_sparse,
)
from .digits import numbers


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments that are this command's own."""
    parser.add_argument(
        "--to", action="append", default=[], metavar="POINT", help="a column; else the rows"
    )
    parser.add_argument(
        "--from-file", type=Path, metavar="FILE", help="more rows: text, spaces or lines between"
    )
    parser.add_argument("--to-file", type=Path, metavar="FILE", help="more columns, so too")
    parser.add_argument("--max", type=float, metavar="N", help="farther is unreached")
    parser.add_argument("--landmarks", type=int, metavar="N", help="estimate by N columns' fields")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FILE",
        help="a .npy file, or a .npz of what is within --max",
    )  # fmt: skip


def run(options: argparse.Namespace) -> int:
    """Runs the command; its exit status."""
    sources = listed(options.sources, options.from_file)
    if not sources:
        raise ValueError("give --from POINT or --from-file FILE, which has points")
    targets = listed(options.to, options.to_file) or sources
    with mesh_of(options) as mesh, bar("table") as progress:
        asked: dict[str, Any] = {"max": options.max, "progress": progress, **exactness_of(options)}
        if options.landmarks is not None and getattr(options.output, "suffix", "") != ".npy":
            raise ValueError("with --landmarks a table goes to a .npy file: name one with -o")
        if options.output is not None:
            require(options.output, (".npy", ".npz"))
            if options.output.suffix == ".npy":
                asked |= {"landmarks": options.landmarks, "estimated": _print_errors}
                mesh.table_file(options.output, points(sources), points(targets), **asked)
            else:
                sparse = mesh.sparse_table(points(sources), points(targets), **asked)
                save_sparse(options.output, sparse)
            return 0
        table = mesh.table(points(sources), points(targets), **asked)
    print(",".join(["", *map(cell, targets)]))
    for name, row in zip(sources, table, strict=True):
        print(",".join([cell(name), *numbers(row)]))
    return 0


def _print_errors(found: dict[str, float]) -> None:
    people.print(
        f"estimated by {found['landmarks']} landmarks: {100 * found['mean']:.2g} % off on average,"
        f" 99 of 100 at most {100 * found['percentile_99']:.2g} %"
    )
