"""A mesh and what was computed on it as objects of trimesh and PyVista, or as a picture by
matplotlib. Those libraries are only imported by who asks for them."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .flows import Flow
from .queries import geometry
from .results import Bisector, Float64, Isoline, Loop, Path, SurfacePoint, Trace

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_UNREACHED = (184, 184, 184, 255)


def library(name: str) -> Any:
    """A library that is not required.

    Raises:
        ImportError: it is not installed; the message says how to.
    """
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise ImportError(f"this needs {name}: pip install {name} ({error})") from None


def _checked(field: NDArray[Any], vertices: int) -> NDArray[Any]:
    values = np.asarray(field)
    if values.shape != (vertices,):
        raise ValueError(f"a field has the shape ({vertices},), not {values.shape}")
    return values


def to_trimesh(
    mesh: str, field: NDArray[Any] | None = None, *, colormap: str = "viridis"
) -> Flow[Any]:
    """The mesh as a ``trimesh.Trimesh``, with vertices and faces in the order of the file.

    Args:
        field: (vertices,) numbers, which become the attribute ``distance`` of the vertices, and
            their colours; grey where infinite.
        colormap: one of matplotlib's; red to green where that is not installed.

    Raises:
        ImportError: trimesh is not installed. ValueError: the field is of another mesh.
    """
    trimesh = library("trimesh")
    positions, triangles = yield from geometry(mesh)
    made = trimesh.Trimesh(positions, triangles, process=False)
    if field is not None:
        values = _checked(field, len(positions))
        made.vertex_attributes["distance"] = values
        reached = np.isfinite(values)
        colours = np.tile(np.array(_UNREACHED, dtype=np.uint8), (len(values), 1))
        if reached.any():
            try:
                colours[reached] = trimesh.visual.interpolate(values[reached], colormap)
            except ImportError:
                colours[reached] = trimesh.visual.linear_color_map(values[reached])
        made.visual.vertex_colors = colours
    return made


def to_pyvista(mesh: str, /, field: NDArray[Any] | None = None, **more: NDArray[Any]) -> Flow[Any]:
    """The mesh as a ``pyvista.PolyData``, with points and faces in the order of the file.

    Args:
        field: (vertices,) numbers, which become the active point data ``distance``; NaN where
            infinite, since PyVista draws those in a colour of their own.
        more: other arrays (vertices,) by their names, such as ``labels=``.

    Raises:
        ImportError: PyVista is not installed. ValueError: an array is of another mesh.
    """
    pyvista = library("pyvista")
    positions, triangles = yield from geometry(mesh)
    made = pyvista.PolyData.from_regular_faces(positions, triangles)
    for name, values in more.items():
        made.point_data[name] = _checked(values, len(positions))
    if field is not None:
        values = _checked(field, len(positions))
        made.point_data["distance"] = np.where(np.isfinite(values), values, np.nan)
        made.set_active_scalars("distance")
    return made


def draw(
    mesh: str,
    /,
    field: NDArray[Any],
    *,
    isolines: Sequence[Isoline] = (),
    path: Path | None = None,
    lines: Sequence[Loop | Trace | Bisector] = (),
    sources: Sequence[SurfacePoint] = (),
    **options: Any,
) -> Flow[Figure]:
    """A picture of a field, (vertices,), by matplotlib: ``mesh.draw(field).savefig("f.png")``.

    Args:
        isolines, path, sources: drawn on it.
        lines: loops, traces and bisectors, such as ``voronoi(sites).bisectors``; likewise.
        options: those of :func:`geodesicd.plot.draw`: ``title``, ``view``, ``up``, ``colormap``,
            ``size``, ``dpi``, ``label`` and ``smooth``.

    Raises:
        ImportError: matplotlib is not installed. ValueError: the field is of another mesh.
    """
    from .plot import draw as drawn

    shape = yield from geometry(mesh)
    values = _checked(field, len(shape.positions))
    polylines = [_polyline(line) for line in lines]
    return drawn(
        shape, values, isolines=isolines, path=path, lines=polylines, sources=sources, **options
    )


def _polyline(line: Path | Loop | Trace | Isoline | Bisector) -> Float64:
    return line.polyline if isinstance(line, Isoline | Bisector) else line.points


def line_to_trimesh(line: Path | Loop | Trace | Isoline | Bisector) -> Any:
    """A line as a ``trimesh.path.Path3D``."""
    return library("trimesh").load_path(_polyline(line))


def line_to_pyvista(line: Path | Loop | Trace | Isoline | Bisector) -> Any:
    """A line as a ``pyvista.PolyData`` of one polyline."""
    pyvista = library("pyvista")
    points = _polyline(line)
    if len(points) < 2:
        return pyvista.PolyData(points)
    return pyvista.PolyData(points, lines=np.array([len(points), *range(len(points))]))
