"""``geodesic path``: the shortest path: its length, and the line as a file."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from .command_line import Once, bar, exactness_of, mesh_of, people, point, points
from .digits import number
from .outputs import require, save_bytes, save_line


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments that are this command's own."""
    parser.add_argument("--to", action=Once, required=True, metavar="POINT", help="where it ends")
    parser.add_argument("--via", action="append", default=[], metavar="POINT", help="on the way")
    parser.add_argument(
        "--refine", choices=["none", "shortest"], metavar="HOW",
        help="shortest, or none: as it was traced",
    )  # fmt: skip
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FILE", help=".csv, .npy, .json or .glb"
    )


def run(options: argparse.Namespace) -> int:
    """Runs the command; its exit status."""
    require(options.output, (".csv", ".npy", ".json", ".glb"))
    source, target, via = point(options.sources), point(options.to), points(options.via)
    asked: dict[str, Any] = {"refine": options.refine, **exactness_of(options)}
    with mesh_of(options) as mesh, bar("path") as progress:
        path = mesh.path(source, target, via=via, progress=progress, **asked)
        if path.reachable and options.output is not None and options.output.suffix == ".glb":
            asked.pop("deadline")
            asked |= {"from": source, "to": target, "via": via}
            save_bytes(options.output, mesh.query("path", asked, format="glb").data)
    if not path.reachable:
        people.print("geodesic: there is no path", style="red")
        return 1
    if options.output is not None:
        save_line(options.output, path)
    print(number(path.length if path.cost is None else path.cost))
    return 0
