#!/usr/bin/env python3
"""Draws docs/walls.png: the terrain with a fence, the way that went through it and the one round its
end; beside it the isolines round the start, which bend round both ends of the fence.

    draw_walls.py SERVER

SERVER is the address of one that has the sample meshes (`make run`). Needs numpy and matplotlib.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection, PolyCollection

from page_pictures import geometry_of, get_json, light_on, sample_at, save

FROM, TO = "ray:33,99,-55,0,-1,0", "ray:78,99,-45,0,-1,0"
# Posts of the fence, x and z.
POSTS = [(62, -88), (54, -68), (52, -40), (60, -22)]
WALL = ";".join(f"ray:{x},99,{z},0,-1,0" for x, z in POSTS)
LIGHT = (-0.5, 0.75, -0.43)


def ground(axes, corners):
    """The faces from above, shaded by their slopes."""
    shades = np.array([[0.86, 0.84, 0.78]]) * light_on(corners, LIGHT, 0.45, 0.55)
    axes.add_collection(
        PolyCollection(corners[:, :, ::2], facecolors=shades, edgecolors=shades, lw=0.2)
    )
    axes.set_xlim(10, 110)
    axes.set_ylim(-5, -105)
    axes.set_aspect("equal")
    axes.set_axis_off()


def draw(axes, points, style, colour, width=1.8):
    """A path from above."""
    x, _, z = np.array([point["xyz"] for point in points]).T
    axes.plot(x, z, style, color=colour, lw=width, solid_capstyle="round")


def main():
    """Both panels."""
    mesh = sample_at(sys.argv[1], "terrain.glb")
    positions, triangles = geometry_of(mesh)
    corners = positions[triangles]
    ends = f"from={FROM}&to={TO}&method=exact"
    through = get_json(f"{mesh}/path?{ends}")
    round_it = get_json(f"{mesh}/path?{ends}&walls={WALL}")
    posts = WALL.split(";")
    via = "".join(f"&via={post}" for post in posts[1:-1])
    fence = get_json(f"{mesh}/path?from={posts[0]}{via}&to={posts[-1]}&method=exact")
    lines = get_json(f"{mesh}/isolines?from={FROM}&method=exact&step=5&walls={WALL}")

    figure = plt.figure(figsize=(9, 4.5))
    for left in (0, 0.5):
        axes = figure.add_axes((left, 0.005, 0.495, 0.99))
        ground(axes, corners)
        if left:
            axes.add_collection(
                LineCollection(
                    [np.array(line["points"])[:, ::2] for line in lines["isolines"]],
                    colors="#2b5d8c",
                    linewidths=0.8,
                )
            )
        else:
            draw(axes, through["points"], ":", "#222222")
            draw(axes, round_it["points"], "-", "#D55E00")
        draw(axes, fence["points"], "-", "black", 3)
        for end in (0, -1) if not left else (0,):
            x, _, z = round_it["points"][end]["xyz"]
            axes.plot(x, z, "o", color="#D55E00", ms=5)
    save(figure, "walls.png")


if __name__ == "__main__":
    main()
