#!/usr/bin/env python3
"""Draws docs/regions.png: the terrain with a lake that is forbidden, the way over its ground and the
way round it, and the distances that go round it.

    draw_regions.py SERVER

SERVER is the address of one that has the sample meshes (`make run`). Needs numpy and matplotlib.
"""

import sys

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection, PolyCollection

from page_pictures import geometry_of, get_json, light_on, sample_at, save

FROM, TO = "ray:33,99,-55,0,-1,0", "ray:78,99,-45,0,-1,0"
LAKE = "box:20,-72,-95,95,-44,-15"  # all of the hollow that is below -44
LIGHT = (-0.5, 0.75, -0.43)


def ground(axes, corners, colours):
    """Faces from above, shaded by their slopes."""
    cover(axes, corners, colours * light_on(corners, LIGHT, 0.45, 0.55))
    axes.set_xlim(10, 110)
    axes.set_ylim(-5, -105)
    axes.set_aspect("equal")
    axes.set_axis_off()


def cover(axes, corners, shades):
    """Faces from above in these colours."""
    axes.add_collection(
        PolyCollection(corners[:, :, ::2], facecolors=shades, edgecolors=shades, lw=0.2)
    )

def way(axes, points, style, colour):
    """A path from above."""
    x, _, z = np.array([point["xyz"] for point in points]).T
    axes.plot(x, z, style, color=colour, lw=1.8, solid_capstyle="round")
    for end in (0, -1):
        axes.plot(x[end], z[end], "o", color=colour, ms=5)


def main():
    """Both panels."""
    mesh = sample_at(sys.argv[1], "terrain.glb")
    positions, triangles = geometry_of(mesh)
    corners = positions[triangles]
    ends = f"from={FROM}&to={TO}&method=exact"
    through = get_json(f"{mesh}/path?{ends}")
    round_it = get_json(f"{mesh}/path?{ends}&forbid={LAKE}")
    field = get_json(f"{mesh}/distance?from={FROM}&method=exact&forbid={LAKE}")
    lines = get_json(f"{mesh}/isolines?from={FROM}&method=exact&step=10&forbid={LAKE}")
    distances = np.array([np.nan if d is None else d for d in field["distances"]])
    of_face = distances[triangles].mean(axis=1)
    centroids = corners.mean(axis=1)
    x0, y0, z0, x1, y1, z1 = map(float, LAKE.removeprefix("box:").split(","))
    in_lake = np.all((centroids >= (x0, y0, z0)) & (centroids <= (x1, y1, z1)), axis=1)

    figure = plt.figure(figsize=(9, 4.2))
    axes = figure.add_axes((0, 0.01, 0.5, 0.98))
    ground(axes, corners, np.array([[0.86, 0.84, 0.78]]))
    cover(axes, corners[in_lake], (0.55, 0.74, 0.90))
    way(axes, through["points"], ":", "#222222")
    way(axes, round_it["points"], "-", "#D55E00")

    axes = figure.add_axes((0.5, 0.01, 0.5, 0.98))
    colours = matplotlib.colormaps["viridis"](np.clip(of_face / 170, 0, 1))[:, :3]
    there = ~np.isnan(of_face) & ~in_lake
    ground(axes, corners[there], colours[there])
    axes.add_collection(
        LineCollection(
            [np.array(line["points"])[:, ::2] for line in lines["isolines"]],
            colors="white",
            linewidths=0.6,
        )
    )
    way(axes, round_it["points"], "-", "#D55E00")
    save(figure, "regions.png")


if __name__ == "__main__":
    main()
