"""Seeds for a remesher: vertices spread evenly over a surface by farthest-point sampling, with
the triangles between them (the dual of their geodesic Voronoi diagram).

    python remesh_seeds.py [COUNT [MESH]]
"""

from __future__ import annotations

import sys

import numpy as np
from shapes import sphere

import geodesicd


def dual_triangles(
    labels: np.typing.NDArray[np.int64], triangles: np.typing.NDArray[np.int64]
) -> np.typing.NDArray[np.int64]:
    """(k, 3) the seeds whose regions meet in a face, each once, in the face's direction."""
    owners = labels[triangles]
    meeting = owners[
        (owners[:, 0] != owners[:, 1])
        & (owners[:, 1] != owners[:, 2])
        & (owners[:, 2] != owners[:, 0])
    ]
    turn = meeting.argmin(axis=1)[:, None] + np.arange(3)
    return np.unique(np.take_along_axis(meeting, turn % 3, axis=1), axis=0)


def main(arguments: list[str]) -> None:
    """Prints how evenly the seeds lie and what their triangles make."""
    count = int(arguments[0]) if arguments else 80
    with geodesicd.connect() as client:
        mesh = client.upload(arguments[1] if len(arguments) > 1 else sphere(5))
        seeds = mesh.samples(count)
        geometry = mesh.geometry()
        field, labels = mesh.distance(seeds.vertices, labels=True)
        apart = mesh.table(seeds.vertices)
    np.fill_diagonal(apart, np.inf)
    coarse = dual_triangles(labels, geometry.triangles)
    edges = np.unique(np.sort(coarse[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    print(f"seeds {len(seeds)} covering radius {seeds.covering_radius:.4f}")
    print(f"farthest vertex {field[np.isfinite(field)].max():.4f}")
    print(f"least apart {apart.min():.4f}")
    print(f"triangles {len(coarse)} Euler {len(seeds) - len(edges) + len(coarse)}")


if __name__ == "__main__":
    main(sys.argv[1:])
