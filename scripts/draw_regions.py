#!/usr/bin/env python3
"""Draws docs/regions.png: the terrain with a lake that is forbidden, the way over its ground and the
way round it, and the distances that go round it.

    draw_regions.py SERVER

SERVER is the address of one that has the sample meshes (`make run`). Needs numpy and matplotlib.
"""

import sys

import matplotlib.pyplot as plt

from page_pictures import (
    WATER,
    Glb,
    draw_ground,
    draw_isolines,
    draw_way,
    geometry_of,
    get,
    get_json,
    line_round,
    map_of,
    sample_at,
    save,
)

FROM, TO = "ray:33,99,-55,0,-1,0", "ray:78,99,-45,0,-1,0"
# The shore of docs/regions.md, x and z.
SHORE = (
    *((32, -84), (44, -84), (56, -85), (61, -77), (68, -73), (73, -60), (71, -48), (77, -42)),
    *((78, -33), (64, -24), (55, -22), (52, -29), (43, -32), (41, -46), (46, -60), (36, -71)),
)
STOPS = [f"ray:{x},99,{z},0,-1,0" for x, z in SHORE]
LAKE = "inside:" + ";".join(STOPS)


def distances_of(mesh):
    """The ground that is left, coloured by distance: positions, triangles, colours."""
    asked = f"from={FROM}&method=exact&forbid={LAKE}&format=glb"
    drawing = Glb(get(f"{mesh}/distance?{asked}"))
    primitive = drawing.document["meshes"][0]["primitives"][0]
    named = primitive["attributes"]
    colours = (drawing.accessor(named["COLOR_0"])[:, :3] / 255) ** (1 / 2.2)  # linear in glTF
    return drawing.accessor(named["POSITION"]), drawing.triangles(primitive), colours


def main():
    """Both panels."""
    mesh = sample_at(sys.argv[1], "terrain.glb")
    ends = f"from={FROM}&to={TO}&method=exact"
    through = get_json(f"{mesh}/path?{ends}")
    round_it = get_json(f"{mesh}/path?{ends}&forbid={LAKE}")
    lines = get_json(f"{mesh}/isolines?from={FROM}&method=exact&step=10&forbid={LAKE}")

    figure = plt.figure(figsize=(9, 4.5))
    panels = [figure.add_axes((left, 0.005, 0.495, 0.99)) for left in (0, 0.505)]
    draw_ground(panels[0], *geometry_of(mesh))
    panels[0].fill(*map_of(line_round(mesh, STOPS)["points"]), color=WATER, lw=0)
    draw_way(panels[0], through, ":", "#222222")
    draw_ground(panels[1], *distances_of(mesh))
    draw_isolines(panels[1], lines, "white", 0.9)
    for axes in panels:
        draw_way(axes, round_it, "-", "#D55E00")
        axes.set_xlim(10, 110)
        axes.set_ylim(-5, -105)
    save(figure, "regions.png")


if __name__ == "__main__":
    main()
