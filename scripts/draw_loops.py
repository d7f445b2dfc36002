#!/usr/bin/env python3
"""Draws docs/loops.png: a loop round the holes of a plane before and after it is tightened, and the
girths of a torus knot.

    draw_loops.py SERVER

SERVER is the address of one that has the sample meshes (`make run`). Needs numpy and matplotlib.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import PolyCollection
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

from page_pictures import geometry_of, get_json, light_on, sample_at, save, show_from_above

CORNERS = ("p:2,2,0", "p:97,2,0", "p:97,97,0", "p:2,97,0")  # of the plane with holes
PLACES = 27  # along the knot


def points_of(reply):
    """(n, 3) of a loop or a path."""
    return np.array([point["xyz"] for point in reply["points"]])


def draw_holes(axes, address):
    """The plane, the paths between the corners, and what they become."""
    positions, triangles = geometry_of(address)
    corners = positions[triangles][:, :, :2]
    axes.add_collection(PolyCollection(corners, facecolors="#E4E7EB", edgecolors="#E4E7EB", lw=0.3))
    through = "&".join(f"through={place}" for place in CORNERS)
    start = points_of(get_json(f"{address}/loop?{through}&method=exact"))
    axes.plot(*start[:, :2].T, "--", color="0.45", lw=1.2)
    around = "&".join(f"around={place}" for place in CORNERS)
    tight = get_json(f"{address}/loop?{around}&method=exact")
    axes.plot(*points_of(tight)[:, :2].T, color="#D55E00", lw=2)
    axes.set_xlim(-1, 100)
    axes.set_ylim(-1, 100)
    axes.set_aspect("equal")
    axes.set_axis_off()


def spine(t):
    """The middle of the knot's tube, which is about the curve of the mesh."""
    away = 2 + np.cos(3 * t)
    return np.stack([away * np.cos(2 * t), away * np.sin(2 * t), np.sin(3 * t)])


def girths(address):
    """Closed geodesics round the tube at places along it, but for what another strand hides."""
    for t in 2 * np.pi * (np.arange(PLACES) + 0.5) / PLACES:
        middle, ahead = spine(t), spine(t + 0.01) - spine(t - 0.01)
        if middle[2] < -0.6:
            continue
        at = ",".join(f"{x:.4f}" for x in middle + np.array([0, 0, 0.4]))
        normal = ",".join(f"{x:.4f}" for x in 100 * ahead)
        yield points_of(get_json(f"{address}/loop?at=p:{at}&normal={normal}"))


def draw_knot(axes, address):
    """The knot from above, with its girths."""
    positions, triangles = geometry_of(address)
    corners = positions[triangles]
    shades = np.array([[0.72, 0.77, 0.83]]) * light_on(corners, (-0.4, 0.3, 0.87), 0.45, 0.6)
    axes.add_collection3d(Poly3DCollection(corners, facecolors=shades, edgecolors=shades, lw=0.2))
    # Of a girth what faces the viewer, a little towards them: matplotlib does not sort lines.
    seen = []
    for loop in girths(address):
        top = loop[:, 2] > loop[:, 2].mean() - 0.05
        pieces = np.stack([loop[:-1], loop[1:]], axis=1)[top[:-1] & top[1:]]
        seen.extend(pieces + [0, 0, 0.03])
    axes.add_collection3d(Line3DCollection(seen, colors="#D55E00", lw=2))
    low, high = positions.min(axis=0), positions.max(axis=0)
    show_from_above(axes, (low + high) / 2, (high - low) / 2, 1.4)


def main():
    """Both panels."""
    server = sys.argv[1]
    figure = plt.figure(figsize=(9, 4.2))
    draw_holes(figure.add_axes((0, 0.02, 0.45, 0.96)), sample_at(server, "plane_three_holes.glb"))
    axes = figure.add_axes((0.47, 0, 0.53, 1), projection="3d")
    draw_knot(axes, sample_at(server, "torus_knot.glb"))
    save(figure, "loops.png")


if __name__ == "__main__":
    main()
