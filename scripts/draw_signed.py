#!/usr/bin/env python3
"""Draws docs/signed.png: the terrain from above with the signed distances from a closed curve,
their isolines and the curve.

    draw_signed.py SERVER

SERVER is the address of one that has the sample meshes (`make run`). Needs numpy and matplotlib.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

from page_pictures import draw_way, geometry_of, get, get_json, sample_at, save

# The curve of docs/curves.md.
STOPS = (
    "ray:40,99,-40,0,-1,0",
    "ray:100,99,-50,0,-1,0",
    "ray:110,99,-110,0,-1,0",
    "ray:50,99,-90,0,-1,0",
)


def main():
    """One panel."""
    mesh = sample_at(sys.argv[1], "terrain.glb")
    positions, triangles = geometry_of(mesh)
    curve = "curve:closed;" + ";".join(STOPS)
    bytes_of_field = get(f"{mesh}/distance?from={curve}&signed=1&method=exact&format=f64")
    field = np.frombuffer(bytes_of_field, "<f8")
    figure, axes = plt.subplots(figsize=(6, 5.2))
    figure.subplots_adjust(0.01, 0.01, 0.97, 0.99)
    x, z = positions[:, 0], positions[:, 2]
    most = 50
    shown = axes.tripcolor(
        x, z, triangles, field, cmap="RdBu_r", vmin=-most, vmax=most, shading="gouraud"
    )
    levels = np.arange(-40, most + 1, 10)
    axes.tricontour(x, z, triangles, field, levels[levels != 0], colors="#00000060", linewidths=0.7)
    for start, end in zip(STOPS, STOPS[1:] + STOPS[:1]):
        leg = get_json(f"{mesh}/path?from={start}&to={end}&method=exact")
        draw_way(axes, leg, "-", "black", 2.5, ends=())
    figure.colorbar(shown, ax=axes, shrink=0.8, label="signed distance", extend="max")
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.set_xlim(-1, 180)
    axes.set_ylim(1, -180)
    save(figure, "signed.png")


if __name__ == "__main__":
    main()
