#!/usr/bin/env python3
"""Draws docs/log_map_carried.png: a direction at a point of the torus knot, carried along the paths.

    draw_log_map_carried.py SERVER

SERVER is the address of one that has the sample meshes (`make run`). Needs numpy and matplotlib.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import PolyCollection

from page_pictures import geometry_of, get_json, light_on, sample_at, save

RADIUS = 1.6  # mesh units
LENGTH = 0.11  # of an arrow
POINT = "ray:0.8,-0.6,9,0,0,-1"


def draw_surface(axes, corners):
    """Faces (m, 3, 3) from above, the lower ones first."""
    corners = corners[np.argsort(corners[:, :, 2].mean(1))]
    shades = light_on(corners, (0.25, 0.35, 0.9), 0.6, 0.4) * np.array([0.86, 0.88, 0.9])
    axes.add_collection(PolyCollection(corners[:, :, :2], facecolors=shades, edgecolors="face", lw=0.3))


def main():
    """One panel, from above."""
    address = sample_at(sys.argv[1], "torus_knot.glb")
    positions, triangles = geometry_of(address)
    told = get_json(f"{address}/logmap?from={POINT}&radius={RADIUS}&method=exact&transport=1")
    corners = positions[triangles]
    normals = np.zeros(positions.shape)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    for corner in triangles.T:
        np.add.at(normals, corner, across)
    vertices = np.array(told["vertices"])
    middle = np.array(told["from"]["xyz"])
    # Outwards at the point, however the faces are wound.
    normals *= np.sign(normals[vertices[np.argmin(told["distances"])], 2])
    # Those that are seen from above, and on the strand that the point is on.
    seen = (normals[vertices, 2] > 0.25 * np.linalg.norm(normals[vertices], axis=1)) & (
        np.abs(positions[vertices, 2] - middle[2]) < 0.8
    )
    at, along = positions[vertices[seen]], np.array(told["directions"])[seen]
    distance = np.array(told["distances"])[seen]
    figure = plt.figure(figsize=(7, 5))
    axes = figure.add_axes((0, 0, 1, 1))
    draw_surface(axes, corners)
    axes.quiver(
        *at.T[:2], *(LENGTH * along.T[:2]), distance, cmap="viridis", clim=(0, 1.15 * RADIUS),
        angles="xy", scale_units="xy", scale=1, width=0.0035, headwidth=3.6, headlength=4.2, pivot="mid",
    )
    axes.plot(*middle[:2], "o", color="#D55E00", ms=8, mec="white", mew=1)
    axes.set_xlim(middle[0] - 1.5, middle[0] + 1.5)
    axes.set_ylim(middle[1] - 1.07, middle[1] + 1.07)
    axes.set_aspect("equal")
    axes.set_axis_off()
    save(figure, "log_map_carried.png")


if __name__ == "__main__":
    main()
