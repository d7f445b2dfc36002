"""A picture of a distance field with isolines and a path, by matplotlib (install
the extra ``plot``): shaded, what is behind hidden, with a colour bar in mesh units.

    from geodesicd.plot import plot
    plot(mesh, 0, target=9999).savefig("field.png")
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from .client import Mesh
from .costs import Costs
from .encoding import milliseconds
from .flows import Progress
from .points import Point, PointLike, PointsLike, points_of, some_points_of
from .queries import Refine
from .raster import Camera, Seen, corner_normals, render
from .results import Float64, FloatArray, Geometry, Isoline, Path, SurfacePoint
from .surface_regions import RegionsLike, WallsLike
from .wire import surface_point

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

View = tuple[float, float]
_SIDES: dict[str, View] = {
    "front": (0, 0),
    "back": (180, 0),
    "right": (90, 0),
    "left": (-90, 0),
    "top": (0, 90),
    "bottom": (0, -90),
    "corner": (35, 25),
}
_PATH, _LINE, _INK = "#d81e5b", "#0a8f82", "#1b1b1e"


def plot(
    mesh: Mesh,
    sources: PointsLike,
    *,
    target: PointLike | None = None,
    via: PointsLike = (),
    method: str | None = None,
    bound: str | None = None,
    tolerance: float | None = None,
    deadline: float | None = None,
    refine: Refine | None = None,
    within: RegionsLike | None = None,
    forbid: RegionsLike | None = None,
    walls: WallsLike | None = None,
    costs: Costs | None = None,
    signed: bool = False,
    isolines: int = 12,
    view: str | View | None = None,
    up: Literal["y", "z"] = "y",
    colormap: str | None = None,
    title: str | None = None,
    size: tuple[float, float] = (10, 7.5),
    dpi: int = 150,
    progress: Progress | None = None,
) -> Figure:
    """Asks for the field, its isolines and, with ``target``, the path, and draws them.

    Args:
        sources: points, curves, boundaries and faces; a path starts at the first of them.
        method: how distances are computed; without it the server's default, which the title names.
        bound, tolerance: for ``method="auto"``, of the field and its isolines.
        deadline: seconds, after which a query raises DeadlineExceeded; each has as many.
        within, forbid, walls: the part of the surface that the answers are about
            (:mod:`geodesicd.surface_regions`).
        costs: what ways cost instead of their length (:mod:`geodesicd.costs`).
        via, refine: of the path, as of :meth:`geodesicd.Mesh.path`.
        signed: distances are below 0 inside the one closed curve that is the source.
        isolines: how many, evenly spaced; 0 for none. With ``signed`` they are on both sides.
        view: ``"front"``, ``"back"``, ``"left"``, ``"right"``, ``"top"``, ``"bottom"``,
            ``"corner"`` or (azimuth, elevation) in degrees; without it from a corner, or
            straight at a flat mesh.
        up: which axis is up in the picture.
        colormap: any of matplotlib's; without it viridis, and RdBu_r where some are below 0.
        title: what to call the mesh.
        size: inches. dpi: pixels an inch.
        progress: called with the part of the field that is done.

    Raises:
        GeodesicError: from the server. ImportError: matplotlib is not installed. ValueError: there
            is no such view or colormap, or ``via`` or ``refine`` without a ``target``.
    """
    if target is None and (some_points_of(via) or refine is not None):
        raise ValueError("via and refine are for a path: give a target")
    view = view_angles(view)
    _check_colormap(colormap)
    kept: dict[str, Any] = {"within": within, "forbid": forbid, "walls": walls}
    exactness: dict[str, Any] = {"method": method, "bound": bound, "tolerance": tolerance}
    points = points_of(sources)
    # A frame, because it says by which method: a bare array does not.
    asked = {"from": points, "signed": signed or None, "costs": costs, **exactness, **kept}
    asked["deadline_ms"] = milliseconds(deadline)
    kept["deadline"] = deadline
    answer = mesh.query("distance", asked, format="frame", progress=progress)
    field = answer.arrays["distances"]
    told = answer.document or {}
    used = str(told.get("method", method or ""))
    found = [surface_point(point) for point in told["from"]]
    finite = np.isfinite(field).any() and field[np.isfinite(field)].max() > 0
    levels = (
        mesh.isolines(sources, count=isolines, costs=costs, **exactness, **kept)
        if isolines and finite
        else []
    )
    path = None
    if target is not None:
        start = points[0] if found[0].kind else found[0]  # of points, where they are: no offset
        path = mesh.path(start, target, via=via, method=method, refine=refine, costs=costs, **kept)
    return draw(
        mesh.geometry(),
        field,
        isolines=levels,
        path=path,
        lines=_curves(mesh, points, kept),
        sources=[point for point in found if not point.kind],
        title=_title(mesh, title, used, path),
        label=_label(told.get("unit"), signed),
        view=view,
        up=up,
        colormap=colormap,
        size=size,
        dpi=dpi,
    )


def _curves(mesh: Mesh, sources: Sequence[Point], kept: dict[str, Any]) -> list[Float64]:
    """The curves among sources, as lines."""
    found = []
    for source in sources:
        text = source.text() or ""
        if text.startswith("curve:"):
            corners = text.removeprefix("curve:").split(";")
            if corners[0] == "closed":
                corners = [*corners[1:], corners[1]]
            ends = corners[0], corners[-1]
            found.append(mesh.path(*ends, via=corners[1:-1], method="exact", **kept).points)
    return found


def view_angles(view: str | View | None) -> View | None:
    """Azimuth and elevation in degrees; None without a view.

    Raises:
        ValueError: there is none of this name, or an angle is not finite.
    """
    found = _SIDES.get(view) if isinstance(view, str) else view
    if view is not None and (found is None or not np.isfinite(found).all()):
        raise ValueError(f"view is one of {', '.join(_SIDES)} or two angles, and not {view!r}")
    return found


def _check_colormap(colormap: str | None) -> None:
    """Raises ImportError without matplotlib, and ValueError if that has no such colormap."""
    try:
        from matplotlib import colormaps
    except ImportError as error:
        raise ImportError("pictures need matplotlib: pip install matplotlib") from error
    if colormap is not None and colormap not in colormaps:
        raise ValueError(f"matplotlib has no colormap that is called {colormap!r}")


def _label(unit: str | None, signed: bool) -> str:
    """What the numbers of the field are; a unit have costs alone."""
    if unit is None:
        return f"{'signed ' * signed}distance (mesh units)"
    return {"seconds": "cost (seconds)", "length": "cost (mesh units)"}.get(unit, unit)


def _title(mesh: Mesh, name: str | None, method: str, path: Path | None) -> str:
    named = (mesh.name, *(part.name for part in mesh.parts), mesh.id[:12])
    name = name or next(one for one in named if one)
    title = f"{name} · {mesh.vertices:,} vertices · {method}"
    if path is not None:
        long = path.length if path.cost is None else path.cost
        title += f" · path {long:.5g}" if path.reachable else " · target out of reach"
        title += " s" if path.reachable and path.unit == "seconds" else ""
        if path.method != method:
            title += f" ({path.method})"
    return title


def draw(
    geometry: Geometry,
    field: FloatArray,
    *,
    isolines: Sequence[Isoline] = (),
    path: Path | None = None,
    lines: Sequence[Float64] = (),
    sources: Sequence[SurfacePoint] = (),
    title: str = "",
    label: str = "distance (mesh units)",
    smooth: bool = True,
    view: str | View | None = None,
    up: Literal["y", "z"] = "y",
    colormap: str | None = None,
    size: tuple[float, float] = (10, 7.5),
    dpi: int = 150,
) -> Figure:
    """Draws what is at hand already: ``field`` (vertices,) on ``geometry``; infinite values are
    grey. Where some are below 0, 0 is the middle of the colours. ``lines``: polylines (n, 3) on the
    surface. Without ``smooth``, a place has the value of the closest vertex: for labels, which have
    nothing in between. Other parameters as of :func:`plot`."""
    _check_colormap(colormap)
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, dpi=dpi, facecolor="white", layout="constrained")
    axes = figure.add_subplot()
    # A few more pixels than the picture has smooth the silhouettes.
    width, height = (max(64, int(side * dpi * 1.25)) for side in (size[0] * 0.86, size[1] * 0.92))
    azimuth, elevation = view_angles(view) or _default(geometry, up)
    used = geometry.positions[np.unique(geometry.triangles)]
    camera = Camera.looking(used, azimuth, elevation, up, width, height)
    seen = render(camera, geometry)

    finite = field[np.isfinite(field)]
    most = float(np.abs(finite).max()) if len(finite) and finite.any() else 1.0
    has_sides = len(finite) > 0 and finite.min() < 0
    norm = Normalize(-most if has_sides else 0.0, most)
    colormap = colormap or ("RdBu_r" if has_sides else "viridis")
    at_pixels = seen.interpolate if smooth else seen.nearest
    colours = colormaps[colormap](norm(at_pixels(geometry.triangles, np.asarray(field))))
    values = seen.interpolate(geometry.triangles, np.where(np.isfinite(field), 0.0, 1.0))
    colours[values > 1e-9, :3] = 0.72
    colours[..., :3] = _lit(colours[..., :3], _shade(camera, geometry, seen))
    colours[seen.face < 0] = (1, 1, 1, 0)
    axes.imshow(colours, interpolation="antialiased", extent=(0, width, height, 0))

    for line in isolines:
        _draw_line(axes, camera, seen, line.polyline, _INK, 0.6, alpha=0.75)
    for points in lines:
        _draw_line(axes, camera, seen, points, "white", 3.2)
        _draw_line(axes, camera, seen, points, _LINE, 1.6, hidden=True)
    if path is not None and path.reachable:
        _draw_line(axes, camera, seen, path.points, "white", 4.0)
        _draw_line(axes, camera, seen, path.points, _PATH, 2.2, hidden=True)
        _mark(axes, camera, seen, path.points[-1], "s")
    for point in sources:
        _mark(axes, camera, seen, point.xyz, "o")
    axes.set_axis_off()
    axes.set_title(title, fontsize=10, color=_INK)
    bar = figure.colorbar(ScalarMappable(norm, colormap), ax=axes, shrink=0.75, pad=0.02)
    bar.set_label(label)
    for level in {line.level for line in isolines} if smooth else ():
        for side in (level, -level) if has_sides else (level,):
            bar.ax.axhline(side, color=_INK, linewidth=0.6, alpha=0.75)
    return figure


def _default(geometry: Geometry, up: str) -> View:
    """From a corner, or straight at a mesh that is flat."""
    extent = np.ptp(geometry.positions, axis=0)
    thin = int(np.argmin(extent))
    if extent[thin] > 0.02 * extent.max():
        return _SIDES["corner"]
    if up == "z":
        return ((90, 0), (0, 0), (0, 90))[thin]
    return ((90, 0), (0, 90), (0, 0))[thin]


def _shade(camera: Camera, geometry: Geometry, seen: Seen) -> Float64:
    """(height, width) how bright each pixel is, 0 to 1, lit from the upper left, from both
    sides."""
    normal = seen.blend(corner_normals(geometry) @ camera.axes.T)
    normal /= np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-300)
    normal *= np.where(normal[..., 2:] < 0, -1, 1)
    light = np.array([-0.45, 0.55, 0.70])
    light /= np.linalg.norm(light)
    return np.asarray(np.clip(np.nan_to_num(normal @ light), 0, 1))


def _lit(colours: NDArray[Any], shade: Float64) -> NDArray[Any]:
    """Colours (…, 3) in that light: darker away from it, with a little gloss towards it."""
    ambient = 0.48 + 0.52 * shade[..., None]
    gloss = 0.18 * shade[..., None] ** 24
    return np.asarray(np.clip(colours * ambient + gloss, 0, 1))


def _draw_line(
    axes: Axes,
    camera: Camera,
    seen: Seen,
    points: Float64,
    colour: str,
    width: float,
    *,
    alpha: float = 1.0,
    hidden: bool = False,
) -> None:
    """A polyline (n, 3); what is behind the surface is dotted if ``hidden``, else left out."""
    from matplotlib.collections import LineCollection

    if len(points) < 2:
        return
    dense = _densified(points, 3 / camera.scale)
    places, _ = camera.project(dense)
    shown = seen.shows(camera, (dense[1:] + dense[:-1]) / 2)
    for visible, style in ((True, "solid"), (False, (0, (1, 1.6)))):
        runs = _runs(places, shown == visible)
        if runs and (visible or hidden):
            axes.add_collection(
                LineCollection(
                    runs,
                    colors=colour,
                    linewidths=width if visible else width * 0.7,
                    linestyles=[style],
                    alpha=alpha if visible else 0.9,
                    capstyle="round" if visible else "butt",
                    joinstyle="round",
                )
            )


def _densified(points: Float64, step: float) -> Float64:
    """The polyline with points in between, no farther apart than ``step``."""
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    pieces = np.maximum(1, np.ceil(lengths / step).astype(int))
    start = np.repeat(np.arange(len(lengths)), pieces)
    first = np.concatenate([[0], np.cumsum(pieces)[:-1]])
    part = (np.arange(pieces.sum()) - first[start]) / pieces[start]
    between = points[start] + part[:, None] * (points[start + 1] - points[start])
    return np.concatenate([between, points[-1:]])


def _runs(places: Float64, wanted: NDArray[np.bool_]) -> list[Float64]:
    """The longest runs of segments that are wanted, as polylines."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], wanted, [False]]).astype(int)))
    return [places[begin : end + 1] for begin, end in zip(edges[::2], edges[1::2], strict=True)]


def _mark(axes: Axes, camera: Camera, seen: Seen, point: Float64, marker: str) -> None:
    """A source or a target; hollow if it is behind the surface."""
    place, _ = camera.project(point[None])
    visible = bool(seen.shows(camera, point[None])[0])
    axes.plot(
        *place[0],
        marker=marker,
        markersize=8,
        markerfacecolor=_PATH if visible else "none",
        markeredgecolor="white" if visible else _PATH,
        markeredgewidth=1.4,
    )


def show(figure: Figure) -> None:
    """Shows a picture in a window and waits until it is closed.

    Raises:
        RuntimeError: this machine has no screen.
    """
    import matplotlib.pyplot as plt

    if plt.get_backend().lower() in ("agg", "pdf", "svg", "ps", "template"):
        raise RuntimeError("there is no screen here to draw on: write a file with -o")
    dummy = plt.figure()
    manager: Any = dummy.canvas.manager
    manager.canvas.figure = figure
    figure.set_canvas(manager.canvas)
    plt.show()
