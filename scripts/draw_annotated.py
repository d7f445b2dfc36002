#!/usr/bin/env python3
"""Draws docs/annotated.png out of one annotated file: rust that spreads from three points of the
torus knot, and their regions.

    draw_annotated.py SERVER

SERVER is the address of one that has the sample meshes (`make run`). Needs numpy and matplotlib.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from page_pictures import Glb, get, light_on, sample_at, save, show_from_above

SOURCES = (0, 6000, 13000)  # vertices
REACH = 2.4  # of the rust, mesh units
STEEL, RUST = np.array([0.62, 0.68, 0.74]), np.array([0.66, 0.27, 0.07])
REGIONS = np.array([[0.0, 0.45, 0.70], [0.90, 0.62, 0.0], [0.0, 0.62, 0.45]])


def draw(axes, positions, triangles, colours):
    """The surface, each face in the mean of its corners' colours."""
    faces = positions[triangles]
    shown = colours[triangles].mean(1) * light_on(faces, (0.25, 0.35, 0.9), 0.45, 0.6)
    axes.add_collection3d(
        Poly3DCollection(faces, facecolors=shown, edgecolors="none", lw=0, antialiased=False)
    )
    reach = np.abs(positions).max(0)
    show_from_above(axes, (0, 0, 0), reach, 1.42)


def main():
    """Both panels."""
    sources = "&".join(f"from=v:{v}" for v in SOURCES)
    asked = sample_at(sys.argv[1], "torus_knot.glb") + f"/distance?{sources}&labels=1"
    glb = Glb(get(asked + "&format=annotated"))
    primitive = glb.document["meshes"][0]["primitives"][0]
    values = {name: glb.accessor(index) for name, index in primitive["attributes"].items()}
    positions, triangles = values["POSITION"], glb.triangles(primitive)
    distances = values["_GEODESIC_DISTANCE"][:, 0]
    labels = values["_GEODESIC_SOURCE"][:, 0].astype(int)
    # As a shader would: worn by distance, with some unrest.
    unrest = 0.18 * np.sin(9 * positions).sum(1)
    rust = np.clip(1.4 * (1 - (distances + unrest) / REACH), 0, 1)[:, None]
    figure = plt.figure(figsize=(9, 4.3))
    draw(figure.add_axes((0, 0, 0.5, 1), projection="3d"), positions, triangles, STEEL + rust * (RUST - STEEL))
    draw(figure.add_axes((0.5, 0, 0.5, 1), projection="3d"), positions, triangles, REGIONS[labels])
    save(figure, "annotated.png")


if __name__ == "__main__":
    main()
