"""Queries on a mesh: their parameters as requests, and how their replies are read. More of them
are in ``spreads.py``, ``tables.py`` and ``batches.py``. The first parameter of each is the mesh's
id; the methods of ``Mesh`` and ``AsyncMesh`` are made of these.

What most of them take by keyword is told in :mod:`geodesicd.options`. All raise GeodesicError.
Lengths are in mesh units. Points are given as :mod:`geodesicd.points` says.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal, TypeAlias, Unpack

import numpy as np
from numpy.typing import DTypeLike

from . import wire
from .costs import Costs
from .encoding import as_bound, as_points, encode, format_of, milliseconds
from .flows import Flow, Progress, Request, ask
from .options import CostOptions, Options, SurfaceOptions, asked_by, spelled_out
from .pieces import in_pieces
from .points import (
    Point,
    PointLike,
    PointsLike,
    Triple,
    point_of,
    points_of,
    some_points_of,
    triple,
)
from .results import (
    Answer,
    FloatArray,
    Geometry,
    LabelledDistances,
    Logmap,
    Path,
    SurfacePoint,
    Trace,
)
from .surface_regions import RegionsLike, WallsLike

Refine: TypeAlias = Literal["none", "shortest"]


@spelled_out
def distance(
    mesh: str,
    sources: PointsLike,
    *,
    max: float | None = None,
    dtype: DTypeLike = np.float64,
    quantised: bool = False,
    signed: bool = False,
    **options: Unpack[CostOptions],
) -> Flow[FloatArray]:
    """The distance field: from the nearest of the sources to every source vertex.

    Args:
        sources: points, which may carry offsets.
        max: what is farther counts as unreached; mesh units.
        dtype: float64 or float32, which is half to send.
        quantised: send 2 bytes a vertex; float32 in steps of the greatest distance / 65534.
        signed: below 0 inside ``sources``, which is one closed :class:`Curve` that separates the
            surface: on the smaller side, by area. Not ``quantised``.

    Returns:
        (vertices,) distances, infinite where unreached.
    """
    parameters = {
        "from": points_of(sources),
        "max": as_bound(max),
        "signed": signed or None,
        **asked_by(**options),
        "format": "u16" if quantised else format_of(dtype),
    }
    return ask(encode(mesh, "distance", parameters), wire.array, options.get("progress"))


@spelled_out
def regions(
    mesh: str,
    sources: PointsLike,
    *,
    max: float | None = None,
    **options: Unpack[CostOptions],
) -> Flow[LabelledDistances]:
    """The distance field and, for each vertex, which source is nearest: a geodesic Voronoi
    diagram.

    Returns:
        ``distances`` (vertices,) and ``labels`` (vertices,), places in ``sources``, -1 where
        unreached.
    """
    parameters = {
        "from": points_of(sources),
        "max": as_bound(max),
        "labels": True,
        **asked_by(**options),
        "format": "frame",
    }
    return ask(
        encode(mesh, "distance", parameters), wire.labelled_of_frame, options.get("progress")
    )


@spelled_out
def distance_at(
    mesh: str,
    sources: PointsLike,
    at: PointsLike,
    *,
    max: float | None = None,
    signed: bool = False,
    **options: Unpack[CostOptions],
) -> Flow[FloatArray]:
    """From the nearest of the sources to some points only.

    Args:
        signed: as of :func:`distance`.

    Returns:
        (n,) float64, one a point of ``at``; infinite where unreached.
    """
    asked = points_of(at)
    if not asked:  # to the server, no points are all vertices
        raise ValueError("distance_at needs at least one point")
    parameters = {
        "from": points_of(sources),
        "max": as_bound(max),
        "signed": signed or None,
        **asked_by(**options),
        "format": "f64",
    }

    def some(at: list[Point], seconds: float | None, part: Progress | None) -> Flow[FloatArray]:
        more = {"at": at, "deadline_ms": milliseconds(seconds)}
        return ask(encode(mesh, "distance", {**parameters, **more}), wire.array, part)

    found = yield from in_pieces(
        asked, "at", some, options.get("deadline"), options.get("progress")
    )
    return found[0] if len(found) == 1 else np.concatenate(found)


@spelled_out
def path(
    mesh: str,
    source: PointLike,
    target: PointLike,
    *,
    via: PointsLike = (),
    refine: Refine | None = None,
    **options: Unpack[CostOptions],
) -> Flow[Path]:
    """The shortest path between two points. One that cannot be is no error:
    ``reachable`` is false then.

    Args:
        via: points that it visits in this order.
        refine: ``"shortest"`` pulls it straight until no path near it is shorter, ``"none"`` leaves
            it as it was traced; without it the server's default, which the result's ``refine``
            names, as its ``method`` does.
        tolerance: for ``method="steiner"`` only, relative.
    """
    parameters = {
        "from": point_of(source),
        "via": some_points_of(via),
        "to": point_of(target),
        "refine": refine,
        **asked_by(**options),
        "format": "frame",
    }
    return ask(encode(mesh, "path", parameters), wire.path_of_frame, options.get("progress"))


@spelled_out
def trace(
    mesh: str,
    start: PointLike,
    length: float,
    *,
    direction: Triple | None = None,
    angle: float | None = None,
    **options: Unpack[SurfaceOptions],
) -> Flow[Trace]:
    """A straightest geodesic: straight ahead from ``start`` for ``length`` (mesh units), by a
    ``direction`` in space, (3,), projected onto the surface, or by an ``angle`` (radians, from
    the first side of the start's face)."""
    parameters = {
        "from": point_of(start),
        "direction": None if direction is None else triple(direction, "direction"),
        "angle": angle,
        "length": length,
        **asked_by(**options),
        "format": "frame",
    }
    return ask(encode(mesh, "trace", parameters), wire.trace_of_frame, options.get("progress"))


@spelled_out
def logmap(
    mesh: str,
    point: PointLike,
    radius: float | None = None,
    *,
    angle: float = 0.0,
    transport: bool = False,
    **options: Unpack[Options],
) -> Flow[Logmap]:
    """The logarithmic map: the surface round a point, laid into the plane, for decals, texture
    coordinates and patterns. :meth:`trace` by an angle and a length is its inverse, as far as the
    shortest paths are straight. Beyond the nearest point to which two shortest paths lead,
    neighbours may lie far apart. Round a vertex whose angles do not add up to a full turn, they
    are spread evenly over one.

    Args:
        radius: vertices that are farther have no place, mesh units; without it all have one that
            a path leads to.
        angle: the direction that becomes the x axis, radians, as :meth:`trace` has them.
        transport: also carry that direction along each path: ``directions``.
        tolerance: for ``method="steiner"`` only, relative.

    Raises:
        GeodesicError: also ``value_out_of_range`` with the parameter ``from``, where directions
            have no angle: where more than two faces meet, or faces in a vertex alone.
    """
    parameters = {
        "from": point_of(point),
        "radius": as_bound(radius),
        "angle": angle,
        "transport": transport or None,
        **asked_by(**options),
        "format": "frame",
    }
    return ask(encode(mesh, "logmap", parameters), wire.logmap_of_frame, options.get("progress"))


@spelled_out
def nearest(
    mesh: str,
    points: PointsLike,
    **options: Unpack[SurfaceOptions],
) -> Flow[list[SurfacePoint]]:
    """Where on the surface points are: the closest points of places in space, the first hits
    of rays."""
    common = asked_by(**options)

    def some(
        asked: list[Point], seconds: float | None, part: Progress | None
    ) -> Flow[list[SurfacePoint]]:
        parameters = {"point": asked, **common, "deadline_ms": milliseconds(seconds)}
        return ask(encode(mesh, "nearest", parameters), wire.nearest_of_json, part)

    found = yield from in_pieces(
        points_of(points), "point", some, options.get("deadline"), options.get("progress")
    )
    return [point for piece in found for point in piece]


def picture(
    mesh: str,
    sources: PointsLike,
    target: PointLike | None = None,
    *,
    via: PointsLike = (),
    width: int | None = None,
    height: int | None = None,
    view: str | tuple[float, float] | None = None,
    colormap: str | None = None,
    stripes: int | None = None,
    refine: Refine | None = None,
    method: str | None = None,
    within: RegionsLike | None = None,
    forbid: RegionsLike | None = None,
    walls: WallsLike | None = None,
    costs: Costs | None = None,
    deadline: float | None = None,
    progress: Progress | None = None,
) -> Flow[bytes]:
    """A PNG drawn by the server: the field of the sources or, with ``target``, the path there
    from the one source.

    Args:
        width, height: pixels, 64 to 2048.
        view: ``"front"``, ``"back"``, ``"left"``, ``"right"``, ``"top"``, ``"bottom"``,
            ``"corner"`` or (azimuth, elevation) in degrees.
        colormap: ``"viridis"``, ``"magma"`` or ``"turbo"``.
        stripes: into how many bands isolines divide the field; 0 for none.
        via, refine: of the path, as of :func:`path`.

    Raises:
        ValueError: ``via`` or ``refine`` without a ``target``, or several sources with one.
    """
    stops = some_points_of(via)
    if target is None and (stops or refine is not None):
        raise ValueError("via and refine are for a path: give a target")
    parameters: dict[str, Any] = {
        "from": points_of(sources),
        "width": width,
        "height": height,
        "view": view if view is None or isinstance(view, str) else f"{view[0]:g},{view[1]:g}",
        "colormap": colormap,
        "stripes": stripes,
        **asked_by(
            method=method,
            within=within,
            forbid=forbid,
            walls=walls,
            costs=costs,
            deadline=deadline,
        ),
        "format": "png",
    }
    query = "distance"
    if target is not None:
        query = "path"
        if len(parameters["from"]) != 1:
            raise ValueError("a path has one source")
        parameters["from"] = parameters["from"][0]
        parameters.update(to=point_of(target), via=stops, refine=refine)
    return ask(encode(mesh, query, parameters), wire.raw, progress)


@spelled_out
def annotated(
    mesh: str,
    sources: PointsLike,
    *,
    attribute: str | None = None,
    labels: bool = False,
    label_attribute: str | None = None,
    max: float | None = None,
    signed: bool = False,
    **options: Unpack[Options],
) -> Flow[bytes]:
    """The .glb or .gltf that was uploaded, with the distance field of the sources as an attribute
    of its vertices and all else as it was. What is not reached has -1; with ``signed`` it has the
    greatest float.

    Args:
        attribute: what it is called there, beginning with an underscore; without it
            ``_GEODESIC_DISTANCE``, or ``_GEODESIC_SIGNED_DISTANCE`` with ``signed``. The file must
            not have an attribute of that name.
        labels: with a second attribute, the place in ``sources`` of each vertex's nearest one.
        label_attribute: what that is called; without it ``_GEODESIC_SOURCE``.
        max: what is farther counts as unreached; mesh units.
        signed: as of :func:`distance`; without labels.
    """
    parameters = {
        "from": points_of(sources),
        "max": as_bound(max),
        "labels": labels or None,
        "signed": signed or None,
        **asked_by(**options),
        "attribute": attribute,
        "label_attribute": label_attribute,
        "format": "annotated",
    }
    return ask(
        encode(mesh, "distance", parameters),
        wire.raw,
        options.get("progress"),
    )


def query(
    mesh: str,
    name: str,
    parameters: Mapping[str, Any],
    *,
    format: str = "json",
    progress: Progress | None = None,
) -> Flow[Answer]:
    """Any query with the contract's own words, in any of its formats.

    Args:
        name: ``"distance"``, ``"path"``, ``"table"``, ``"isolines"``, ``"samples"``,
            ``"measure"``, ``"extent"``, ``"voronoi"``, ``"trace"``, ``"loop"``, ``"logmap"``
            or ``"nearest"``.
        parameters: by the contract's names, such as ``{"from": 0, "to": [9, (1, 2, 3)]}``.
        format: ``"json"``, ``"f32"``, ``"f64"``, ``"u16"``, ``"npy"``, ``"frame"``, ``"glb"``,
            ``"png"`` or ``"annotated"``.
    """
    given = {**as_points(parameters), "format": format}
    return ask(encode(mesh, name, given), lambda reply: wire.answer(reply, format), progress)


def geometry(mesh: str) -> Flow[Geometry]:
    """What the server computes on: ``positions`` (vertices, 3) and ``triangles`` (faces, 3),
    in the numbering of the file."""
    request = Request("GET", f"/v1/meshes/{mesh}/geometry?format=frame")
    return ask(request, wire.geometry_of_frame)


def geometry_glb(mesh: str) -> Flow[bytes]:
    """The same as the bytes of a .glb file, positions rounded to float32."""
    request = Request("GET", f"/v1/meshes/{mesh}/geometry?format=glb")
    return ask(request, wire.raw)


def source(mesh: str) -> Flow[bytes]:
    """The uploaded file's bytes."""
    request = Request("GET", f"/v1/meshes/{mesh}/source")
    return ask(request, wire.raw)
