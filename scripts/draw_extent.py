#!/usr/bin/env python3
"""Draws docs/extent.png: the terrain's centre with the distances from it, its diameter, and how the
bounds of both close in from field to field; and docs/means.png: the mean distance of every vertex.

    draw_extent.py SERVER

SERVER is the address of one that has the sample meshes (`make run`). Needs numpy and matplotlib.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

from page_pictures import geometry_of, get_json, sample_at, save

ORANGE, BLUE = "#D55E00", "#0072B2"
FIELDS = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32)


def draw_map(axes, address):
    """From above: the distance from the centre, and the diameter's path."""
    positions, triangles = geometry_of(address)
    center = get_json(f"{address}/extent?of=center&method=exact")
    diameter = get_json(f"{address}/extent?of=diameter&method=exact")
    x, z = positions[:, 0], -positions[:, 2]
    distances = get_json(f"{address}/distance?from=v:{center['vertices'][0]['vertex']}")["distances"]
    levels = np.arange(0, max(distances) + 20, 20)
    axes.tricontourf(x, z, triangles, distances, levels, cmap="viridis")
    one, other = (end["vertex"] for end in diameter["vertices"])
    path = np.array([p["xyz"] for p in get_json(f"{address}/path?from=v:{one}&to=v:{other}")["points"]])
    axes.plot(path[:, 0], -path[:, 2], color="white", lw=2)
    spot = center["vertices"][0]["xyz"]
    axes.plot(spot[0], -spot[2], "o", color=ORANGE, mec="white", ms=8)
    axes.set_aspect("equal")
    axes.set_axis_off()


def draw_bounds(axes, address):
    """The bounds over the number of fields."""
    for of, colour, name in (("diameter", BLUE, "diameter"), ("center", ORANGE, "from the centre")):
        found = [get_json(f"{address}/extent?of={of}&method=exact&fields={n}") for n in FIELDS]
        lower, upper = ([f[key] for f in found] for key in ("lower", "upper"))
        axes.fill_between(FIELDS, lower, upper, color=colour, alpha=0.25, lw=0)
        axes.plot(FIELDS, [f["value"] for f in found], ".-", color=colour, label=name)
    axes.set_xscale("log", base=2)
    axes.set_xticks(FIELDS[::2], [str(n) for n in FIELDS[::2]])
    axes.minorticks_off()
    axes.set_ylim(0)
    axes.set_xlabel("fields")
    axes.set_ylabel("greatest distance")
    axes.legend(frameon=False, loc="upper right")
    axes.spines[["top", "right"]].set_visible(False)


def draw_means(axes, address):
    """From above: the mean distance of every vertex, isolines at every 10, and where it is least."""
    positions, triangles = geometry_of(address)
    means = get_json(f"{address}/extent?of=means&fields=200&method=exact")["means"]
    middle = positions[np.argmin(means)]
    x, z = positions[:, 0], -positions[:, 2]
    shown = axes.tripcolor(x, z, triangles, means, cmap="viridis", shading="gouraud")
    levels = np.arange(0, max(means), 10)
    axes.tricontour(x, z, triangles, means, levels, colors="#ffffffa0", linewidths=0.8)
    axes.plot(middle[0], -middle[2], "o", color=ORANGE, mec="white", ms=8)
    axes.set_aspect("equal")
    axes.set_axis_off()
    return shown


def main():
    """Both panels of the one, and the one of the other."""
    address = sample_at(sys.argv[1], "terrain.glb")
    figure = plt.figure(figsize=(9, 4.1))
    draw_map(figure.add_axes((0, 0.02, 0.45, 0.96)), address)
    draw_bounds(figure.add_axes((0.55, 0.14, 0.43, 0.82)), address)
    save(figure, "extent.png")
    figure = plt.figure(figsize=(5.4, 4.1))
    shown = draw_means(figure.add_axes((0.02, 0.02, 0.72, 0.96)), address)
    bar = figure.colorbar(shown, cax=figure.add_axes((0.79, 0.1, 0.035, 0.8)))
    bar.set_label("mean distance (mesh units)")
    save(figure, "means.png")


if __name__ == "__main__":
    main()
