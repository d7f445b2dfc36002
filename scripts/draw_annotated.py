#!/usr/bin/env python3
"""Draws docs/annotated.png out of one annotated file: rust that spreads from three points of the
torus knot, and their regions.

    draw_annotated.py SERVER

SERVER is the address of one that has the sample meshes (`make run`). Needs numpy and matplotlib.
"""

import io
import json
import pathlib
import sys
import urllib.request

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parent.parent
SOURCES = (0, 6000, 13000)  # vertices
REACH = 2.4  # of the rust, mesh units
STEEL, RUST = np.array([0.62, 0.68, 0.74]), np.array([0.66, 0.27, 0.07])
REGIONS = np.array([[0.0, 0.45, 0.70], [0.90, 0.62, 0.0], [0.0, 0.62, 0.45]])
WIDTHS = {"SCALAR": 1, "VEC3": 3}
TYPES = {5123: "<u2", 5125: "<u4", 5126: "<f4"}


def get(address):
    """The bytes at an address."""
    with urllib.request.urlopen(address) as reply:
        return reply.read()


class File:
    """What is drawn of a GLB: one primitive."""

    def __init__(self, glb):
        size = int.from_bytes(glb[12:16], "little")
        self.document = json.loads(glb[20 : 20 + size])
        self.binary = glb[28 + size :]
        self.primitive = self.document["meshes"][0]["primitives"][0]

    def accessor(self, index):
        """Its elements, a row each; all of them are tightly packed in this file."""
        accessor = self.document["accessors"][index]
        view = self.document["bufferViews"][accessor["bufferView"]]
        width = WIDTHS[accessor["type"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        kind = TYPES[accessor["componentType"]]
        return np.frombuffer(self.binary, kind, accessor["count"] * width, start).reshape(-1, width)

    def attribute(self, name):
        """By the name that a shader uses."""
        return self.accessor(self.primitive["attributes"][name])


def draw(axes, positions, triangles, colours):
    """The surface, each face in the mean of its corners' colours."""
    faces = positions[triangles]
    normals = np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True) + 1e-30
    light = np.clip(0.45 + 0.6 * np.abs(normals @ np.array([0.25, 0.35, 0.9])), 0, 1)
    shown = colours[triangles].mean(1) * light[:, None]
    axes.add_collection3d(
        Poly3DCollection(faces, facecolors=shown, edgecolors="none", lw=0, antialiased=False)
    )
    reach = np.abs(positions).max(0)
    for set_limits, size in zip((axes.set_xlim, axes.set_ylim, axes.set_zlim), reach):
        set_limits(-size, size)
    axes.view_init(90, -90)
    axes.set_proj_type("ortho")
    axes.set_axis_off()
    axes.set_box_aspect(tuple(reach), zoom=1.42)


def main():
    """Both panels."""
    server = sys.argv[1].rstrip("/")
    meshes = json.loads(get(f"{server}/v1/meshes"))["meshes"]
    knot = next(m["id"] for m in meshes if m.get("name") == "torus_knot.glb")
    sources = "&".join(f"from=v:{v}" for v in SOURCES)
    file = File(get(f"{server}/v1/meshes/{knot}/distance?{sources}&labels=1&format=annotated"))
    positions = file.attribute("POSITION")
    triangles = file.accessor(file.primitive["indices"]).reshape(-1, 3).astype(int)
    distances = file.attribute("_GEODESIC_DISTANCE")[:, 0]
    labels = file.attribute("_GEODESIC_SOURCE")[:, 0].astype(int)
    # As a shader would: worn by distance, with some unrest.
    unrest = 0.18 * np.sin(9 * positions).sum(1)
    rust = np.clip(1.4 * (1 - (distances + unrest) / REACH), 0, 1)[:, None]
    figure = plt.figure(figsize=(9, 4.3))
    draw(figure.add_axes((0, 0, 0.5, 1), projection="3d"), positions, triangles, STEEL + rust * (RUST - STEEL))
    draw(figure.add_axes((0.5, 0, 0.5, 1), projection="3d"), positions, triangles, REGIONS[labels])
    picture = io.BytesIO()
    figure.savefig(picture, dpi=90, facecolor="white")
    Image.open(picture).convert("RGB").quantize(64).save(ROOT / "docs" / "annotated.png", optimize=True)


if __name__ == "__main__":
    main()
