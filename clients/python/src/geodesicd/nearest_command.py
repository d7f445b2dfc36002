"""``geodesic nearest``: where on the surface points are."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence

from .command_line import bar, cell, mesh_of, points, surface_of
from .digits import number, numbers
from .outputs import save_rows
from .results import SurfacePoint


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments that are this command's own."""
    parser.add_argument(
        "point", nargs="+", metavar="POINT", help="p:X,Y,Z in space, ray:X,Y,Z,DX,DY,DZ, 12, …"
    )


def run(options: argparse.Namespace) -> int:
    """Runs the command; its exit status."""
    with mesh_of(options) as mesh, bar("nearest") as progress:
        found = mesh.nearest(points(options.point), progress=progress, **surface_of(options))
    save_rows(None, _rows(found))
    return 0


def _rows(found: Sequence[SurfacePoint]) -> Iterator[str]:
    """A row for each point; where it is, is told as other commands take it."""
    yield "x,y,z,away,point"
    for point in found:
        place = (*numbers(point.xyz), number(point.snap_distance))
        yield ",".join([*place, cell(point.text() or "")])
