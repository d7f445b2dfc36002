"""``geodesic extent``: how large a surface is, and where its middle is, as CSV."""

from __future__ import annotations

import argparse

from .command_line import bar, exactness_of, mesh_of
from .digits import numbers

_MEASURES = ("diameter", "center", "median", "mean")


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments that are this command's own."""
    parser.add_argument(
        "--of", action="append", choices=_MEASURES, required=True, metavar="MEASURE",
        help=", ".join(_MEASURES),
    )  # fmt: skip
    parser.add_argument(
        "--fields", type=int, metavar="N", help="most distance fields to compute (100)"
    )


def run(options: argparse.Namespace) -> int:
    """Runs the command; its exit status."""
    with mesh_of(options) as mesh, bar("extent") as progress:
        found = [
            mesh.extent(of, fields=options.fields, progress=progress, **exactness_of(options))
            for of in options.of
        ]
    print("of,value,lower,upper,exact,vertices")
    for extent in found:
        lengths = numbers([extent.value, extent.lower, extent.upper])
        vertices = " ".join(map(str, extent.vertices.tolist()))
        print(",".join([extent.of, *lengths, str(int(extent.exact)), vertices]))
    return 0
