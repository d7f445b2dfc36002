#!/usr/bin/env python3
"""Draws docs/discs.png: the terrain cut into strips of walking distance about a place, and how much
ground lies within a distance.

    draw_discs.py SERVER

SERVER is the address of one that has the sample meshes (`make run`). Needs numpy and matplotlib.
"""

import sys

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import PolyCollection

from page_pictures import Glb, get, get_json, light_on, sample_at, save

PLACE = "p:90,0,-90"  # the middle of the terrain
RADII = (40, 80, 120, 160)  # mesh units


def strips_of(glb):
    """Of each node (m, 3, 3) its triangles' corners."""
    for node in glb.document["nodes"]:
        primitive = glb.document["meshes"][node["mesh"]]["primitives"][0]
        yield glb.accessor(primitive["attributes"]["POSITION"])[glb.triangles(primitive)]


def draw_strips(axes, strips):
    """The strips from above, shaded by their slopes."""
    colours = matplotlib.colormaps["viridis"](np.linspace(0, 1, len(RADII) + 1))[:, :3]
    for corners, colour in zip(strips, colours):
        shades = colour * light_on(corners, (-0.5, 0.75, -0.43), 0.35, 0.65)
        axes.add_collection(
            PolyCollection(corners[:, :, ::2], facecolors=shades, edgecolors=shades, lw=0.2)
        )
    axes.plot(90, -90, "o", color="#D55E00", ms=5)
    axes.set_xlim(0, 179)
    axes.set_ylim(0, -179)
    axes.set_aspect("equal")
    axes.set_axis_off()


def draw_areas(axes, discs):
    """The area of the discs over their radius, beside that of the plane's."""
    radius = np.array([disc["radius"] for disc in discs])
    axes.plot(radius, np.pi * radius**2, "--", color="0.6", label="in a plane")
    axes.plot(radius, [disc["area"] for disc in discs], color="#0072B2", label="on the terrain")
    for r in RADII:
        axes.axvline(r, color="0.85", lw=0.8, zorder=0)
    axes.set_xlim(0, radius[-1])
    axes.set_ylim(0, 1.1 * discs[-1]["area"])
    axes.set_xlabel("walking distance")
    axes.set_ylabel("area within it")
    axes.legend(frameon=False, loc="upper left")
    axes.spines[["top", "right"]].set_visible(False)


def main():
    """Both panels."""
    asked = sample_at(sys.argv[1], "terrain.glb") + f"/measure?from={PLACE}&method=exact"
    strips = strips_of(Glb(get(asked + "&format=glb" + "".join(f"&radii={r}" for r in RADII))))
    radii = "".join(f"&radii={r}" for r in range(2, 201, 2))
    figure = plt.figure(figsize=(9, 4.1))
    draw_strips(figure.add_axes((0, 0.02, 0.45, 0.96)), strips)
    draw_areas(figure.add_axes((0.56, 0.14, 0.42, 0.82)), get_json(asked + radii)["discs"])
    save(figure, "discs.png")


if __name__ == "__main__":
    main()
