"""Queries about how distances spread over the whole surface: isolines, samples, discs, extents
and cells.
The same holds of them as of those of :mod:`geodesicd.queries`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Unpack

import numpy as np

from . import wire
from .encoding import as_bound, encode
from .flows import Flow, ask
from .options import CostOptions, Options, asked_by, spelled_out
from .points import PointsLike, points_of, some_points_of
from .results import Extent, FloatArray, Isoline, Measure, Samples, Voronoi


@spelled_out
def isolines(
    mesh: str,
    sources: PointsLike,
    *,
    levels: Sequence[float] | FloatArray | None = None,
    step: float | None = None,
    count: int | None = None,
    max: float | None = None,
    **options: Unpack[CostOptions],
) -> Flow[list[Isoline]]:
    """Lines of equal distance, ascending by level. Exactly one of ``levels`` (mesh units),
    ``step`` (mesh units) and ``count`` says which levels; ``max`` is the farthest."""
    parameters = {
        "from": points_of(sources),
        "levels": None if levels is None else list(levels),
        "step": step,
        "count": count,
        "max": as_bound(max),
        **asked_by(**options),
    }
    return ask(encode(mesh, "isolines", parameters), wire.isolines_of_json, options.get("progress"))


@spelled_out
def samples(
    mesh: str,
    count: int,
    *,
    covered: PointsLike = (),
    **options: Unpack[Options],
) -> Flow[Samples]:
    """Farthest-point sampling: ``count`` vertices, each the farthest from all before it and
    from the ``covered`` points."""
    parameters = {
        "count": count,
        "from": some_points_of(covered),
        **asked_by(**options),
    }
    return ask(encode(mesh, "samples", parameters), wire.samples_of_json, options.get("progress"))


@spelled_out
def measure(
    mesh: str,
    sources: PointsLike,
    radii: float | Sequence[float] | FloatArray = (),
    *,
    max: float | None = None,
    **options: Unpack[Options],
) -> Flow[Measure]:
    """What geodesic discs measure: for each of the ``radii`` (mesh units) the area, the outline
    and the topology of all that is no farther from the nearest source; and of the whole field the
    greatest distance and the mean. Inside faces the distance is linear, as for :meth:`isolines`:
    against smooth discs the measures are off by the square of the edges' length over the radius.
    Nothing is measured, nor computed, beyond ``max``."""
    parameters = {
        "from": points_of(sources),
        "radii": np.atleast_1d(np.asarray(radii, dtype=np.float64)).tolist(),
        "max": as_bound(max),
        **asked_by(**options),
    }
    return ask(encode(mesh, "measure", parameters), wire.measure_of_json, options.get("progress"))


@spelled_out
def extent(
    mesh: str,
    of: str,
    *,
    fields: int | None = None,
    **options: Unpack[Options],
) -> Flow[Extent]:
    """How large the surface is, or where its middle is, from at most ``fields`` distance fields
    (100 without it), with what the true value is not below and not above. By ``method="exact"``
    few of them often leave no doubt.

    Args:
        of: ``"diameter"``, the greatest distance between two vertices; ``"center"``, the vertex
            from which the greatest distance is least; ``"median"``, the one from which the mean
            distance over the surface is least; ``"mean"``, the mean distance of two points;
            ``"means"``, for each vertex its mean distance over the surface.
    """
    parameters = {
        "of": of,
        "fields": fields,
        **asked_by(**options),
    }
    return ask(encode(mesh, "extent", parameters), wire.extent_of_json, options.get("progress"))


@spelled_out
def voronoi(
    mesh: str,
    sites: PointsLike,
    *,
    relax: int | None = None,
    **options: Unpack[Options],
) -> Flow[Voronoi]:
    """The geodesic Voronoi diagram of some sites: for each the area, outline and centroid of what
    is nearer to it than to the others; the bisectors between cells as lines on the surface; and
    the geodesic Delaunay triangulation, a triangle for each three cells that meet. Areas add up to
    the surface that any site reaches. A cell need hold no vertex. By ``method="exact"``, where the
    surface can be laid flat, bisectors between points are right to rounding.

    Args:
        sites: points, which may carry offsets, and curves, boundaries and faces.
        relax: rounds of Lloyd's algorithm before, each of which moves the sites to the centroids
            of their cells: they spread evenly. All sites are points then.
    """
    parameters = {
        "from": points_of(sites),
        "relax": relax,
        **asked_by(**options),
    }
    return ask(encode(mesh, "voronoi", parameters), wire.voronoi_of_json, options.get("progress"))
