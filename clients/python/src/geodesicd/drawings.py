"""What the server draws as .glb files: cells, discs and maps, to open in any 3D program.
What they take like other queries is told in ``options.py``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Unpack

import numpy as np

from . import wire
from .encoding import as_bound, encode
from .flows import Flow, Progress, ask
from .options import Options, asked_by, spelled_out
from .points import PointLike, PointsLike, point_of, points_of
from .results import FloatArray


def _glb(
    mesh: str, query: str, parameters: dict[str, Any], progress: Progress | None
) -> Flow[bytes]:
    request = encode(mesh, query, {**parameters, "format": "glb"})
    return ask(request, wire.raw, progress)


@spelled_out
def cells_glb(
    mesh: str,
    sites: PointsLike,
    *,
    part: str | None = None,
    relax: int | None = None,
    **options: Unpack[Options],
) -> Flow[bytes]:
    """The Voronoi diagram of :meth:`voronoi` as the bytes of a .glb file.

    Args:
        part: ``"cells"``, the surface cut into a coloured mesh for each, which it is without it;
            ``"bisectors"``, the lines between them; ``"delaunay"``, the triangles between sites.
        relax: rounds of Lloyd's algorithm before.
    """
    parameters = {
        "from": points_of(sites),
        "part": part,
        "relax": relax,
        **asked_by(**options),
    }
    return _glb(mesh, "voronoi", parameters, options.get("progress"))


@spelled_out
def discs_glb(
    mesh: str,
    sources: PointsLike,
    radii: float | Sequence[float] | FloatArray,
    *,
    max: float | None = None,
    colormap: str | None = None,
    **options: Unpack[Options],
) -> Flow[bytes]:
    """The discs of :meth:`measure` as the bytes of a .glb file: a mesh for each strip between two
    of the ``radii`` (mesh units), cut out of the surface, with its area in its ``extras``."""
    parameters = {
        "from": points_of(sources),
        "radii": np.atleast_1d(np.asarray(radii, dtype=np.float64)).tolist(),
        "max": as_bound(max),
        "colormap": colormap,
        **asked_by(**options),
    }
    return _glb(mesh, "measure", parameters, options.get("progress"))


@spelled_out
def map_glb(
    mesh: str,
    point: PointLike,
    radius: float | None = None,
    *,
    angle: float = 0.0,
    transport: bool = False,
    **options: Unpack[Options],
) -> Flow[bytes]:
    """The faces of :meth:`logmap` as the bytes of a .glb file, with texture coordinates: a decal
    about the point. ``radius``, ``angle`` and ``transport`` as there."""
    parameters = {
        "from": point_of(point),
        "radius": as_bound(radius),
        "angle": angle,
        "transport": transport or None,
        **asked_by(**options),
    }
    return _glb(mesh, "logmap", parameters, options.get("progress"))
