"""How our figures look, and the picture that the benchmark and the report share:
error against time, one dot a method.

Needs numpy and matplotlib.
"""

import io

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from PIL import Image

plt.rcParams.update(
    {
        "font.family": "DejaVu Sans",
        "font.size": 11,
        "axes.titlesize": 11,
        "axes.labelsize": 11,
        "legend.fontsize": 10,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "figure.dpi": 100,
        "savefig.dpi": 115,
        "savefig.facecolor": "white",
    }
)

# Colours that stay apart for colour-blind readers (Okabe and Ito, and a brown).
PALETTE = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#7B3F00"]
# Errors below this are rounding: they are drawn on a line of their own.
ROUNDING = 1e-8


def save(figure, path):
    """Writes a PNG without what differs from run to run. Every third shade of a
    channel, which nobody sees, makes it a third smaller."""
    picture = io.BytesIO()
    figure.savefig(picture, bbox_inches="tight", pad_inches=0.08)
    plt.close(figure)
    shades = np.asarray(Image.open(picture).convert("RGB"))
    shades = (3 * np.rint(shades / 3)).astype(np.uint8)
    Image.fromarray(shades).save(path, optimize=True)
    print(path)


def words_of(label):
    """The box of an annotation's words, without the line to its dot."""
    renderer = label.figure.canvas.get_renderer()
    label.update_positions(renderer)
    return matplotlib.text.Text.get_window_extent(label, renderer)


def place_labels(axes, points):
    """Names beside dots, moved up or down until they clear each other."""
    figure = axes.figure
    figure.canvas.draw()
    taken = []  # by dots, and then by labels
    for x, y, _, _ in points:
        px, py = axes.transData.transform((x, y))
        taken.append(matplotlib.transforms.Bbox.from_extents(px - 10, py - 10, px + 10, py + 10))
    for x, y, text, colour in sorted(points, key=lambda p: (p[0], p[1])):
        best = None
        for dx, dy, side in ((9, 0, "left"), (0, 13, "center"), (0, -13, "center"), (-9, 0, "right"),
                             (9, 11, "left"), (9, -11, "left"), (-9, 11, "right"),
                             (-9, -11, "right"), (0, 26, "center"), (0, -26, "center"),
                             (9, 24, "left"), (9, -24, "left"), (-9, 24, "right"),
                             (-9, -24, "right"), (0, 40, "center"), (0, -40, "center"),
                             (0, 54, "center"), (0, -54, "center"), (0, 68, "center")):
            label = axes.annotate(
                text, (x, y), (dx, dy), textcoords="offset points", ha=side, va="center",
                color=colour, fontsize=10, fontweight="bold",
                arrowprops={"arrowstyle": "-", "color": colour, "lw": 0.6}
                if abs(dy) > 20 else None,
            )
            box = words_of(label)
            inside = axes.get_window_extent().contains(box.x0, box.y0) and (
                axes.get_window_extent().contains(box.x1, box.y1)
            )
            clear = not any(box.overlaps(other) for other in taken)
            if inside and clear:
                best = label
                break
            label.remove()
        if best is None:
            best = axes.annotate(text, (x, y), (9, 0), textcoords="offset points", va="center",
                                 color=colour, fontsize=10, fontweight="bold")
        taken.append(words_of(best))


def draw_error_against_time(rows, path, title, others=(), yardstick="a textbook Dijkstra's"):
    """rows: (method, mesh, time in those of the yardstick, mean relative error). A large dot is a
    method's medians over the meshes, a small one a single mesh. `others` are
    drawn as squares: the methods that are not ours."""
    figure, axes = plt.subplots(figsize=(9, 6.2))
    methods = list(dict.fromkeys(row[0] for row in rows))
    ours = list(dict.fromkeys(method.split()[0] for method in methods if method not in others))
    points = []
    for method in methods:
        # A method has one colour, whatever it is asked for ("auto 1e-3").
        number = 0 if method in others else ours.index(method.split()[0])
        colour = "0.45" if method in others else PALETTE[number % len(PALETTE)]
        marker = "s" if method in others else "o"
        times = np.array([row[2] for row in rows if row[0] == method])
        errors = np.maximum([row[3] for row in rows if row[0] == method], ROUNDING)
        axes.scatter(times, 100 * errors, s=16, color=colour, alpha=0.35, lw=0, marker=marker)
        x, y = np.median(times), 100 * np.median(errors)
        axes.scatter([x], [y], s=120, color=colour, edgecolor="white", lw=1, zorder=3,
                     marker=marker)
        points.append((x, y, method, colour))
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.axhspan(50 * ROUNDING, 200 * ROUNDING, color="0.92", lw=0, zorder=0)
    axes.set_ylim(15 * ROUNDING, 60)
    left, right = axes.get_xlim()
    axes.set_xlim(left / 1.15, right * 1.5)
    axes.text(0.01, 45 * ROUNDING, "exact up to rounding", va="top", color="0.4", fontsize=9,
              transform=axes.get_yaxis_transform())
    axes.xaxis.set_major_formatter(matplotlib.ticker.FormatStrFormatter("%g"))
    axes.set_xlabel(f"time, as a multiple of {yardstick} in the same run")
    axes.set_ylabel("mean relative error, %")
    axes.grid(True, which="major", color="0.9", lw=0.6)
    axes.set_axisbelow(True)
    axes.set_title(title, loc="left")
    place_labels(axes, points)
    save(figure, path)
