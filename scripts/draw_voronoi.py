#!/usr/bin/env python3
"""Draws docs/voronoi.png: the cells of some sites on the terrain, the triangles between sites whose
cells meet, and the cells of the same sites after Lloyd's rounds.

    draw_voronoi.py SERVER

SERVER is the address of one that has the sample meshes (`make run`). Needs numpy and matplotlib.
"""

import sys

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection, PolyCollection

from page_pictures import Glb, get, get_json, light_on, sample_at, save

# As docs/voronoi.md has them.
PLACES = ((20, -30), (60, -25), (50, -70), (100, -50), (140, -40), (160, -110), (120, -90), (90, -140), (40, -130), (150, -160))
SITES = "".join(f"&from=ray:{x},99,{z},0,-1,0" for x, z in PLACES)
COLOURS = "Set3"


def cells_of(glb):
    """Of each node (m, 3, 3) its triangles' corners."""
    for node in glb.document["nodes"]:
        primitive = glb.document["meshes"][node["mesh"]]["primitives"][0]
        yield glb.accessor(primitive["attributes"]["POSITION"]).reshape(-1, 3, 3)


def draw_cells(axes, asked):
    """The cells from above, with bisectors and sites; what the server says of them."""
    colours = matplotlib.colormaps[COLOURS].colors
    for number, corners in enumerate(cells_of(Glb(get(asked + "&format=glb")))):
        colour = np.array(colours[number % len(colours)])
        shades = colour * light_on(corners, (-0.5, 0.75, -0.43), 0.45, 0.55)
        axes.add_collection(
            PolyCollection(corners[:, :, ::2], facecolors=shades, edgecolors=shades, lw=0.2)
        )
    found = get_json(asked)
    lines = [np.array(line["points"])[:, ::2] for line in found["bisectors"]]
    axes.add_collection(LineCollection(lines, colors="0.15", lw=1.2))
    axes.set_xlim(0, 179)
    axes.set_ylim(0, -179)
    axes.set_aspect("equal")
    axes.set_axis_off()
    return found


def draw_sites(axes, found, label):
    """The sites as discs."""
    sites = np.array([cell["site"]["xyz"] for cell in found["cells"]])
    axes.plot(sites[:, 0], sites[:, 2], "o", color="black", mec="white", ms=6, zorder=3)
    axes.set_title(label, fontsize=10)
    return sites


def main():
    """The panels."""
    asked = sample_at(sys.argv[1], "terrain.glb") + f"/voronoi?method=exact{SITES}"
    figure, panels = plt.subplots(1, 2, figsize=(9, 4.7))
    figure.subplots_adjust(0.01, 0.01, 0.99, 0.93, 0.03)
    found = draw_cells(panels[0], asked)
    sites = draw_sites(panels[0], found, "cells, and triangles where three meet")
    triangles = np.array([triangle["cells"] for triangle in found["triangles"]])
    edges = np.unique(np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)), axis=0)
    panels[0].add_collection(
        LineCollection(sites[edges][:, :, ::2], colors="white", lw=1.1)
    )
    relaxed = draw_cells(panels[1], asked + "&relax=30")
    draw_sites(panels[1], relaxed, "after 30 rounds of Lloyd's algorithm")
    save(figure, "voronoi.png")


if __name__ == "__main__":
    main()
