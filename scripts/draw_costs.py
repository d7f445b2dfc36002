#!/usr/bin/env python3
"""Draws docs/costs.png: hills with the shortest way and the quickest, how far one gets in ten minutes
each, and the profiles of the two ways.

    draw_costs.py SERVER

SERVER is the address of one that takes uploads (`make run`). Needs numpy and matplotlib.
"""

import json
import sys
import urllib.request

import matplotlib.patheffects
import matplotlib.pyplot as plt
import numpy as np

from page_pictures import (
    WATER,
    draw_ground,
    draw_isolines,
    draw_way,
    geometry_of,
    get_json,
    line_round,
    map_of,
    save,
)

FROM, TO = "ray:300,999,300,0,-1,0", "ray:2700,999,2300,0,-1,0"
# The shore of docs/costs.md, x and z.
TURNS = np.arange(16) * 0.3927
SHORE = zip(np.round(1050 + 220 * np.cos(TURNS)), np.round(700 + 220 * np.sin(TURNS)))
STOPS = [f"ray:{x:.0f},999,{z:.0f},0,-1,0" for x, z in SHORE]
LAKE = "inside:" + ";".join(STOPS)
ORANGE, GREY = "#D55E00", "#222222"
LABEL = {
    **{"color": "white", "fontsize": 8, "fontweight": "bold", "ha": "center", "va": "center"},
    "path_effects": [matplotlib.patheffects.withStroke(linewidth=2.5, foreground="#30503a")],
}


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


def label(axes, found, path):
    """The minutes of each isoline, where the path and other labels leave most room."""
    taken = list(map_of(path["points"]).T)
    for level in found["levels"]:
        places = np.concatenate(
            [map_of(line["points"]).T for line in found["isolines"] if line["level"] == level]
        )
        inside = places[np.all((places > 200) & (places < 2800), axis=1)]
        room = np.min([np.linalg.norm(inside - place, axis=1) for place in taken], axis=0)
        taken.append(inside[room.argmax()])
        axes.text(*taken[-1], f"{level / 60:.0f} min", **LABEL)


def profile(axes, path, colour, told):
    """Its heights over its length."""
    points = np.array([point["xyz"] for point in path["points"]])
    along = np.concatenate([[0], np.linalg.norm(np.diff(points, axis=0), axis=1).cumsum()])
    axes.plot(along / 1000, points[:, 1], color=colour, lw=1.6, label=told)


def main():
    """The map and the profiles."""
    server = sys.argv[1].rstrip("/")
    with urllib.request.urlopen(f"{server}/v1/meshes", data=hills()) as reply:
        mesh = f"{server}/v1/meshes/" + json.load(reply)["id"]
    positions, triangles = geometry_of(mesh)
    ends = f"from={FROM}&to={TO}"
    shortest = get_json(f"{mesh}/path?{ends}&method=exact")
    quickest = get_json(f"{mesh}/path?{ends}&slope=tobler&forbid={LAKE}")
    lines = get_json(f"{mesh}/isolines?from={FROM}&slope=tobler&step=600&forbid={LAKE}")

    figure = plt.figure(figsize=(9, 4.4))
    axes = figure.add_axes((0.01, 0.02, 0.47, 0.96))
    height = np.clip((positions[:, 1] + 250) / 560, 0, 1)
    draw_ground(axes, positions, triangles, plt.get_cmap("YlGn_r")(0.2 + 0.8 * height)[:, :3])
    axes.fill(*map_of(line_round(mesh, STOPS)["points"]), color=WATER, lw=0)
    draw_isolines(axes, lines, "white", 1.2)
    draw_way(axes, shortest, ":", GREY)
    draw_way(axes, quickest, "-", ORANGE)
    label(axes, lines, quickest)
    axes.set_xlim(0, 3000)
    axes.set_ylim(3000, 0)

    axes = figure.add_axes((0.57, 0.14, 0.41, 0.78))
    profile(axes, shortest, GREY, f"shortest: {shortest['length']:.0f} m")
    told = f"quickest: {quickest['length']:.0f} m, {quickest['cost'] / 60:.0f} min"
    profile(axes, quickest, ORANGE, told)
    axes.set_xlabel("way (km)")
    axes.set_ylabel("height (m)")
    axes.legend(frameon=False, loc="upper right", fontsize=9)
    axes.set_ylim(-100, 160)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    save(figure, "costs.png")


if __name__ == "__main__":
    main()
