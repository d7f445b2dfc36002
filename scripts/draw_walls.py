#!/usr/bin/env python3
"""Draws docs/walls.png: the terrain with a fence, the way that went through it and the one round its
end; beside it the isolines round the start, which bend round both ends of the fence.

    draw_walls.py SERVER

SERVER is the address of one that has the sample meshes (`make run`). Needs numpy and matplotlib.
"""

import sys

import matplotlib.pyplot as plt

from page_pictures import (
    draw_ground,
    draw_isolines,
    draw_way,
    geometry_of,
    get_json,
    sample_at,
    save,
)

FROM, TO = "ray:33,99,-55,0,-1,0", "ray:78,99,-45,0,-1,0"
# Posts of the fence, x and z.
POSTS = [(62, -88), (54, -68), (52, -40), (60, -22)]
WALL = ";".join(f"ray:{x},99,{z},0,-1,0" for x, z in POSTS)


def main():
    """Both panels."""
    mesh = sample_at(sys.argv[1], "terrain.glb")
    ends = f"from={FROM}&to={TO}&method=exact"
    through = get_json(f"{mesh}/path?{ends}")
    round_it = get_json(f"{mesh}/path?{ends}&walls={WALL}")
    posts = WALL.split(";")
    via = "".join(f"&via={post}" for post in posts[1:-1])
    fence = get_json(f"{mesh}/path?from={posts[0]}{via}&to={posts[-1]}&method=exact")
    lines = get_json(f"{mesh}/isolines?from={FROM}&method=exact&step=10&walls={WALL}")

    figure = plt.figure(figsize=(9, 4.5))
    panels = [figure.add_axes((left, 0.005, 0.495, 0.99)) for left in (0, 0.505)]
    surface = geometry_of(mesh)
    for axes in panels:
        draw_ground(axes, *surface)
        axes.set_xlim(10, 110)
        axes.set_ylim(-5, -105)
    draw_way(panels[0], through, ":", "#222222")
    draw_isolines(panels[1], lines, "#0072B2", 1.2)
    for axes in panels:
        draw_way(axes, fence, "-", "black", 3.5, ends=())
    draw_way(panels[0], round_it, "-", "#D55E00")
    draw_way(panels[1], {"points": round_it["points"][:1]}, "-", "#D55E00")
    save(figure, "walls.png")


if __name__ == "__main__":
    main()
