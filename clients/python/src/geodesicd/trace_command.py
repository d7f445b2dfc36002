"""``geodesic trace``: straight ahead over the surface: where that ends, and the line as a file."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from .command_line import bar, mesh_of, people, point, surface_of, vector
from .digits import number
from .outputs import require, save_line, save_reply

_WHY = {
    "length": "that is the length asked for",
    "boundary": "it met the boundary, a wall, or the end of the region",
    "vertex": "it met a vertex, beyond which straight ahead is not one direction",
    "non_manifold": "it met an edge of more than two faces",
}


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments that are this command's own."""
    parser.add_argument("--length", type=float, required=True, metavar="N", help="how far")
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument("--direction", metavar="X,Y,Z", help="in space, laid onto the surface")
    where.add_argument(
        "--angle", type=float, metavar="A", help="or from the face's first side, in radians"
    )
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FILE", help=".csv, .npy, .json or .glb"
    )


def run(options: argparse.Namespace) -> int:
    """Runs the command; its exit status."""
    file: Path | None = options.output
    require(file, (".csv", ".npy", ".json", ".glb"))
    direction = None if options.direction is None else vector(options.direction, "--direction")
    asked: dict[str, Any] = {"direction": direction, "angle": options.angle, **surface_of(options)}
    start = point(options.sources)
    with mesh_of(options) as mesh, bar("trace") as progress:
        found = mesh.trace(start, options.length, progress=progress, **asked)
        if file is not None and file.suffix == ".glb":
            asked |= {"from": start, "length": options.length}
            save_reply(file, mesh, "trace", asked, None)
    place = ", ".join(f"{x:.6g}" for x in found.target.xyz)
    told = f"at {place}: {_WHY.get(found.end, found.end)}"
    if file is not None:
        save_line(file, found)
    people.print(told, markup=False, soft_wrap=True)
    print(number(found.length))
    return 0
