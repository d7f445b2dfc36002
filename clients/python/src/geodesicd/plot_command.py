"""``geodesic plot``: a picture of a distance field, by matplotlib."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from .command_line import Once, bar, exactness_of, mesh_of, people, point, points, signed
from .errors import Misuse
from .outputs import require, whole

if TYPE_CHECKING:
    from .plot import View


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments that are this command's own."""
    parser.add_argument(
        "--to", action=Once, metavar="POINT", help="draw the path there from the first source"
    )
    parser.add_argument("--via", action="append", default=[], metavar="POINT", help="on the way")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FILE", help="a .png, .svg or .pdf; else on screen"
    )
    parser.add_argument("--isolines", type=int, default=12, metavar="N", help="0: none")
    parser.add_argument("--view", help="front, back, left, right, top, bottom, corner, AZ,EL")
    parser.add_argument("--up", choices=["y", "z"], metavar="AXIS", help="y or z, for slopes, too")
    parser.add_argument("--colormap", metavar="NAME", help="one of matplotlib's")
    signed(parser)


def run(options: argparse.Namespace) -> int:
    """Runs the command; its exit status."""
    require(options.output, (".png", ".svg", ".pdf", ".jpg", ".eps"))
    if options.via and options.to is None:
        raise Misuse("--via is for --to")
    view = _view(options.view)
    from .plot import plot, show

    with mesh_of(options) as mesh, bar("distances") as progress:
        title = Path(options.mesh).name if Path(options.mesh).is_file() else None
        figure = plot(
            mesh,
            points(options.sources),
            target=None if options.to is None else point(options.to),
            via=points(options.via),
            isolines=options.isolines,
            view=view,
            up=options.up or "y",
            colormap=options.colormap,
            title=title,
            signed=options.signed,
            progress=progress,
            **exactness_of(options),
        )
    if options.output is not None:
        with whole(options.output) as out:
            figure.savefig(out, format=options.output.suffix[1:])
        people.print(f"{options.output}")
        return 0
    show(figure)
    return 0


def _view(text: str | None) -> View | None:
    """A view as it is written on a command line: a name, or two angles in degrees."""
    from .plot import view_angles

    try:
        azimuth, elevation = map(float, (text or "").split(","))
    except ValueError:  # no angles
        view: str | View | None = text
    else:
        view = azimuth, elevation
    try:
        return view_angles(view)
    except ValueError as error:
        raise Misuse(f"--{error}") from None
