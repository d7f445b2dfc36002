#!/usr/bin/env python3
"""Draws docs/tables.png: a knotted tube, and the ring that it is by distances along its surface.

    draw_tables.py SERVER

SERVER is the address of one that has the sample meshes (`make run`). Needs numpy and matplotlib.
"""

import io
import json
import sys
import urllib.request

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import PolyCollection

from page_pictures import geometry_of, light_on, sample_at, save

EVERY = 96  # so that one vertex is of each third ring; 32 are a ring round the tube


def table_of(address, vertices):
    """All distances among vertices, by one request."""
    body = {"from": [f"v:{v}" for v in vertices], "stream": True, "format": "npy"}
    request = urllib.request.Request(
        f"{address}/table", json.dumps(body).encode(), {"Content-Type": "application/json"}
    )
    with urllib.request.urlopen(request) as reply:
        return np.load(io.BytesIO(reply.read()))


def laid_out(distances):
    """Classical multidimensional scaling (Torgerson 1952) into the plane: (n, 2)."""
    squares = np.square((distances + distances.T) / 2)
    centred = squares - squares.mean(0)
    centred -= centred.mean(1, keepdims=True)
    values, vectors = np.linalg.eigh(-0.5 * centred)
    return vectors[:, -2:] * np.sqrt(values[-2:])


def draw_knot(axes, positions, triangles):
    """The tube from above, near triangles last, coloured along itself."""
    corners = positions[triangles]
    order = np.argsort(corners[:, :, 2].mean(1))
    along = triangles.min(1)[order] / len(positions)
    colours = matplotlib.colormaps["twilight_shifted"](along)[:, :3]
    shades = colours * light_on(corners[order], (-0.4, 0.5, 0.77), 0.45, 0.6)
    axes.add_collection(
        PolyCollection(corners[order][:, :, :2], facecolors=shades, edgecolors=shades, lw=0.3)
    )
    axes.autoscale()
    axes.set_aspect("equal")
    axes.set_axis_off()


def main():
    """Both panels."""
    address = sample_at(sys.argv[1], "torus_knot.glb")
    positions, triangles = geometry_of(address)
    vertices = np.arange(0, len(positions), EVERY)
    plane = laid_out(table_of(address, vertices))
    figure = plt.figure(figsize=(9, 4.3))
    draw_knot(figure.add_axes((0.01, 0.02, 0.48, 0.96)), positions, triangles)
    axes = figure.add_axes((0.54, 0.04, 0.44, 0.92))
    axes.scatter(*plane.T, c=vertices, cmap="twilight_shifted", s=22, edgecolors="0.4", linewidths=0.4)
    axes.set_aspect("equal")
    axes.set_axis_off()
    save(figure, "tables.png")


if __name__ == "__main__":
    main()
