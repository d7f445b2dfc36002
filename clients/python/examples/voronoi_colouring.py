"""Geodesic Voronoi colouring: each vertex in the colour of its nearest site, drawn to a file.

python voronoi_colouring.py OUT.png [SITES [MESH]]
"""

from __future__ import annotations

import sys

import numpy as np
from shapes import sphere

import geodesicd
from geodesicd.plot import draw


def main(arguments: list[str]) -> None:
    """Draws the regions and prints how large they are."""
    sites = int(arguments[1]) if len(arguments) > 1 else 12
    with geodesicd.connect() as client:
        mesh = client.upload(arguments[2] if len(arguments) > 2 else sphere(5))
        chosen = mesh.samples(sites)
        distances, labels = mesh.distance(chosen.vertices, labels=True)
        geometry = mesh.geometry()
        places = mesh.nearest(chosen.vertices)
        lines = mesh.isolines(chosen.vertices, count=6)
    # Neighbouring numbers are to have colours that differ: a stride through the scale.
    colours = (labels * 5 % sites).astype(float)
    colours[labels < 0] = np.inf
    figure = draw(
        geometry,
        colours,
        isolines=lines,
        smooth=False,
        sources=places,
        title=f"{sites} regions of nearest sites",
        label="colour of the region",
        colormap="tab20",
    )
    figure.savefig(arguments[0])
    sizes = np.bincount(labels[labels >= 0], minlength=sites)
    print(f"regions {sites} vertices {sizes.min()} to {sizes.max()} of {sizes.sum()}")
    print(f"farthest from a site {distances[np.isfinite(distances)].max():.4f}")
    print(f"isolines {len(lines)}")


if __name__ == "__main__":
    main(sys.argv[1:])
