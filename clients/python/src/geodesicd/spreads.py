"""Queries about how distances spread over the whole surface: isolines, samples, discs, extents
and cells.
The same holds of them as of those of :mod:`geodesicd.queries`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from . import wire
from .costs import Costs, costing
from .encoding import as_bound, computed_by, encode
from .flows import Flow, Progress, ask
from .points import PointsLike, points_of, some_points_of
from .results import Extent, FloatArray, Isoline, Measure, Samples, Voronoi
from .surface_regions import RegionsLike, WallsLike, kept_to


def isolines(
    mesh: str,
    sources: PointsLike,
    *,
    levels: Sequence[float] | FloatArray | None = None,
    step: float | None = None,
    count: int | None = None,
    max: float | None = None,
    method: str | None = None,
    points_per_edge: int | None = None,
    bound: str | None = None,
    tolerance: float | None = None,
    within: RegionsLike | None = None,
    forbid: RegionsLike | None = None,
    walls: WallsLike | None = None,
    costs: Costs | None = None,
    deadline: float | None = None,
    progress: Progress | None = None,
) -> Flow[list[Isoline]]:
    """Lines of equal distance, ascending by level. Exactly one of ``levels`` (mesh units),
    ``step`` (mesh units) and ``count`` says which levels; ``max`` is the farthest."""
    parameters = {
        "from": points_of(sources),
        "levels": None if levels is None else list(levels),
        "step": step,
        "count": count,
        "max": as_bound(max),
        **computed_by(method, points_per_edge, bound, tolerance, deadline),
        **kept_to(within, forbid, walls),
        **costing(costs),
    }
    return ask(encode(mesh, "isolines", parameters), wire.isolines_of_json, progress)


def samples(
    mesh: str,
    count: int,
    *,
    covered: PointsLike = (),
    method: str | None = None,
    points_per_edge: int | None = None,
    bound: str | None = None,
    tolerance: float | None = None,
    within: RegionsLike | None = None,
    forbid: RegionsLike | None = None,
    walls: WallsLike | None = None,
    deadline: float | None = None,
    progress: Progress | None = None,
) -> Flow[Samples]:
    """Farthest-point sampling: ``count`` vertices, each the farthest from all before it and
    from the ``covered`` points."""
    parameters = {
        "count": count,
        "from": some_points_of(covered),
        **computed_by(method, points_per_edge, bound, tolerance, deadline),
        **kept_to(within, forbid, walls),
    }
    return ask(encode(mesh, "samples", parameters), wire.samples_of_json, progress)


def measure(
    mesh: str,
    sources: PointsLike,
    radii: float | Sequence[float] | FloatArray = (),
    *,
    max: float | None = None,
    method: str | None = None,
    points_per_edge: int | None = None,
    bound: str | None = None,
    tolerance: float | None = None,
    within: RegionsLike | None = None,
    forbid: RegionsLike | None = None,
    walls: WallsLike | None = None,
    deadline: float | None = None,
    progress: Progress | None = None,
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
        **computed_by(method, points_per_edge, bound, tolerance, deadline),
        **kept_to(within, forbid, walls),
    }
    return ask(encode(mesh, "measure", parameters), wire.measure_of_json, progress)


def extent(
    mesh: str,
    of: str,
    *,
    fields: int | None = None,
    method: str | None = None,
    points_per_edge: int | None = None,
    bound: str | None = None,
    tolerance: float | None = None,
    within: RegionsLike | None = None,
    forbid: RegionsLike | None = None,
    walls: WallsLike | None = None,
    deadline: float | None = None,
    progress: Progress | None = None,
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
        **computed_by(method, points_per_edge, bound, tolerance, deadline),
        **kept_to(within, forbid, walls),
    }
    return ask(encode(mesh, "extent", parameters), wire.extent_of_json, progress)


def voronoi(
    mesh: str,
    sites: PointsLike,
    *,
    relax: int | None = None,
    method: str | None = None,
    points_per_edge: int | None = None,
    bound: str | None = None,
    tolerance: float | None = None,
    within: RegionsLike | None = None,
    forbid: RegionsLike | None = None,
    walls: WallsLike | None = None,
    deadline: float | None = None,
    progress: Progress | None = None,
) -> Flow[Voronoi]:
    """The geodesic Voronoi diagram of some sites: for each the area, outline and centroid of what
    is nearer to it than to the others; the bisectors between cells as lines on the surface; and
    the geodesic Delaunay triangulation, a triangle for each three cells that meet. Areas add up to
    the surface that any site reaches. A cell need hold no vertex. By ``method="exact"``, where the
    surface can be laid flat, bisectors are right to rounding.

    Args:
        relax: rounds of Lloyd's algorithm before, each of which moves the sites to the centroids
            of their cells: they spread evenly.
    """
    parameters = {
        "from": points_of(sites),
        "relax": relax,
        **computed_by(method, points_per_edge, bound, tolerance, deadline),
        **kept_to(within, forbid, walls),
    }
    return ask(encode(mesh, "voronoi", parameters), wire.voronoi_of_json, progress)
