#!/usr/bin/env python3
"""Draws docs/log_map.png: a checkered decal on the torus knot, and the map that it comes from.

    draw_log_map.py SERVER

SERVER is the address of one that has the sample meshes (`make run`). Needs numpy and matplotlib.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from page_pictures import geometry_of, get_json, light_on, sample_at, save, show_from_above

SQUARES = 8  # of the texture, across
RADIUS = 0.7  # mesh units
INK, PAPER, SURFACE = np.array([0.0, 0.28, 0.45]), np.array([1.0, 0.93, 0.72]), np.array([0.75] * 3)


def split(triangles, values, times):
    """Each triangle of corner values (m, 3, k) into four, so many times over."""
    for _ in range(times):
        a, b, c = values[:, 0], values[:, 1], values[:, 2]
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        values = np.concatenate(
            [np.stack(t, 1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
        )
        triangles = np.concatenate([triangles] * 4)
    return triangles, values


def checkered(uv):
    """The texture's colour at coordinates (m, 2) in [0, 1], transparent (nan) outside."""
    dark = np.floor(SQUARES * uv).sum(1) % 2 == 0
    colours = np.where(dark[:, None], INK, PAPER)
    outside = ((uv < 0) | (uv > 1)).any(1)
    return np.where(outside[:, None], np.nan, colours)


def draw_surface(axes, positions, triangles, place):
    """The surface with the decal; `place` (n, 2) has nan where a vertex has none."""
    corners = np.concatenate([positions[triangles], place[triangles]], 2)
    near = ~np.isnan(corners).any((1, 2))
    _, fine = split(np.arange(near.sum()), corners[near], 3)
    colours = checkered(fine[:, :, 3:].mean(1))
    colours = np.where(np.isnan(colours), SURFACE, colours)
    faces = np.concatenate([positions[triangles[~near]], fine[:, :, :3]])
    colours = np.concatenate([np.tile(SURFACE, ((~near).sum(), 1)), colours])
    shown = colours * light_on(faces, (0.25, 0.35, 0.9), 0.5, 0.5)
    axes.add_collection3d(
        Poly3DCollection(faces, facecolors=shown, edgecolors="none", lw=0, antialiased=False)
    )
    middle = np.nanmean(positions[~np.isnan(place).any(1)], axis=0)
    show_from_above(axes, middle, (1, 1, 1), 1.5)


def draw_plane(axes, triangles, place):
    """The map: the same triangles in the plane, over the texture."""
    near = triangles[~np.isnan(place[triangles]).any((1, 2))]
    pattern = np.indices((SQUARES, SQUARES)).sum(0) % 2 == 0
    axes.imshow(
        np.where(pattern[..., None], INK, PAPER), extent=(0, 1, 0, 1), origin="lower", interpolation="nearest"
    )
    axes.triplot(*np.where(np.isnan(place), 0, place).T, near, color="0.45", lw=0.5)
    axes.plot(0.5, 0.5, "o", color="#D55E00", ms=5)
    axes.set_xlim(-0.12, 1.12)
    axes.set_ylim(-0.12, 1.12)
    axes.set_aspect("equal")
    axes.set_axis_off()


def main():
    """Both panels."""
    address = sample_at(sys.argv[1], "torus_knot.glb")
    positions, triangles = geometry_of(address)
    told = get_json(f"{address}/logmap?from=ray:0.8,-0.6,9,0,0,-1&radius={1.5 * RADIUS}&method=exact")
    place = np.full((len(positions), 2), np.nan)
    place[told["vertices"]] = 0.5 + np.array(told["coordinates"]) / (2 * RADIUS)
    figure = plt.figure(figsize=(9, 4.3))
    draw_surface(figure.add_axes((0, 0, 0.5, 1), projection="3d"), positions, triangles, place)
    draw_plane(figure.add_axes((0.52, 0.04, 0.46, 0.92)), triangles, place)
    save(figure, "log_map.png")


if __name__ == "__main__":
    main()
