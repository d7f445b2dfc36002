"""``geodesic logmap``: the surface round a point laid into the plane, as a file or as CSV."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from .command_line import (
    bar,
    exactness_of,
    into,
    mesh_of,
    people,
    point,
    require_into,
    save_annotated,
)
from .digits import number, numbers, short
from .encoding import as_bound, milliseconds
from .errors import Misuse
from .outputs import require, save_arrays, save_reply, save_rows, save_text
from .results import Logmap

_ENDINGS = (".csv", ".npz", ".json", ".glb")
# What files have, by the names of the contract.
_NAMES = (
    "angle", "radius", "total_angle", "all_round",
    "vertices", "distances", "angles", "straight", "coordinates",
)  # fmt: skip


def arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments that are this command's own."""
    parser.add_argument("--radius", type=float, metavar="N", help="farther has no place")
    parser.add_argument(
        "--angle", type=float, default=0.0, metavar="A", help="of the x axis, radians (%(default)s)"
    )
    parser.add_argument(
        "--transport", action="store_true", help="carry the direction of the x axis along the paths"
    )
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FILE",
        help=".csv, .npz, .json or .glb; else printed as CSV",
    )  # fmt: skip
    into(parser)


def run(options: argparse.Namespace) -> int:
    """Runs the command; its exit status."""
    file: Path | None = options.output
    require(file, _ENDINGS)
    require_into(options)
    asked: dict[str, Any] = {"radius": as_bound(options.radius), "angle": options.angle}
    asked |= exactness_of(options)
    if options.transport:
        asked["transport"] = True
    source = point(options.sources)
    with mesh_of(options) as mesh, bar("logmap") as progress:
        if options.into is not None:
            if file is not None:
                raise Misuse("--into is a file of its own")
            asked |= {"from": source, "deadline_ms": milliseconds(asked.pop("deadline"))}
            return save_annotated(options, mesh, "logmap", asked, progress)
        if file is not None and file.suffix == ".glb":
            save_reply(file, mesh, "logmap", {"from": source, **asked}, progress)
            told = str(file)
        else:
            found = mesh.logmap(source, progress=progress, **asked)
            told = f"{file}: {len(found):,} of {mesh.vertices:,} vertices have a place"
    if file is None:
        print("\n".join(_rows(found)))
        return 0
    if file.suffix != ".glb":
        _save(file, found)
    people.print(told, markup=False, soft_wrap=True)
    return 0


def _rows(found: Logmap) -> Iterator[str]:
    """The lines of its CSV."""
    carried = () if found.directions is None else tuple(found.directions.T)
    yield "vertex,distance,angle,straight,x,y" + (",dx,dy,dz" if carried else "")
    columns = (found.distances, found.angles, found.straight, *found.coordinates.T, *carried)
    vertices = map(str, found.vertices.tolist())
    yield from map(",".join, zip(vertices, *map(numbers, columns), strict=True))


def _names(found: Logmap) -> tuple[str, ...]:
    return _NAMES if found.directions is None else (*_NAMES, "directions")


def _save(file: Path, found: Logmap) -> None:
    if file.suffix == ".csv":
        save_rows(file, _rows(found))
    elif file.suffix == ".npz":
        save_arrays(file, **{name: getattr(found, name) for name in _names(found)})
    elif file.suffix == ".json":
        document = {name: _plain(getattr(found, name)) for name in _names(found)}
        save_text(file, json.dumps(document) + "\n")


def _plain(value: Any) -> Any:
    """As the contract's JSON has it, in as few digits as say it."""
    if isinstance(value, bool):
        return value
    if isinstance(value, float):
        return float(number(value))
    return short(value).tolist() if value.dtype == np.float64 else value.astype(int).tolist()
