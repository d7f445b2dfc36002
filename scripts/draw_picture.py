#!/usr/bin/env python3
"""Draws docs/fields.png from a running server with the sample meshes.

    scripts/draw_picture.py [BASE_URL] [OUT.png]

Needs numpy and matplotlib. Everything drawn is asked of the server: fields as
bare float64 arrays, the path as JSON; positions and faces are those of the
samples' own GLB files, which it returns.
"""

import json
import struct
import sys
import urllib.request

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

BASE = sys.argv[1] if len(sys.argv) > 1 else "http://127.0.0.1:8080"
OUT = sys.argv[2] if len(sys.argv) > 2 else "docs/fields.png"


def get(path):
    """The bytes of a reply."""
    with urllib.request.urlopen(BASE + path) as reply:
        return reply.read()


def sample(name):
    """Id, positions (n, 3) and faces (m, 3) of a sample that was uploaded as GLB."""
    for mesh in json.loads(get("/v1/meshes?limit=1000"))["meshes"]:
        if mesh["format"] == "glb" and mesh["parts"][0]["name"] == name:
            glb = get(f"/v1/meshes/{mesh['id']}/source")
            (json_length,) = struct.unpack_from("<I", glb, 12)
            document = json.loads(glb[20 : 20 + json_length])
            binary = glb[28 + json_length :]
            arrays = []
            for accessor, dtype in zip(document["accessors"], ("<f4", "<u4")):
                view = document["bufferViews"][accessor["bufferView"]]
                count = accessor["count"] * (3 if accessor["type"] == "VEC3" else 1)
                arrays.append(
                    np.frombuffer(binary, dtype, count, view.get("byteOffset", 0)).reshape(-1, 3)
                )
            return mesh["id"], arrays[0].astype(float), arrays[1].astype(int)
    raise SystemExit(f"the server has no sample {name}")


def field(mesh, source):
    """Distances from a vertex to all vertices."""
    return np.frombuffer(get(f"/v1/meshes/{mesh}/distance?from=v:{source}&format=f64"), "<f8")


def split(positions, faces, values):
    """Each face in four, values at the new vertices halfway between their neighbours'."""
    edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges, where = np.unique(edges, axis=0, return_inverse=True)
    a, b, c = faces.T
    ab, bc, ca = (where.reshape(-1, 3) + len(positions)).T
    faces = np.concatenate(
        [np.stack(t, axis=1) for t in ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))]
    )
    middles = positions[edges].mean(axis=1)
    return (
        np.concatenate([positions, middles]),
        faces,
        np.concatenate([values, values[edges].mean(axis=1)]),
    )


def draw_surface(axes, name, source, stripes):
    """A mesh in space, coloured by distance, with dark isolines."""
    mesh, positions, faces = sample(name)
    distance = field(mesh, source)
    for _ in range(2):  # so that isolines are smooth
        positions, faces, distance = split(positions, faces, distance)
    value = distance[faces].mean(axis=1) / distance.max()
    colours = plt.get_cmap("viridis")(value)
    corners = positions[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    light = np.array([0.3, -0.4, 0.87])
    shade = 0.55 + 0.45 * np.abs(normals @ light)
    phase = (value * stripes) % 1
    shade = np.where(np.minimum(phase, 1 - phase) < 0.06, 0.5 * shade, shade)
    colours[:, :3] *= shade[:, None]
    axes.add_collection3d(Poly3DCollection(corners, facecolors=colours, edgecolors=colours, lw=0.2))
    low, high = positions.min(axis=0), positions.max(axis=0)
    middle, half = (low + high) / 2, (high - low).max() / 2 * 0.72
    axes.set_xlim(middle[0] - half, middle[0] + half)
    axes.set_ylim(middle[1] - half, middle[1] + half)
    axes.set_zlim(middle[2] - half, middle[2] + half)
    axes.set_box_aspect((1, 1, 1))
    axes.view_init(elev=62, azim=-60)
    axes.set_axis_off()


def draw_plane(axes, name, source, target):
    """A plane from above: colours, isolines, and the path."""
    mesh, positions, faces = sample(name)
    distance = field(mesh, source)
    used = np.isfinite(distance)
    shown = np.where(used, distance, 0)
    axes.tripcolor(
        positions[:, 0], positions[:, 1], faces, shown, shading="gouraud", cmap="viridis"
    )
    axes.tricontour(
        positions[:, 0], positions[:, 1], faces, shown, levels=24, colors="k", linewidths=0.5,
        alpha=0.55,
    )
    reply = json.loads(get(f"/v1/meshes/{mesh}/path?from=v:{source}&to=v:{target}"))
    points = np.array([point["xyz"] for point in reply["points"]])
    axes.plot(points[:, 0], points[:, 1], color="white", lw=4)
    axes.plot(points[:, 0], points[:, 1], color="#d62728", lw=2)
    axes.plot(*points[0, :2], "o", color="#d62728", mec="white", ms=9, clip_on=False)
    axes.plot(*points[-1, :2], "o", color="#d62728", mec="white", ms=9, clip_on=False)
    axes.set_aspect("equal")
    axes.set_axis_off()


def main():
    """Draws both and writes the file."""
    figure = plt.figure(figsize=(11, 5), dpi=110)
    draw_surface(figure.add_axes((-0.02, 0, 0.54, 1), projection="3d"), "torus_knot", 0, 26)
    draw_plane(figure.add_axes((0.53, 0.03, 0.45, 0.94)), "plane_three_holes", 0, 9999)
    figure.savefig(OUT)
    print(OUT)


if __name__ == "__main__":
    main()
