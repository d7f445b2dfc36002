#!/usr/bin/env python3
"""Writes the report's text from the tables of paper_report.

    write_report.py FOLDER

Reads FOLDER/*.csv, writes FOLDER/report.md. Every figure in the text is one of the
tables', rounded. Needs nothing but Python.
"""

import csv
import math
import pathlib
import platform
import re
import sys

FOLDER = pathlib.Path(sys.argv[1])


def table(name):
    """The rows of a CSV file, as dictionaries of text."""
    with open(FOLDER / f"{name}.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def number(text, digits=2):
    """Rounded to significant digits, as people write it."""
    value = float(text)
    if value == 0:
        return "0"
    if 1e-4 <= abs(value) < 10**6:
        # Trailing zeros are digits, too.
        rounded = float(f"{value:.{digits}g}")
        decimals = max(0, digits - 1 - math.floor(math.log10(abs(rounded))))
        text = f"{rounded:,.{decimals}f}"
    else:
        text = re.sub(r"e([+-])0?", r"e\1", f"{value:.{max(digits - 1, 1)}e}")
    return text.replace("-", "−", 1) if value < 0 else text


def percent(text, digits=2):
    """A ratio in per cent."""
    return number(100 * float(text), digits) + " %"


def times(text):
    """A ratio of times."""
    value = float(text)
    return f"{value:.2f}" if value < 10 else f"{value:,.0f}"


def milliseconds(text):
    """A time."""
    value = float(text)
    return f"{value:,.0f} ms" if value >= 100 else f"{number(value, 3)} ms"


def size(text):
    """Bytes."""
    value = float(text)
    return f"{value / 2**20:.1f} MiB" if value >= 2**20 else f"{value / 2**10:.0f} KiB"


def markdown(columns, rows):
    """A table; columns whose name begins with > are aligned to the right."""
    lines = ["| " + " | ".join(column.lstrip(">") for column in columns) + " |"]
    lines.append("|" + "|".join("--:" if c.startswith(">") else "---" for c in columns) + "|")
    lines += ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows]
    return "\n".join(lines)


def processor():
    """What this machine calls its processor."""
    try:
        info = pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8")
    except OSError:
        info = ""
    model = re.search(r"^model name\s*: (.*)$", info, re.MULTILINE)
    return model.group(1).strip() if model else platform.machine()


def one(rows, **wanted):
    """The only row with these values."""
    found = [row for row in rows if all(row[key] == value for key, value in wanted.items())]
    assert len(found) == 1, f"{wanted}: {len(found)} rows"
    return found[0]


def figure_5():
    """The plane."""
    rows = table("fig5")
    ours = one(rows, method="wavefront", diagonals="rising")
    return f"""## Fig. 5: a plane

{int(ours["vertices"]):,} vertices, the rectangle's edge 1, distances from its bottom left corner. The paper
reports a maximum error of 10⁻¹⁵ and a mean square error of 10⁻³¹. Here the wavefront's maximum
is {number(ours["max_error"])} and its mean square {number(ours["mean_square_error"])}: rounding.

![Isolines, colours and error on the plane](fig5.png)

The same for every method, with the squares cut by either diagonal. (`dijkstra` cannot leave the
edges, and the diagonals decide where it can go.)

{markdown(
    ["method", "diagonals", ">maximum error", ">mean square error", ">mean relative", ">maximum relative"],
    [
        [
            f"`{row['method']}`", row["diagonals"], number(row["max_error"]),
            number(row["mean_square_error"]), percent(row["mean_relative_error"]),
            percent(row["max_relative_error"]),
        ]
        for row in rows
    ],
)}

Table: [fig5.csv](fig5.csv)."""


def holes():
    """Figures 6 and 7."""
    rows = table("holes")
    below = one(rows, figure="fig7a", diagonals="rising", method="wavefront")
    above = one(rows, figure="fig7b", diagonals="rising", method="wavefront")
    names = {"fig6": "6, one hole", "fig7a": "7 (a), two", "fig7b": "7 (b), three"}
    return f"""## Figs. 6 and 7: planes with holes

The same plane, 1 between neighbours, with square holes. Distances and path lengths are from
corner to corner; the truth is a closed form (the shortest way bends only at the holes' corners).

![Isolines and colours round one hole, with the path](fig6.png)

![The path passes below two holes, and above when there is a third](fig7.png)

With two holes the path passes {below["passes"]} the first; the third hole sends it {above["passes"]}, as in the
paper. (In Fig. 6 both ways round the hole are equally long.)

{markdown(
    ["figure", "diagonals", "method", ">true distance", ">distance", ">its error", ">path", ">its error", "passes"],
    [
        [
            names[row["figure"]], row["diagonals"], f"`{row['method']}`",
            number(row["true_distance"], 6), number(row["distance"], 6),
            percent(row["distance_error"]), number(row["path_length"], 6),
            percent(row["path_error"]), row["passes"],
        ]
        for row in rows
    ],
)}

Tables: [holes.csv](holes.csv); the paths drawn: [fig6_path.csv](fig6_path.csv),
[fig7a_path.csv](fig7a_path.csv), [fig7b_path.csv](fig7b_path.csv)."""


def figure_8():
    """The horse."""
    rows = table("fig8")
    body = "a scanned horse" if rows[0]["body"] == "horse" else "a generated body"
    return f"""## Fig. 8: {body}

{int(rows[0]["vertices"]):,} vertices, all distances by the wavefront from the top of the nose; isolines, and paths
traced back from {len(rows)} points. Against `exact` the field's mean relative error is
{percent(rows[0]["mean_error"])}, its maximum {percent(rows[0]["max_error"])}.

![The field from the top of the nose, with paths](fig8.png)

{markdown(
    ["path to the", ">true distance", ">distance", ">its error", ">path", ">its error"],
    [
        [
            row["to"], number(row["true_distance"], 5), number(row["distance"], 5),
            percent(float(row["distance"]) / float(row["true_distance"]) - 1),
            number(row["path_length"], 5),
            percent(float(row["path_length"]) / float(row["true_distance"]) - 1),
        ]
        for row in rows
    ],
)}

Table: [fig8.csv](fig8.csv)."""


def time_and_memory():
    """The paper's paragraphs on both."""
    rows = table("timing")
    ours = one(rows, method="wavefront")
    theirs = one(rows, method="novotni")
    vertices = int(ours["vertices"])
    return f"""## Time and memory

The paper: under 5 s for nearly 20,000 vertices on a 2.4 GHz processor, and 7.5 s for Novotni and
Klein's method on a mesh of similar size at 1.2 GHz. Here, for {vertices:,} vertices on one core of
{processor()}: {milliseconds(ours["ms"])} for the wavefront, {milliseconds(theirs["ms"])} for `novotni`.

The paper keeps a float and two integers a vertex, 12 bytes. Here the distance is a double:
{int(ours["field_bytes"]) / vertices:.1f} bytes a vertex for the field, and {int(ours["peak_bytes"]) / vertices:.1f} at the
most while it is computed. y is the time of a textbook edge Dijkstra in the same round.

{markdown(
    ["method", ">time", ">y", ">bytes a vertex at the most", ">mean error"],
    [
        [
            f"`{row['method']}`", milliseconds(row["ms"]), times(row["y"]),
            number(int(row["peak_bytes"]) / vertices, 3), percent(row["mean_error"]),
        ]
        for row in rows
    ],
)}

Table: [timing.csv](timing.csv)."""


def novotni():
    """Where the two cases matter."""
    return f"""## Novotni against ours

Novotni and Klein take the straight line from the virtual source whether or not it crosses the
triangle's base; Tang et al. bend it at the base's end when it does not (cases (b) and (c) of their
Fig. 4). Past the end the line leaves the surface and is too short; what is computed from such a
distance inherits that, so that far more vertices are wrong than those where a case decides.

![Where the cases decide, and the errors of both rules](novotni.png)

“Bent” is the share of vertices whose distance the wavefront has by case (b) or (c), and at which
Novotni and Klein's rule says something else; “differ” the share at which the two fields differ. Errors are relative, against `exact`;
the lowest is the worst on the short side.

{markdown(
    ["mesh", ">bent", ">differ", ">mean difference", ">largest", ">`novotni` mean error", ">lowest", ">`wavefront` mean error", ">lowest"],
    [
        [
            row["title"], percent(row["share_bent"]), percent(row["share_different"]),
            percent(row["mean_difference"]), percent(row["max_difference"]),
            percent(row["novotni_mean"]), percent(row["novotni_lowest"]), percent(row["ours_mean"]),
            percent(row["ours_lowest"]),
        ]
        for row in table("novotni")
    ],
)}

Table: [novotni.csv](novotni.csv)."""


def every_method():
    """The table that the paper never had."""
    rows = table("table")
    rounds = max(int(row["rounds"]) for row in rows)
    once = [row for row in rows if int(row["rounds"]) < rounds]
    parts = [
        f"""## Every method, every mesh

From vertex 0. Errors are relative, against `exact` on the same mesh; “below” is the share of
vertices whose distance is below the true one by more than 10⁻⁹ of it. Times, of the processor, are medians of {rounds}
rounds, in each of which every method ran in turn, and y is the median of their ratios within a round to a
textbook edge Dijkstra on the same mesh: neighbours in lists, vertices in a heap, and the quicker of two
orders of the vertices. Memory is the most that a query held at once beyond the mesh and its adjacency,
the field itself and what paths need included, counted at every allocation.

![Error against time](every_method.png)"""
    ]
    if once:
        parts.append("† Took over two seconds, and was timed in one round only.")
    for mesh in dict.fromkeys(row["mesh"] for row in rows):
        of_mesh = [row for row in rows if row["mesh"] == mesh]
        vertices = int(of_mesh[0]["vertices"])
        parts.append(f"### {of_mesh[0]['title']}: {vertices:,} vertices")
        parts.append(
            markdown(
                ["method", ">mean", ">RMS", ">99.9th percentile", ">maximum", ">below", ">y", ">time", ">peak memory", ">a vertex"],
                [
                    [
                        f"`{row['method']}`", percent(row["mean_error"]), percent(row["rms_error"]),
                        percent(row["p999_error"]), percent(row["max_error"]),
                        percent(row["share_below"]),
                        times(row["y"]) + ("†" if row in once else ""),
                        milliseconds(row["ms"]), size(row["peak_bytes"]),
                        f"{int(row['peak_bytes']) / vertices:,.0f} B",
                    ]
                    for row in of_mesh
                ],
            )
        )
    missing = [row for row in rows if int(row["unreached"]) > 0]
    for row in missing:
        parts.append(
            f"**`{row['method']}` on {row['title']} misses or invents {row['unreached']} vertices.**"
        )
    parts.append("Table: [table.csv](table.csv).")
    return "\n\n".join(parts)


def exact():
    """What the references are worth."""
    return f"""## Is `exact` exact?

Against what is known without our code: closed forms on the planes; on the scans the distances of a
public implementation, which it computed on positions in double precision, where ours are the
files' floats.

{markdown(
    ["mesh", "truth", "method", ">vertices", ">mean error", ">maximum error"],
    [
        [
            row["title"], row["known_from"], f"`{row['method']}`", f"{int(row['compared']):,}",
            percent(row["mean_error"]), percent(row["max_error"]),
        ]
        for row in table("exact")
    ],
)}

Table: [exact.csv](exact.csv)."""


def main():
    """All of it."""
    head = """# The paper again

J. Tang, G.-S. Wu, F.-Y. Zhang, M.-M. Zhang: *Fast Approximate Geodesic Paths on Triangle Mesh*,
2007, section 4, with this library. `make paper` makes this report anew, its pictures and the CSV
files behind every figure in it."""
    parts = [head, figure_5(), holes(), figure_8(), time_and_memory(), novotni(), every_method(), exact()]
    (FOLDER / "report.md").write_text("\n\n".join(parts) + "\n", encoding="utf-8")
    print(FOLDER / "report.md")


if __name__ == "__main__":
    main()
