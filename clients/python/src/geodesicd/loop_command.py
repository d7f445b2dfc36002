"""``geodesic loop``: closed geodesics, and what a tape measures: the length, and the curve as a
file."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from .command_line import bar, exactness_of, mesh_of, people, point, points, vector
from .digits import number
from .outputs import require, save_line, save_reply


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments that are this command's own."""
    for name, what in (("through", "on the loop, several"), ("around", "near it at first")):
        parser.add_argument(
            f"--{name}", action="append", default=[], metavar="POINT", help=f"a point {what}"
        )
    parser.add_argument("--at", metavar="POINT", help="where a plane cuts the surface")
    parser.add_argument("--normal", metavar="X,Y,Z", help="of the plane")
    parser.add_argument(
        "--hull", action="store_true", help="with --at or 3 --around: not into hollows"
    )
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FILE", help=".csv, .npy, .json or .glb"
    )


def run(options: argparse.Namespace) -> int:
    """Runs the command; its exit status."""
    file: Path | None = options.output
    require(file, (".csv", ".npy", ".json", ".glb"))
    asked: dict[str, Any] = {
        "through": points(options.through),
        "around": points(options.around),
        "at": None if options.at is None else point(options.at),
        "normal": None if options.normal is None else vector(options.normal, "--normal"),
        **exactness_of(options),
    }
    asked = {name: value for name, value in asked.items() if value not in (None, [])}
    if options.hull:
        asked["hull"] = True
    with mesh_of(options) as mesh, bar("loop") as progress:
        found = mesh.loop(progress=progress, **asked)
        if file is not None and file.suffix == ".glb":
            save_reply(file, mesh, "loop", asked, None)
    what = "a closed geodesic" if found.geodesic else "no closed geodesic"
    if options.hull:
        what = "a tape"
    if found.turn is not None and not found.geodesic and not options.hull:
        what += f", {number(found.turn)} degrees off straight ahead"
    if file is not None:
        save_line(file, found)
    people.print(f"{what}; {number(found.start_length)} at first", markup=False, soft_wrap=True)
    print(number(found.length))
    return 0
