"""The commands that ask about one mesh: what each is called, and which arguments it shares with
others."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from functools import partial
from typing import Any, Protocol

from . import (
    distance_command,
    extent_command,
    isolines_command,
    logmap_command,
    loop_command,
    measure_command,
    nearest_command,
    path_command,
    plot_command,
    samples_command,
    table_command,
    trace_command,
    voronoi_command,
)
from .command_line import connection, costs, exactness, mesh_and_sources, surface, the_mesh

Arguments = Callable[[argparse.ArgumentParser], None]


class _Command(Protocol):
    """A module of a command of its own."""

    def arguments(self, parser: argparse.ArgumentParser) -> None:
        """Adds the arguments that are this command's own."""

    def run(self, options: argparse.Namespace) -> int:
        """Runs the command; its exit status."""


_one_source = partial(mesh_and_sources, several=False)
_one_point = partial(mesh_and_sources, several=False, lines=False)
_sources_or_a_file = partial(mesh_and_sources, required=False, default=[])
_in_pictures = (partial(exactness, steiner=False), surface, partial(costs, up=False))


def add(command: Callable[..., Any]) -> None:
    """Adds these commands. ``command(name, usage, run, help)`` makes one; its arguments come in the
    order of its help."""

    def query(
        name: str,
        usage: str,
        module: _Command,
        help: str,
        *shared: Arguments,
        about: Arguments = mesh_and_sources,
    ) -> None:
        made = command(name, f"MESH {usage}", module.run, help)
        for some in (about, module.arguments, *shared, connection):
            some(made)

    query(
        "distance", "--from POINT", distance_command,
        "Save a distance field, or print distances.", exactness, surface, costs,
    )  # fmt: skip
    query(
        "path", "--from POINT --to POINT", path_command,
        "Find the shortest path between two points.", exactness, surface, costs, about=_one_source,
    )  # fmt: skip
    query(
        "table", "--from POINT", table_command,
        "Print distances among points, as CSV.", exactness, surface, costs,
        about=_sources_or_a_file,
    )  # fmt: skip
    query(
        "isolines", "--from POINT", isolines_command,
        "Draw lines of equal distance.", exactness, surface, costs,
    )  # fmt: skip
    query(
        "trace", "--from POINT --length N", trace_command,
        "Go straight over the surface.", surface, about=_one_point,
    )  # fmt: skip
    query(
        "nearest", "POINT...", nearest_command,
        "Tell where on the surface points are.", surface, about=the_mesh,
    )  # fmt: skip
    query(
        "samples", "--count N", samples_command,
        "Spread vertices evenly over the surface.", exactness, surface, about=the_mesh,
    )  # fmt: skip
    query(
        "measure", "--from POINT", measure_command,
        "Measure discs: areas and outlines.", exactness, surface,
    )  # fmt: skip
    query(
        "extent", "--of MEASURE", extent_command,
        "Tell the diameter, or where the middle is.", exactness, surface, about=the_mesh,
    )  # fmt: skip
    query(
        "voronoi", "--from POINT", voronoi_command,
        "Divide the surface among sites.", exactness, surface,
    )  # fmt: skip
    query(
        "loop", "--through POINT --through POINT", loop_command,
        "Lay a loop or a tape round a surface.", exactness, surface, about=the_mesh,
    )  # fmt: skip
    query(
        "logmap", "--from POINT", logmap_command,
        "Lay the surface round a point flat.", exactness, surface, about=_one_point,
    )  # fmt: skip
    query(
        "plot", "--from POINT", plot_command,
        "Draw a field with isolines and a path.", *_in_pictures,
    )  # fmt: skip
