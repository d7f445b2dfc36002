#!/usr/bin/env python3
"""Draws docs/curves.png: the terrain from above with isolines of the distances from a curve and
from the boundary, and the shortest paths from these to some places.

    draw_curves.py SERVER

SERVER is the address of one that has the sample meshes (`make run`). Needs numpy and matplotlib.
"""

import sys

import matplotlib.pyplot as plt

from page_pictures import (
    draw_ground,
    draw_isolines,
    draw_way,
    geometry_of,
    get_json,
    sample_at,
    save,
)

# The curve of docs/curves.md.
STOPS = ("ray:30,99,-40,0,-1,0", "ray:90,99,-60,0,-1,0", "ray:110,99,-130,0,-1,0")


def ways(axes, mesh, source, places):
    """To each of the places from what is nearest of the source."""
    for x, z in places:
        path = get_json(f"{mesh}/path?from={source}&to=ray:{x},99,{z},0,-1,0&method=exact")
        draw_way(axes, path, "-", "#D55E00", ends=(-1,))


def main():
    """Both panels."""
    mesh = sample_at(sys.argv[1], "terrain.glb")
    positions, triangles = geometry_of(mesh)
    figure, panels = plt.subplots(1, 2, figsize=(9, 4.7))
    figure.subplots_adjust(0.01, 0.01, 0.99, 0.93, 0.03)
    curve = "curve:" + ";".join(STOPS)
    for axes, source, places, label in (
        (panels[0], curve, ((55, -85), (130, -70), (20, -115)), "from a curve"),
        (panels[1], "boundary:0", ((55, -85), (30, -45), (85, -50)), "from the boundary"),
    ):
        draw_ground(axes, positions, triangles)
        found = get_json(f"{mesh}/isolines?from={source}&method=exact&step=15")
        draw_isolines(axes, found, "#0072B2", 1.2)
        ways(axes, mesh, source, places)
        axes.set_title(label, fontsize=10)
        axes.set_xlim(-1, 136)
        axes.set_ylim(1, -136)
    drawn = get_json(f"{mesh}/path?from={STOPS[0]}&via={STOPS[1]}&to={STOPS[2]}&method=exact")
    draw_way(panels[0], drawn, "-", "black", 3, ends=())
    rim = ((0, 0), (179, 0), (179, -179), (0, -179), (0, 0))
    panels[1].plot(*zip(*rim), color="black", lw=3)
    save(figure, "curves.png")


if __name__ == "__main__":
    main()
