"""What a query costs a server, as straight lines in the vertices of its mesh."""

import dataclasses
import json

import numpy as np


@dataclasses.dataclass
class Costs:
    """`seconds`, `cpu_seconds` and `bytes` have an (amount, amount a vertex) for each part:

    seconds      read (of a directory), decode, prepare, field and encode, which Server-Timing names
    cpu_seconds  load (read, decode, prepare), field (with its reply) and reply (one that is kept)
    bytes        file, mesh, adjacency, field and reply

    `spread`: quantiles of what a computed query took, divided by what the lines say. `around` and
    `around_kept`: quantiles of the seconds that a computed query takes beside these parts, and of those
    that one takes whose reply is kept.
    """

    seconds: dict
    cpu_seconds: dict
    bytes: dict
    spread: list
    around: list
    around_kept: list

    def of(self, kind, part, vertices):
        """What a part takes for a mesh of so many vertices."""
        fixed, each = getattr(self, kind)[part]
        return fixed + each * vertices

    def write(self, file):
        """As JSON."""
        with open(file, "w", encoding="utf-8") as out:
            json.dump(dataclasses.asdict(self), out, indent=1)
            out.write("\n")


def read_costs(file):
    """What `write` has written."""
    with open(file, encoding="utf-8") as text:
        return Costs(**json.load(text))


def line_through(vertices, amounts):
    """(amount, amount a vertex) with the least relative errors; neither is negative."""
    vertices, amounts = np.asarray(vertices, float), np.maximum(np.asarray(amounts, float), 1e-12)
    both = np.stack([1 / amounts, vertices / amounts], axis=1)
    fixed, each = np.linalg.lstsq(both, np.ones(len(amounts)), rcond=None)[0]
    if fixed < 0 or each < 0:
        only = 1 if fixed < 0 else 0
        column = both[:, only]
        alone = column.sum() / (column @ column)
        fixed, each = (0.0, alone) if only else (alone, 0.0)
    return float(fixed), float(each)


def quantiles(values, count=41):
    """So many evenly spaced quantiles, the least and the largest included."""
    return [float(value) for value in np.quantile(values, np.linspace(0, 1, count))]


def drawn_from(quantiles_, random, size):
    """Numbers of the distribution that has these quantiles."""
    return np.interp(random.random(size), np.linspace(0, 1, len(quantiles_)), quantiles_)
