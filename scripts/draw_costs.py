#!/usr/bin/env python3
"""Draws docs/costs.png: hills with the shortest way and the quickest, how far one gets in ten minutes
each, and the profiles of the two ways.

    draw_costs.py SERVER

SERVER is the address of one that takes uploads (`make run`). Needs numpy and matplotlib.
"""

import json
import sys
import urllib.request

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection, PolyCollection

from page_pictures import geometry_of, get_json, light_on, save

FROM, TO = "ray:300,999,300,0,-1,0", "ray:2700,999,2300,0,-1,0"
LAKE = "sphere:1050,-45,700,220"
LIGHT = (-0.5, 0.75, -0.43)


def hills():
    """The hills of docs/costs.md, as OBJ."""
    side = np.arange(121)
    x, z = (25.0 * side for side in np.meshgrid(side, side))
    y = 120 * np.sin(x / 400) * np.cos(z / 350) + 50 * np.sin(x / 170 + z / 230)
    lines = [f"v {a:.0f} {b:.3f} {c:.0f}" for a, b, c in zip(x.flat, y.flat, z.flat)]
    for row in range(120):
        for corner in 121 * row + side[1:]:
            lines.append(f"f {corner} {corner + 121} {corner + 1}")
            lines.append(f"f {corner + 1} {corner + 121} {corner + 122}")
    return "\n".join(lines).encode()


def way(axes, path, style, colour):
    """A path from above."""
    x, _, z = np.array([point["xyz"] for point in path["points"]]).T
    axes.plot(x, z, style, color=colour, lw=1.8, solid_capstyle="round")
    for end in (0, -1):
        axes.plot(x[end], z[end], "o", color=colour, ms=5)


def profile(axes, path, colour, label):
    """Its heights over its length."""
    points = np.array([point["xyz"] for point in path["points"]])
    along = np.concatenate([[0], np.linalg.norm(np.diff(points, axis=0), axis=1).cumsum()])
    axes.plot(along / 1000, points[:, 1], color=colour, lw=1.6, label=label)


def main():
    """The map and the profiles."""
    server = sys.argv[1].rstrip("/")
    with urllib.request.urlopen(f"{server}/v1/meshes", data=hills()) as reply:
        mesh = f"{server}/v1/meshes/" + json.load(reply)["id"]
    positions, triangles = geometry_of(mesh)
    corners = positions[triangles]
    ends = f"from={FROM}&to={TO}"
    shortest = get_json(f"{mesh}/path?{ends}&method=exact")
    quickest = get_json(f"{mesh}/path?{ends}&slope=tobler&forbid={LAKE}")
    lines = get_json(f"{mesh}/isolines?from={FROM}&slope=tobler&step=600&forbid={LAKE}")

    figure = plt.figure(figsize=(9, 4.4))
    axes = figure.add_axes((0.01, 0.02, 0.47, 0.96))
    heights = corners[:, :, 1].mean(axis=1)
    colours = plt.get_cmap("YlGn_r")(np.clip((heights + 250) / 560, 0, 1))[:, :3]
    shades = np.clip(colours * light_on(corners, LIGHT, 0.6, 0.45), 0, 1)
    x, z, reach = map(float, (LAKE[7:].split(",")[i] for i in (0, 2, 3)))
    y = float(LAKE[7:].split(",")[1])
    away = np.linalg.norm(corners.mean(axis=1) - (x, y, z), axis=1)
    shades[away <= reach] = (0.55, 0.74, 0.90)
    axes.add_collection(
        PolyCollection(corners[:, :, ::2], facecolors=shades, edgecolors=shades, lw=0.2)
    )
    axes.add_collection(
        LineCollection(
            [np.array(line["points"])[:, ::2] for line in lines["isolines"]],
            colors="white",
            linewidths=0.9,
        )
    )
    way(axes, shortest, ":", "#222222")
    way(axes, quickest, "-", "#D55E00")
    axes.set_xlim(0, 3000)
    axes.set_ylim(3000, 0)
    axes.set_aspect("equal")
    axes.set_axis_off()

    axes = figure.add_axes((0.57, 0.14, 0.41, 0.78))
    profile(axes, shortest, "#222222", f"shortest: {shortest['length']:.0f} m")
    label = f"quickest: {quickest['length']:.0f} m, {quickest['cost'] / 60:.0f} min"
    profile(axes, quickest, "#D55E00", label)
    axes.set_xlabel("way (km)")
    axes.set_ylabel("height (m)")
    axes.legend(frameon=False, loc="upper right", fontsize=9)
    axes.set_ylim(-100, 160)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    save(figure, "costs.png")


if __name__ == "__main__":
    main()
