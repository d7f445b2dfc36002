"""``geodesic extent``: how large a surface is, and where its middle is, as CSV; and the mean
distance of each vertex, in a file."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

from .command_line import bar, exactness_of, mesh_of, people
from .digits import numbers
from .errors import Misuse
from .outputs import require, save_array, save_reply, save_rows
from .results import Extent

_MEASURES = ("diameter", "center", "median", "mean", "means")
_ENDINGS = (".csv", ".json", ".npy", ".glb", ".png")


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments that are this command's own."""
    parser.add_argument(
        "--of", action="append", choices=_MEASURES, required=True, metavar="MEASURE",
        help=", ".join(_MEASURES),
    )  # fmt: skip
    parser.add_argument(
        "--fields", type=int, metavar="N", help="most distance fields to compute (100)"
    )
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FILE",
        help=f"of means alone: {', '.join(_ENDINGS)}",
    )  # fmt: skip


def run(options: argparse.Namespace) -> int:
    """Runs the command; its exit status."""
    file: Path | None = options.output
    if (file is None) != ("means" not in options.of) or (file is not None and len(options.of) > 1):
        raise Misuse("--of means goes alone into a file, by -o FILE; nothing else does")
    require(file, _ENDINGS)
    asked = {"fields": options.fields, **exactness_of(options)}
    with mesh_of(options) as mesh, bar("extent") as progress:
        if file is not None:
            if file.suffix in (".csv", ".npy"):
                means = mesh.extent("means", progress=progress, **asked)
                if file.suffix == ".npy":
                    save_array(file, means.means)
                else:
                    save_rows(file, _rows(means))
            else:
                save_reply(file, mesh, "extent", {"of": "means", **asked}, progress)
            people.print(str(file), markup=False, soft_wrap=True)
            return 0
        found = [mesh.extent(of, progress=progress, **asked) for of in options.of]
    print("of,value,lower,upper,exact,vertices")
    for extent in found:
        lengths = numbers([extent.value, extent.lower, extent.upper])
        vertices = " ".join(map(str, extent.vertices.tolist()))
        print(",".join([extent.of, *lengths, str(int(extent.exact)), vertices]))
    return 0


def _rows(found: Extent) -> Iterator[str]:
    """The lines of its CSV."""
    yield "vertex,mean,margin"
    pairs = zip(numbers(found.means), numbers(found.margins), strict=True)
    for vertex, (mean, margin) in enumerate(pairs):
        yield f"{vertex},{mean},{margin}"
