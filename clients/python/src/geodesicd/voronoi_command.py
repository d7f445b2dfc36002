"""``geodesic voronoi``: cells of the nearest site, as CSV, as JSON, or drawn."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from .command_line import bar, exactness_of, mesh_of, people, points
from .digits import numbers
from .errors import Misuse
from .outputs import require, save_reply, save_rows
from .results import Voronoi

_ENDINGS = (".csv", ".json", ".glb", ".png")


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments that are this command's own."""
    parser.add_argument(
        "--relax", type=int, metavar="N", help="first move sites to the middle, N times"
    )
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FILE",
        help=".csv, .json, .png or .glb; else printed",
    )  # fmt: skip
    parser.add_argument(
        "--part", choices=("cells", "bisectors", "delaunay"), metavar="PART",
        help="of a .glb: cells, bisectors or delaunay",
    )  # fmt: skip


def run(options: argparse.Namespace) -> int:
    """Runs the command; its exit status."""
    file: Path | None = options.output
    require(file, _ENDINGS)
    if options.part is not None and (file is None or file.suffix != ".glb"):
        raise Misuse("--part is for -o FILE.glb")
    asked: dict[str, Any] = {"relax": options.relax, **exactness_of(options)}
    sites = points(options.sources)
    with mesh_of(options) as mesh, bar("voronoi") as progress:
        if file is not None and file.suffix != ".csv":
            save_reply(
                file, mesh, "voronoi", {"from": sites, "part": options.part, **asked}, progress
            )
            told = str(file)
        else:
            found = mesh.voronoi(sites, progress=progress, **asked)
            told = f"{len(found)} cells of {found.areas.sum():.9g} in all, "
            told += f"{len(found.neighbors)} pairs of neighbors, {len(found.triangles)} triangles"
            save_rows(file, _rows(found))
    people.print(told, markup=False, soft_wrap=True)
    return 0


def _rows(found: Voronoi) -> Iterator[str]:
    """The lines of its CSV."""
    yield "cell,x,y,z,area,perimeter,boundary,vertices"
    columns = (*found.points.T, found.areas, found.perimeters, found.boundaries)
    vertices = map(str, found.vertices.tolist())
    cells = map(str, range(len(found)))
    yield from map(",".join, zip(cells, *map(numbers, columns), vertices, strict=True))
