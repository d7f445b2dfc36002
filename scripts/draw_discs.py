#!/usr/bin/env python3
"""Draws docs/discs.png: the terrain cut into strips of walking distance about a place, and how much
ground lies within a distance.

    draw_discs.py SERVER

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
from matplotlib.collections import PolyCollection
from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parent.parent
PLACE = "p:90,0,-90"  # the middle of the terrain
RADII = (40, 80, 120, 160)  # mesh units


def fetch(address):
    """The bytes at an address."""
    with urllib.request.urlopen(address) as reply:
        return reply.read()


def strips_of(glb):
    """Of each node (m, 3, 3) its triangles' corners."""
    length = int.from_bytes(glb[12:16], "little")
    document = json.loads(glb[20 : 20 + length])

    def array(index, dtype):
        accessor = document["accessors"][index]
        width = {"VEC3": 3, "SCALAR": 1}[accessor["type"]]
        begin = 28 + length + document["bufferViews"][accessor["bufferView"]]["byteOffset"]
        return np.frombuffer(glb, dtype, width * accessor["count"], begin).reshape(-1, 3)

    for node in document["nodes"]:
        primitive = document["meshes"][node["mesh"]]["primitives"][0]
        positions = array(primitive["attributes"]["POSITION"], "<f4")
        yield positions[array(primitive["indices"], "<u4")]


def draw_strips(axes, strips):
    """The strips from above, shaded by their slopes."""
    colours = matplotlib.colormaps["viridis"](np.linspace(0, 1, len(RADII) + 1))[:, :3]
    for corners, colour in zip(strips, colours):
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True) + 1e-30
        light = 0.35 + 0.65 * np.abs(normals @ np.array([-0.5, 0.75, -0.43]))
        shades = np.minimum(colour * light[:, None], 1)
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
    server = sys.argv[1].rstrip("/")
    meshes = json.loads(fetch(f"{server}/v1/meshes"))["meshes"]
    terrain = next(m["id"] for m in meshes if m.get("name") == "terrain.glb")
    asked = f"{server}/v1/meshes/{terrain}/measure?from={PLACE}&method=exact"
    strips = strips_of(fetch(asked + "&format=glb" + "".join(f"&radii={r}" for r in RADII)))
    radii = "".join(f"&radii={r}" for r in range(2, 201, 2))
    figure = plt.figure(figsize=(9, 4.1))
    draw_strips(figure.add_axes((0, 0.02, 0.45, 0.96)), strips)
    draw_areas(figure.add_axes((0.56, 0.14, 0.42, 0.82)), json.loads(fetch(asked + radii))["discs"])
    picture = io.BytesIO()
    figure.savefig(picture, dpi=90, facecolor="white")
    Image.open(picture).convert("RGB").quantize(200).save(ROOT / "docs" / "discs.png", optimize=True)


if __name__ == "__main__":
    main()
