#!/usr/bin/env python3
"""Draws docs/curves.png: on the terrain from above, the curves at equal distances from a curve and
from the boundary, with the shortest ways from places to them.

    draw_curves.py SERVER

SERVER is the address of one that has the sample meshes (`make run`). Needs numpy and matplotlib.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection, PolyCollection

from page_pictures import geometry_of, get_json, light_on, sample_at, save

CURVE = "curve:ray:30,99,-40,0,-1,0;ray:90,99,-60,0,-1,0;ray:110,99,-130,0,-1,0;ray:150,99,-140,0,-1,0"
PLACES = ((55, -85), (130, -70), (60, -150))
LIGHT = (-0.5, 0.75, -0.43)


def ground(axes, corners):
    """Faces from above, shaded by their slopes."""
    shades = np.array((0.86, 0.86, 0.8)) * light_on(corners, LIGHT, 0.45, 0.55)
    axes.add_collection(
        PolyCollection(corners[:, :, ::2], facecolors=shades, edgecolors=shades, lw=0.2)
    )
    axes.set_xlim(-1, 180)
    axes.set_ylim(1, -180)
    axes.set_aspect("equal")
    axes.set_axis_off()


def offset_curves(axes, mesh, source, step):
    """The lines at each multiple of `step`, the farther the lighter."""
    asked = f"from={source}&method=exact&step={step}"
    found = get_json(f"{mesh}/isolines?{asked}")
    for line in found["isolines"]:
        points = [*line["points"], *line["points"][: line["closed"]]]
        shade = plt.colormaps["viridis"](line["level"] / found["max"])
        axes.add_collection(LineCollection([np.array(points)[:, ::2]], colors=[shade], lw=1.0))


def ways(axes, mesh, source):
    """From each of the places to what is nearest of the source."""
    for x, z in PLACES:
        path = get_json(f"{mesh}/path?from={source}&to=ray:{x},99,{z},0,-1,0&method=exact")
        points = np.array([point["xyz"] for point in path["points"]])
        axes.plot(points[:, 0], points[:, 2], color="#c2185b", lw=1.8)
        axes.plot(points[-1, 0], points[-1, 2], "o", color="#c2185b", ms=5)


def main():
    """Both panels."""
    mesh = sample_at(sys.argv[1], "terrain.glb")
    positions, triangles = geometry_of(mesh)
    figure, panels = plt.subplots(1, 2, figsize=(9, 4.7))
    figure.subplots_adjust(0.01, 0.01, 0.99, 0.93, 0.03)
    stops = CURVE.removeprefix("curve:").split(";")
    for axes, source, step, label in (
        (panels[0], CURVE, 10, "from a curve"),
        (panels[1], "boundary:0", 10, "from the boundary"),
    ):
        ground(axes, positions[triangles])
        offset_curves(axes, mesh, source, step)
        ways(axes, mesh, source)
        axes.set_title(label, fontsize=10)
    for one, other in zip(stops, stops[1:]):
        points = get_json(f"{mesh}/path?from={one}&to={other}&method=exact")["points"]
        line = np.array([point["xyz"] for point in points])
        panels[0].plot(line[:, 0], line[:, 2], color="black", lw=2.4)
    rim = ((0, 0), (179, 0), (179, -179), (0, -179), (0, 0))
    panels[1].plot(*np.array(rim).T, color="black", lw=2.4)
    save(figure, "curves.png")


if __name__ == "__main__":
    main()
