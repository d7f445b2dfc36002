"""``geodesic table``: distances among points, as CSV or as a file."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from .command_line import bar, cell, exactness_of, listed, mesh_of, people, points
from .digits import numbers
from .errors import GeodesicError, Misuse, printable
from .outputs import require, save_sparse


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments that are this command's own."""
    parser.add_argument(
        "--to", action="append", default=[], metavar="POINT", help="a column; else the rows"
    )
    for name, help in (
        ("--from-file", "more rows: text, spaces or lines between"),
        ("--to-file", "more columns, so too"),
    ):
        parser.add_argument(name, action="append", default=[], type=Path, metavar="FILE", help=help)
    parser.add_argument("--max", type=float, metavar="N", help="farther is unreached")
    parser.add_argument("--landmarks", type=int, metavar="N", help="estimate by N columns' fields")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FILE",
        help="a .npy file, or a .npz of what is within --max",
    )  # fmt: skip


def run(options: argparse.Namespace) -> int:
    """Runs the command; its exit status."""
    require(options.output, (".npy", ".npz"))
    sources = listed(options.sources, options.from_file)
    if not sources:
        raise Misuse("give --from POINT or --from-file FILE, which has points")
    targets = listed(options.to, options.to_file) or sources
    with mesh_of(options) as mesh, bar("table") as progress, _named(sources, targets):
        asked: dict[str, Any] = {"max": options.max, "progress": progress, **exactness_of(options)}
        if options.landmarks is not None and getattr(options.output, "suffix", "") != ".npy":
            raise Misuse("with --landmarks a table goes to a .npy file: name one with -o")
        if options.output is not None:
            if options.output.suffix == ".npy":
                asked |= {"landmarks": options.landmarks, "estimated": _print_errors}
                try:
                    mesh.table_file(options.output, points(sources), points(targets), **asked)
                except KeyboardInterrupt:
                    people.print("geodesic: the same command goes on where this one ended")
                    raise
            else:
                sparse = mesh.sparse_table(points(sources), points(targets), **asked)
                save_sparse(options.output, sparse)
            return 0
        table = mesh.table(points(sources), points(targets), **asked)
    print(",".join(["", *map(cell, targets)]))
    for name, row in zip(sources, table, strict=True):
        print(",".join([cell(name), *numbers(row)]))
    return 0


@contextmanager
def _named(sources: Sequence[str], targets: Sequence[str]) -> Iterator[None]:
    """Says which text it is that the server does not take as a point: its number in a file says
    little."""
    try:
        yield
    except GeodesicError as error:
        number = re.match(r"(from|to)\[(\d+)\]", error.parameter or "")
        texts = sources if number and number[1] == "from" else targets
        if number and int(number[2]) < len(texts):
            told = f"geodesic: {number[0]} is {texts[int(number[2])]!r}"
            people.print(printable(told), style="red", markup=False, highlight=False)
        raise


def _print_errors(found: dict[str, float]) -> None:
    people.print(
        f"estimated by {found['landmarks']} landmarks: {100 * found['mean']:.2g} % off on average,"
        f" 99 of 100 at most {100 * found['percentile_99']:.2g} %"
    )
