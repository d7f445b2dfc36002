#!/usr/bin/env python3
"""Draws the figures of the report from what paper_report wrote.

    draw_figures.py FOLDER

Reads FOLDER/*.csv and FOLDER/arrays, writes FOLDER/*.png. Needs numpy and
matplotlib.
"""

import csv
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "bench"))
from plot_style import draw_error_against_time, plt, save  # noqa: E402

from matplotlib.collections import LineCollection  # noqa: E402
from matplotlib.colors import SymLogNorm  # noqa: E402
from matplotlib.ticker import FuncFormatter  # noqa: E402

FOLDER = pathlib.Path(sys.argv[1])
ARRAYS = FOLDER / "arrays"
PATH_COLOUR = "#d62728"


def table(name):
    """The rows of a CSV file, as dictionaries of text."""
    with open(FOLDER / f"{name}.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def surface(name):
    """Positions (n, 3) and faces (m, 3)."""
    positions = np.fromfile(ARRAYS / f"{name}.positions.f64").reshape(-1, 3)
    faces = np.fromfile(ARRAYS / f"{name}.faces.u32", "<u4").reshape(-1, 3)
    return positions, faces.astype(int)


def values(name):
    """One number a vertex."""
    return np.fromfile(ARRAYS / f"{name}.f64", "<f8")


def colours(axes, name, shown, **how):
    """A field over a plane, seen from above."""
    positions, faces = surface(name)
    shown = np.where(np.isfinite(shown), shown, 0)  # vertices inside holes, in no face
    image = axes.tripcolor(
        positions[:, 0], positions[:, 1], faces, shown, shading="gouraud", rasterized=True, **how
    )
    axes.set_aspect("equal")
    return image


def isolines(axes, name, **how):
    """The isolines that core computed."""
    points = np.fromfile(ARRAYS / f"{name}.isolines.f64").reshape(-1, 3)
    axes.plot(points[:, 0], points[:, 1], **how)
    axes.set_aspect("equal")


def outline(axes, name):
    """The boundary of a plane, holes included: edges that are in one face only."""
    positions, faces = surface(name)
    edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges, count = np.unique(edges, axis=0, return_counts=True)
    lines = positions[edges[count == 1], :2]
    axes.add_collection(LineCollection(lines, color="k", lw=1.2, antialiased=False))


def path(axes, name):
    """The geodesic polyline, with its ends."""
    points = np.array([[float(row["x"]), float(row["y"])] for row in table(f"{name}_path")])
    axes.plot(points[:, 0], points[:, 1], color="white", lw=4.2, solid_capstyle="round")
    axes.plot(points[:, 0], points[:, 1], color=PATH_COLOUR, lw=2.2, solid_capstyle="round")
    for end in (points[0], points[-1]):
        axes.plot(*end, "o", color=PATH_COLOUR, mec="white", mew=1.2, ms=9, clip_on=False, zorder=5)


def colour_bar(figure, image, axes, label, **how):
    """A slim colour bar, without a frame."""
    bar = figure.colorbar(image, ax=axes, shrink=how.pop("shrink", 0.8), pad=0.03, **how)
    bar.outline.set_visible(False)
    bar.set_label(label)
    return bar


def bare(axes, title):
    """A panel without axes: only what is drawn, and its title."""
    axes.set_axis_off()
    axes.set_title(title)


def figure_5():
    """The plane: mesh and isolines, colours, error."""
    figure, (left, centre, right) = plt.subplots(1, 3, figsize=(11.6, 3.7), layout="constrained")
    isolines(left, "fig5", color="#0072B2", lw=1.1)
    # The mesh is too fine to be seen; a corner of it is not.
    inset = left.inset_axes((0.57, 0.5, 0.4, 0.4))
    positions, faces = surface("fig5")
    inset.triplot(positions[:, 0], positions[:, 1], faces, color="0.35", lw=0.6)
    corner = 8.0 / (np.sqrt(len(positions)) - 1)
    inset.set(xlim=(0, corner), ylim=(0, corner), xticks=[], yticks=[], aspect="equal")
    for spine in inset.spines.values():
        spine.set_visible(True)
    inset.set_title("the mesh", fontsize=9, pad=2).set_bbox({"color": "white", "pad": 1})
    image = colours(centre, "fig5", values("fig5.distance"), cmap="viridis")
    colour_bar(figure, image, centre, "distance")
    error = values("fig5.error") * 1e16
    limit = np.abs(error).max()
    image = colours(right, "fig5", error, cmap="RdBu_r", vmin=-limit, vmax=limit)
    colour_bar(figure, image, right, "distance − true distance, $10^{-16}$")
    for axes, title in (
        (left, "(a) isolines"),
        (centre, "(b) the distance field"),
        (right, "(c) its error"),
    ):
        axes.set_title(title)
        axes.set_xlabel("x")
        axes.set_xlim(0, 1)
        axes.set_ylim(0, 1)
        axes.set_xticks([0, 0.5, 1])
        axes.set_yticks([0, 0.5, 1])
    left.set_ylabel("y")
    save(figure, FOLDER / "fig5.png")


def plane_with_path(axes, name):
    """Colours, isolines, holes and path; returns the colours for a colour bar."""
    image = colours(axes, name, values(f"{name}.distance"), cmap="viridis")
    isolines(axes, name, color="black", lw=0.6, alpha=0.6)
    outline(axes, name)
    path(axes, name)
    return image


def figure_6():
    """A hole in the plane: isolines, and colours with the path."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.6), layout="constrained")
    isolines(left, "fig6", color="#0072B2", lw=1.1)
    outline(left, "fig6")
    image = plane_with_path(right, "fig6")
    colour_bar(figure, image, right, "distance, in edges of the grid")
    bare(left, "(a) isolines")
    bare(right, "(b) the field and the path")
    save(figure, FOLDER / "fig6.png")


def figure_7():
    """Two holes, then a third one that sends the path to the other side."""
    figure, axes = plt.subplots(1, 2, figsize=(10.4, 4.6), layout="constrained")
    for panel, name, title in zip(
        axes, ("fig7a", "fig7b"), ("(a) two holes: below", "(b) a third one: above")
    ):
        image = plane_with_path(panel, name)
        bare(panel, title)
    colour_bar(figure, image, axes, "distance, in edges of the grid", shrink=0.85)
    save(figure, FOLDER / "fig7.png")


def figure_8():
    """The body that paper_report rendered, with a scale beside it."""
    picture = plt.imread(ARRAYS / "fig8.png")[:, :, :3]
    # The renderer's own scale stands apart on the right: keep the widest block of
    # columns that have ink.
    ink = np.flatnonzero((picture < 0.999).any(axis=(0, 2)))
    blocks = np.split(ink, np.flatnonzero(np.diff(ink) > 1) + 1)
    widest = max(blocks, key=len)
    rows = np.flatnonzero((picture[:, widest] < 0.999).any(axis=(1, 2)))
    picture = picture[rows[0] : rows[-1] + 1, widest[0] : widest[-1] + 1]
    near = np.mean(picture[..., 2] > picture[..., 0] + 0.1)  # blue
    far = np.mean(picture[..., 0] > picture[..., 2] + 0.2)  # yellow
    if min(near, far) < 0.01:
        raise SystemExit("fig. 8: the body lacks the colours of its distances")
    height, width = picture.shape[:2]
    figure = plt.figure(figsize=(8.6, 7.4 * height / width))
    axes = figure.add_axes((0, 0, 0.86, 1))
    axes.imshow(picture, interpolation="lanczos")
    axes.set_axis_off()
    greatest = float(table("fig8")[0]["greatest_distance"])
    scale = plt.cm.ScalarMappable(plt.Normalize(0, greatest), "viridis")
    bar = figure.colorbar(scale, cax=figure.add_axes((0.89, 0.12, 0.022, 0.76)))
    bar.outline.set_visible(False)
    bar.set_label("distance from the top of the nose, mesh units")
    save(figure, FOLDER / "fig8.png")


def percent(value, _position=None):
    """A tick of a signed logarithmic scale, in per cent."""
    return "0" if value == 0 else f"{100 * value:+g} %".replace("-", "−")


def novotni():
    """Where the two cases decide, and the signed relative errors of both rules."""
    figure, axes = plt.subplots(2, 3, figsize=(11.2, 7.2), layout="constrained")
    for row, (name, title) in zip(
        axes, (("plane_three_holes", "plane with three holes"), ("terrain", "terrain"))
    ):
        name = f"novotni.{name}"
        positions, _ = surface(name)
        bent = values(f"{name}.bent") > 0
        row[0].scatter(*positions[bent, :2].T, s=24000 / len(positions), color="black", lw=0)
        outline(row[0], name)
        low, high = positions.min(axis=0), positions.max(axis=0)
        margin = 0.05 * (high - low)  # as colours() leaves
        row[0].set_xlim(low[0] - margin[0], high[0] + margin[0])
        row[0].set_ylim(low[1] - margin[1], high[1] + margin[1])
        row[0].set_aspect("equal")
        bare(row[0], f"{title}:\ncases (b) and (c)")
        theirs, ours = (values(f"{name}.{which}") for which in ("theirs", "ours"))
        limit = max(np.nanmax(np.abs(theirs)), np.nanmax(np.abs(ours)))
        norm = SymLogNorm(linthresh=1e-4, vmin=-limit, vmax=limit, base=10)
        for panel, shown, whose in zip(row[1:], (theirs, ours), ("novotni", "wavefront")):
            image = colours(panel, name, shown, cmap="RdBu_r", norm=norm)
            outline(panel, name)
            bare(panel, f"error of\n{whose}")
        bar = colour_bar(figure, image, row, "relative error", shrink=0.9)
        powers = [10.0**k for k in (-4, -3, -2, -1) if 10.0**k <= limit]
        bar.set_ticks([-p for p in reversed(powers)] + [0] + powers)
        bar.ax.yaxis.set_major_formatter(FuncFormatter(percent))
        bar.ax.yaxis.set_minor_locator(plt.NullLocator())
    save(figure, FOLDER / "novotni.png")


def every_method():
    """Error against time, over all meshes."""
    rows = [
        (row["method"], row["mesh"], float(row["y"]), float(row["mean_error"]))
        for row in table("table")
    ]
    meshes = len({row[1] for row in rows})
    draw_error_against_time(
        rows, FOLDER / "every_method.png", f"every method on {meshes} meshes: a small dot is one mesh"
    )


def main():
    """All of them."""
    figure_5()
    figure_6()
    figure_7()
    figure_8()
    novotni()
    every_method()


if __name__ == "__main__":
    main()
