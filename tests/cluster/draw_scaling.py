#!/usr/bin/env python3
"""Draws what simulate.py predicts: shares of kept meshes and times against the number of replicas.

    draw_scaling.py TABLE OUT

Needs matplotlib and Pillow.
"""

import pathlib
import re
import sys

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1] / "bench")]

from plot_style import PALETTE, plt, save  # noqa: E402


def rows_of(file):
    """(replicas, meshes, share of kept meshes, p99 in ms) of each row of a table."""
    for line in pathlib.Path(file).read_text(encoding="utf-8").splitlines()[2:]:
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        number = [float(re.match(r"[\d.,]+", cell)[0].replace(",", "")) for cell in cells]
        yield int(number[0]), int(number[1]), number[4], number[6]


def main():
    """Two panels, a line for each number of meshes."""
    rows = sorted(rows_of(sys.argv[1]))
    figure, (kept, late) = plt.subplots(1, 2, figsize=(9, 3.4))
    for colour, meshes in zip(PALETTE, sorted({row[1] for row in rows})):
        mine = [row for row in rows if row[1] == meshes]
        replicas = [row[0] for row in mine]
        kept.plot(replicas, [row[2] for row in mine], "o-", color=colour, label=f"{meshes:,} meshes")
        late.plot(replicas, [row[3] for row in mine], "o-", color=colour)
    for axes, title in ((kept, "queries on a mesh in memory, %"), (late, "99 % take at most, ms")):
        axes.set_xscale("log")
        axes.set_ylim(bottom=0)
        axes.set_xlabel("replicas, 100 queries a second each")
        axes.set_title(title, loc="left")
        axes.grid(True, color="0.9", lw=0.6)
    figure.legend(loc="upper center", bbox_to_anchor=(0.5, 1.08), ncol=3, frameon=False)
    save(figure, sys.argv[2])
    return 0


if __name__ == "__main__":
    sys.exit(main())
