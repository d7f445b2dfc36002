"""A route over land: the shortest walk between two places, with its profile of heights. A ridge
lies across the way; the way round by the pass is longer on the map and shorter on foot.

    python terrain_route.py [PROFILE.csv]
"""

from __future__ import annotations

import sys

import numpy as np
from shapes import hills

import geodesicd


def main(arguments: list[str]) -> None:
    """Prints the route's length and climb, beside those of the straight line on the map."""
    side, height = 121, 80.0
    start, goal = (5.0, 30.0, 0.0), (115.0, 30.0, 0.0)
    with geodesicd.connect() as client:
        mesh = client.upload(hills(side, height))
        route = mesh.path(start, goal, refine="shortest")
        # Straight on the map is up and over: a walk through many places under that line.
        under = [(x, 30.0, height) for x in np.linspace(start[0], goal[0], 60)[1:-1]]
        rays = [geodesicd.Ray(place, (0, 0, -1)) for place in under]
        over = mesh.path(start, goal, via=rays, refine="shortest")
    for name, way in (("route", route), ("straight", over)):
        climb = np.diff(way.points[:, 2]).clip(min=0).sum()
        print(f"{name} {way.length:.2f} climb {climb:.2f} highest {way.points[:, 2].max():.2f}")
    if arguments:
        profile = np.column_stack([route.along, route.points[:, 2]])
        np.savetxt(arguments[0], profile, "%.6g", ",", header="along,height", comments="")


if __name__ == "__main__":
    main(sys.argv[1:])
