"""Anthropometry: a tape measure round a body. The tape goes through marks on the skin and back
to the first: a path with via points, whose end is its start. On a sphere the answer is known, so
the example measures one: through four marks on the equator it is a great circle.

    python tape.py [MESH X,Y,Z X,Y,Z X,Y,Z ...]
"""

from __future__ import annotations

import sys

import numpy as np
from shapes import sphere

import geodesicd


def girth(mesh: geodesicd.Mesh, marks: list[tuple[float, float, float]]) -> geodesicd.Path:
    """The tape through ``marks`` (places near the skin, mesh units) and back to the first."""
    return mesh.path(marks[0], marks[0], via=marks[1:], refine="shortest", method="exact")


def main(arguments: list[str]) -> None:
    """Measures, and says how much the tape differs from the straight chords between marks."""
    with geodesicd.connect() as client:
        if arguments:
            mesh = client.upload(arguments[0])
            marks = []
            for argument in arguments[1:]:
                x, y, z = (float(number) for number in argument.split(","))
                marks.append((x, y, z))
        else:
            mesh = client.upload(sphere(5))
            marks = [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0), (0.0, -1.0, 0.0)]
        tape = girth(mesh, marks)
        placed = np.array([tape.source.xyz, *(via.xyz for via in tape.via), tape.target.xyz])
        chords = np.linalg.norm(np.diff(placed, axis=0), axis=1).sum()
        print(f"girth {tape.length:.5f} through {len(marks)} marks")
        print(f"chords {chords:.5f}")
        print(f"closed {np.array_equal(tape.points[0], tape.points[-1])}")


if __name__ == "__main__":
    main(sys.argv[1:])
