"""The query for closed curves. What it takes like other queries is told in ``options.py``."""

from __future__ import annotations

from typing import Unpack

from . import wire
from .encoding import encode
from .flows import Flow, ask
from .options import Options, asked_by, spelled_out
from .points import PointLike, PointsLike, Triple, point_of, some_points_of, triple
from .results import Loop


@spelled_out
def loop(
    mesh: str,
    *,
    through: PointsLike = (),
    around: PointsLike = (),
    at: PointLike | None = None,
    normal: Triple | None = None,
    hull: bool = False,
    **options: Unpack[Options],
) -> Flow[Loop]:
    """A closed curve, by exactly one of ``through``, ``around`` and ``at``. GeodesicError with the
    code ``no_loop``: it contracts to a point, or there is none.

    Args:
        through: two points or more, joined by shortest paths in this order, and back to the first.
        around: three points or more, joined likewise; the loop is then tightened until it is a
            closed geodesic, and need not go through them any more.
        at: a point through which a plane cuts the surface in a closed curve, tightened likewise.
        normal: (3,) with ``at``, at a right angle to the plane.
        hull: with ``at`` or three points ``around``, the convex hull of the section instead, as a
            tape lies round hollows.
        tolerance: for ``method="steiner"`` only, relative.
    """
    parameters = {
        "through": some_points_of(through),
        "around": some_points_of(around),
        "at": None if at is None else point_of(at),
        "normal": None if normal is None else triple(normal, "normal"),
        "hull": hull or None,
        **asked_by(**options),
        "format": "frame",
    }
    return ask(encode(mesh, "loop", parameters), wire.loop_of_frame, options.get("progress"))
