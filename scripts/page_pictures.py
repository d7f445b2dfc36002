"""What the scripts that draw the documentation's pictures share: the server's sample meshes and its
replies, light on faces, the ground from above, and small PNG files."""

import io
import json
import pathlib
import urllib.request

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection, TriMesh
from matplotlib.tri import Triangulation
from PIL import Image

DOCS = pathlib.Path(__file__).resolve().parent.parent / "docs"
GROUND, WATER = (0.93, 0.92, 0.88), (0.62, 0.79, 0.93)
_WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}
_TYPES = {5121: "u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}


def get(address):
    """The bytes at an address."""
    with urllib.request.urlopen(address) as reply:
        return reply.read()


def get_json(address):
    """The JSON at an address."""
    return json.loads(get(address))


def sample_at(server, name):
    """The address of a sample mesh."""
    server = server.rstrip("/")
    meshes = get_json(f"{server}/v1/meshes")["meshes"]
    return f"{server}/v1/meshes/" + next(m["id"] for m in meshes if m.get("name") == name)


def geometry_of(address):
    """Positions (n, 3) and triangles (m, 3) of a mesh, out of its frame."""
    frame = get(address + "/geometry?format=frame")
    size = int.from_bytes(frame[8:12], "little")
    arrays = {}
    for told in json.loads(frame[24 : 24 + size])["arrays"]:
        flat = np.frombuffer(frame, told["dtype"], int(np.prod(told["shape"])), told["offset"])
        arrays[told["name"]] = flat.reshape(told["shape"])
    return arrays["positions"], arrays["triangles"].astype(int)


class Glb:
    """A binary glTF whose accessors are tightly packed."""

    def __init__(self, glb):
        size = int.from_bytes(glb[12:16], "little")
        self.document = json.loads(glb[20 : 20 + size])
        self._binary = glb[28 + size :]

    def accessor(self, index):
        """Its elements, a row each."""
        accessor = self.document["accessors"][index]
        view = self.document["bufferViews"][accessor["bufferView"]]
        width = _WIDTHS[accessor["type"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        kind = _TYPES[accessor["componentType"]]
        flat = np.frombuffer(self._binary, kind, accessor["count"] * width, start)
        return flat.reshape(-1, width)

    def triangles(self, primitive):
        """The vertices of a primitive's triangles (m, 3)."""
        return self.accessor(primitive["indices"]).reshape(-1, 3).astype(int)


def light_on(corners, towards, least, more):
    """Of faces (m, 3, 3) a factor each (m, 1): `least` where light grazes them, and `more` of how
    far they face it, from either side."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True) + 1e-30
    return np.minimum(least + more * np.abs(normals @ np.array(towards)), 1)[:, None]


def draw_ground(axes, positions, triangles, colours=GROUND):
    """Ground with y up, from above, in a colour or one for each vertex (n, 3), shaded lightly and
    without a seam between faces."""
    corners = positions[triangles]
    normals = np.zeros(positions.shape)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    for corner in triangles.T:
        np.add.at(normals, corner, across)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True) + 1e-30
    shades = np.minimum(0.72 + 0.32 * np.abs(normals @ np.array((-0.5, 0.75, -0.43))), 1)
    mesh = TriMesh(Triangulation(positions[:, 0], positions[:, 2], triangles))
    mesh.set_facecolor(shades[:, None] * np.array(colours))
    axes.add_collection(mesh)
    axes.set_aspect("equal")
    axes.set_axis_off()


def map_of(points):
    """Where points of a path, or of an isoline, are on the map: x and z."""
    return np.array([p["xyz"] if isinstance(p, dict) else p for p in points])[:, ::2].T


def draw_way(axes, path, style, colour, width=2.2, ends=(0, -1)):
    """A path over the ground from above, with dots at its ends."""
    x, z = map_of(path["points"])
    axes.plot(x, z, style, color=colour, lw=width, solid_capstyle="round")
    for end in ends:
        axes.plot(x[end], z[end], "o", color=colour, ms=6, mec="white", mew=0.8)


def draw_isolines(axes, found, colour, width):
    """Isolines over the ground from above; `colour` is one, or tells one of a level."""
    lines = [[*line["points"], *line["points"][: line["closed"]]] for line in found["isolines"]]
    if callable(colour):
        colour = [colour(line["level"]) for line in found["isolines"]]
    axes.add_collection(
        LineCollection([map_of(line).T for line in lines], colors=colour, lw=width, joinstyle="round")
    )


def line_round(mesh, stops):
    """The closed line through points, as `inside:` of a region has it."""
    via = "".join(f"&via={stop}" for stop in stops[1:])
    return get_json(f"{mesh}/path?from={stops[0]}{via}&to={stops[0]}&method=exact")


def show_from_above(axes, middle, reach, zoom):
    """A view of 3D axes along z, of `reach` about `middle` on each axis."""
    for set_limits, at, size in zip((axes.set_xlim, axes.set_ylim, axes.set_zlim), middle, reach):
        set_limits(at - size, at + size)
    axes.view_init(90, -90)
    axes.set_proj_type("ortho")
    axes.set_axis_off()
    axes.set_box_aspect(tuple(reach), zoom=zoom)


def save(figure, name):
    """As docs/NAME."""
    picture = io.BytesIO()
    figure.savefig(picture, dpi=90, facecolor="white")
    plt.close(figure)
    # In all its colours: a palette would speckle or band what is smooth.
    Image.open(picture).convert("RGB").save(DOCS / name, optimize=True)
