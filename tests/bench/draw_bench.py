#!/usr/bin/env python3
"""Draws the benchmark: error against time, one dot a method, peers included.

    draw_bench.py BENCH.json FOLDER

Writes FOLDER/error_against_time.png. Needs numpy and matplotlib.
"""

import json
import pathlib
import sys

from plot_style import draw_error_against_time


def main():
    """Takes all meshes on which errors are known."""
    document = json.loads(pathlib.Path(sys.argv[1]).read_text(encoding="utf-8"))
    rows = []
    peers = set()
    for mesh in document["meshes"]:
        for entrant in mesh["entrants"]:
            if "failure" in entrant or "mean_relative_error" not in entrant:
                continue
            # A peer's name is its package and what of it was run.
            name = entrant["name"] if entrant["ours"] else entrant["name"].replace("_", " ")
            if not entrant["ours"]:
                peers.add(name)
            rows.append(
                (name, mesh["mesh"], entrant["over_textbook"], entrant["mean_relative_error"])
            )
    meshes = len({row[1] for row in rows})
    draw_error_against_time(
        rows,
        pathlib.Path(sys.argv[2]) / "error_against_time.png",
        f"medians over {meshes} meshes (small: one mesh); squares: other people's libraries",
        peers,
    )


if __name__ == "__main__":
    main()
