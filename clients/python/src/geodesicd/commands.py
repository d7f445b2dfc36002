"""The command ``geodesic``: what the client does, from a shell. ``geodesic COMMAND --help``
tells each one's arguments. Exit status: 0 done, 1 refused or failed, 2 asked wrongly, 130
interrupted."""

from __future__ import annotations

import argparse
import json
import os
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, cast

import numpy as np
from rich.table import Table
from rich.text import Text

from . import __version__
from .client import Mesh
from .command_line import (
    ON_SERVER,
    Parser,
    bar,
    connect,
    connection,
    costs,
    exactness,
    exactness_of,
    in_one_line,
    into,
    listed,
    mesh_and_sources,
    mesh_of,
    people,
    point,
    points,
    require,
    results,
    save_annotated,
    save_csv,
    save_line,
    save_sparse,
    sent,
    signed,
    stored,
    surface,
)
from .digits import number, numbers
from .encoding import milliseconds
from .errors import GeodesicError, GeodesicWarning, printable
from .lookup import reading_text, short_ids
from .service import Reading


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command; its exit status."""
    parser = _parser()
    words = list(sys.argv[1:] if arguments is None else arguments)
    flags: list[str] = []
    if words[:1] == ["serve"] and "--" in words:  # what follows is for the server
        words, flags = words[: words.index("--")], words[words.index("--") + 1 :]
    options = parser.parse_args(words, argparse.Namespace(flags=flags))
    run: Callable[[argparse.Namespace], int] = options.run
    try:
        with _warnings_for_people():
            return run(options)
    except KeyboardInterrupt:
        people.print("interrupted")
        return 130
    except BrokenPipeError:  # the reader of a pipe has gone, as head does
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except GeodesicError as error:
        return _failed(error.in_shell())
    except (OSError, ValueError, TypeError, RuntimeError, ImportError) as error:
        return _failed(str(error))


def _failed(why: str) -> int:
    """Says why; the exit status."""
    people.print(f"geodesic: {why}", style="red", markup=False, highlight=False, soft_wrap=True)
    return 1


@contextmanager
def _warnings_for_people() -> Iterator[None]:
    """The server's remarks on answers as sentences on standard error, each once."""
    told: set[str] = set()

    def show(message: Warning | str, *where: Any, **more: Any) -> None:
        text = f"geodesic: warning: {message}"
        if text not in told:
            told.add(text)
            people.print(text, style="yellow", markup=False, highlight=False, soft_wrap=True)

    with warnings.catch_warnings():
        warnings.simplefilter("always", GeodesicWarning)
        warnings.showwarning = show
        yield


def _parser() -> argparse.ArgumentParser:
    parser = Parser(
        prog="geodesic",
        usage="geodesic COMMAND ...",
        description="Geodesic distances and shortest paths on triangle meshes. "
        "'geodesic COMMAND --help' tells a command's arguments.",
    )
    parser.add_argument(
        "--version", action="version", version=f"geodesic {__version__}", help="print the version"
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND", parser_class=Parser)

    def command(name: str, usage: str, run: Callable[[argparse.Namespace], int], help: str) -> Any:
        full = f"geodesic {name} [options] {usage}".rstrip()
        made = commands.add_parser(
            name, prog=f"geodesic {name}", help=help, description=help, usage=full
        )
        made.set_defaults(run=run)
        return made

    upload = command("upload", "FILE...", _upload, "Upload mesh files and print their ids.")
    upload.add_argument(
        "file", nargs="+", type=Path, metavar="FILE", help=".glb, .gltf, .drc, .obj, .ply or .stl"
    )
    upload.add_argument("--name", help="what to call the mesh; else as the file")
    upload.add_argument("--scene", help="of a glTF file: the scene to read, by index or name")
    upload.add_argument("--node", help="of a glTF file: the node to read, by index or name")
    upload.add_argument("--weld", metavar="DISTANCE", help='join vertices so near; "off": none')
    upload.add_argument("--up", choices="xyz", metavar="AXIS", help="in the file: x, y or z")
    upload.add_argument("--scale", type=float, metavar="N", help="multiply all positions by this")
    connection(upload)

    listing = command("list", "", _list, "List the server's meshes.")
    listing.add_argument("--json", action="store_true", help="all metadata, as JSON")
    connection(listing)

    rename = command("rename", "MESH NAME", _rename, "Give a mesh another name.")
    rename.add_argument("mesh", metavar="MESH", help=f"a file, or {ON_SERVER}")
    rename.add_argument("name", metavar="NAME", help='at most 200 bytes; "" takes the name away')
    connection(rename)

    delete = command("delete", "MESH...", _delete, "Delete meshes from the server.")
    delete.add_argument("mesh", nargs="+", metavar="MESH", help=f"a file, or {ON_SERVER}")
    connection(delete)

    distance = command(
        "distance", "MESH --from POINT", _distance, "Save a distance field, or print distances."
    )
    mesh_and_sources(distance)
    distance.add_argument("--at", action="append", default=[], metavar="POINT", help="only there")
    distance.add_argument("--max", type=float, metavar="N", help="farther is unreached")
    signed(distance)
    distance.add_argument(
        "-o", "--output", type=Path, metavar="FILE", help="a .npy file, or .csv; else printed"
    )
    into(distance)
    exactness(distance)
    surface(distance)
    costs(distance)
    connection(distance)

    path = command(
        "path", "MESH --from POINT --to POINT", _path, "Find the shortest path between two points."
    )
    mesh_and_sources(path, several=False)
    path.add_argument("--to", required=True, metavar="POINT", help="where it ends")
    path.add_argument("--via", action="append", default=[], metavar="POINT", help="on the way")
    path.add_argument(
        "--refine", choices=["none", "shortest"], metavar="HOW",
        help="shortest, or none: as it was traced",
    )  # fmt: skip
    path.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FILE",
        help=".csv, .npy, .json or .glb",
    )
    exactness(path)
    surface(path)
    costs(path)
    connection(path)

    table = command("table", "MESH --from POINT", _table, "Print distances among points, as CSV.")
    mesh_and_sources(table, required=False, default=[])
    table.add_argument(
        "--to", action="append", default=[], metavar="POINT", help="a column; else the rows"
    )
    in_one_line(
        table.add_argument("--from-file", type=Path, metavar="FILE"),
        table.add_argument("--to-file", type=Path, metavar="FILE"),
        "more of them: a text, spaces or lines between",
    )
    table.add_argument("--max", type=float, metavar="N", help="farther is unreached")
    table.add_argument("--landmarks", type=int, metavar="N", help="estimate by N columns' fields")
    table.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FILE",
        help="a .npy file, or a .npz of what is within --max",
    )
    exactness(table)
    surface(table)
    costs(table)
    connection(table)

    from . import (
        extent_command,
        isolines_command,
        logmap_command,
        loop_command,
        measure_command,
        nearest_command,
        samples_command,
        trace_command,
        voronoi_command,
    )

    isolines = command(
        "isolines", "MESH --from POINT", isolines_command.run, "Draw lines of equal distance."
    )
    mesh_and_sources(isolines)
    isolines_command.arguments(isolines)
    exactness(isolines)
    surface(isolines)
    costs(isolines)
    connection(isolines)

    trace = command(
        "trace", "MESH --from POINT --length N", trace_command.run, "Go straight over the surface."
    )
    mesh_and_sources(trace, several=False, lines=False)
    trace_command.arguments(trace)
    surface(trace)
    connection(trace)

    nearest = command(
        "nearest", "MESH POINT...", nearest_command.run, "Tell where on the surface points are."
    )
    nearest.add_argument("mesh", metavar="MESH", help=f"a file, or {ON_SERVER}")
    nearest_command.arguments(nearest)
    surface(nearest)
    connection(nearest)

    samples = command(
        "samples", "MESH --count N", samples_command.run, "Spread vertices evenly over the surface."
    )
    samples.add_argument("mesh", metavar="MESH", help=f"a file, or {ON_SERVER}")
    samples_command.arguments(samples)
    exactness(samples)
    surface(samples)
    connection(samples)

    measure = command(
        "measure", "MESH --from POINT", measure_command.run, "Measure discs: areas and outlines."
    )
    mesh_and_sources(measure)
    measure_command.arguments(measure)
    exactness(measure)
    surface(measure)
    connection(measure)

    extent = command(
        "extent",
        "MESH --of MEASURE",
        extent_command.run,
        "Tell the diameter, or where the middle is.",
    )
    extent.add_argument("mesh", metavar="MESH", help=f"a file, or {ON_SERVER}")
    extent_command.arguments(extent)
    exactness(extent)
    surface(extent)
    connection(extent)

    voronoi = command(
        "voronoi", "MESH --from POINT", voronoi_command.run, "Divide the surface among sites."
    )
    mesh_and_sources(voronoi)
    voronoi_command.arguments(voronoi)
    exactness(voronoi)
    surface(voronoi)
    connection(voronoi)

    loop = command(
        "loop",
        "MESH --through POINT --through POINT",
        loop_command.run,
        "Lay a loop or a tape round a surface.",
    )
    loop.add_argument("mesh", metavar="MESH", help=f"a file, or {ON_SERVER}")
    loop_command.arguments(loop)
    exactness(loop)
    surface(loop)
    connection(loop)

    logmap = command(
        "logmap", "MESH --from POINT", logmap_command.run, "Lay the surface round a point flat."
    )
    mesh_and_sources(logmap, several=False, lines=False)
    logmap_command.arguments(logmap)
    exactness(logmap)
    surface(logmap)
    connection(logmap)

    plot = command("plot", "MESH --from POINT", _plot, "Draw a field with isolines and a path.")
    mesh_and_sources(plot)
    plot.add_argument("--to", metavar="POINT", help="draw the path there from the first source")
    plot.add_argument("--via", action="append", default=[], metavar="POINT", help="on the way")
    plot.add_argument(
        "-o", "--output", type=Path, metavar="FILE", help="a .png, .svg or .pdf; else on screen"
    )
    plot.add_argument("--isolines", type=int, default=12, metavar="N", help="0: none")
    plot.add_argument("--view", help="front, back, left, right, top, bottom, corner, AZ,EL")
    plot.add_argument("--up", choices=["y", "z"], metavar="AXIS", help="y or z, for slopes, too")
    plot.add_argument("--colormap", metavar="NAME", help="one of matplotlib's")
    signed(plot)
    exactness(plot, points_per_edge=False)
    surface(plot)
    costs(plot, up=False)
    connection(plot)

    from . import map_command

    map_command.arguments(
        command("map", "QUESTION", map_command.run, "Ask many meshes the same, or for a matrix.")
    )

    from .bench import command as bench

    bench.arguments(command("bench", "[URL]", bench.run, "Load a server and measure it."))

    from . import serve_command

    serve_command.arguments(
        command(
            "serve",
            "[FILE...] [-- FLAG...]",
            serve_command.run,
            "Run a server on this machine until Ctrl-C.",
        )
    )
    return parser


def _upload(options: argparse.Namespace) -> int:
    asked = {name: getattr(options, name) for name in Reading.__annotations__}
    reading = cast(Reading, {name: value for name, value in asked.items() if value is not None})
    if options.name is not None and len(options.file) > 1:
        raise ValueError("--name is for one file")
    with connect(options) as client:
        for file in options.file:
            mesh = sent(client, file, options.name, **reading)
            for warning in mesh.warnings:
                people.print(printable(f"{file}: {warning}"), style="yellow", markup=False)
            if options.name and mesh.name != options.name:
                people.print(
                    f"{file}: the server has it already, with the name {mesh.name!r}: "
                    "'geodesic rename' gives it another", style="yellow", markup=False,
                )  # fmt: skip
            results.print(mesh.id)
    return 0


def _list(options: argparse.Namespace) -> int:
    with connect(options) as client:
        meshes = client.meshes()
        if options.json:
            found = [client.fetch("GET", f"/v1/meshes/{mesh.id}").json() for mesh in meshes]
            print(json.dumps(found, indent=2))
            return 0
    if results.is_terminal:
        results.print(_shown(meshes))
        return 0
    for mesh in meshes:
        sizes = (mesh.vertices, mesh.faces, mesh.format, mesh.bytes)
        print(mesh.id, mesh.name or "", *sizes, reading_text(mesh.reading), sep="\t")
    return 0


def _shown(meshes: Sequence[Mesh]) -> Table:
    """The list for a terminal. Ids are as short as tells them apart, and as other commands take
    them."""
    short = short_ids(mesh.id for mesh in meshes)
    table = Table(box=None, pad_edge=False)
    columns = ["id", "name", "vertices", "faces", "format", "bytes"]
    if any(mesh.reading for mesh in meshes):  # two readings of one file have one name
        columns.append("read with")
    for column in columns:
        wide = column in ("name", "read with")
        numbers = column in ("vertices", "faces", "bytes")
        table.add_column(
            column,
            justify="right" if numbers else "left",
            no_wrap=not wide,
            overflow="fold",
            min_width=None if wide else len(column),
        )
    for mesh in meshes:
        sizes = (f"{mesh.vertices:,}", f"{mesh.faces:,}", mesh.format, f"{mesh.bytes:,}")
        read = (reading_text(mesh.reading),) if len(columns) == 7 else ()
        cells = (short[mesh.id], printable(mesh.name or ""), *sizes, *read)
        table.add_row(*(Text(cell) for cell in cells))
    return table


def _rename(options: argparse.Namespace) -> int:
    with connect(options) as client:
        mesh = client.mesh(stored(client, options.mesh)).rename(options.name)
    results.print(mesh.id)
    return 0


def _delete(options: argparse.Namespace) -> int:
    with connect(options) as client:
        for whole in [stored(client, name) for name in options.mesh]:
            client.fetch("DELETE", f"/v1/meshes/{whole}")
            results.print(whole)
    return 0


def _distance(options: argparse.Namespace) -> int:
    with mesh_of(options) as mesh, bar("distances") as progress:
        asked: dict[str, Any] = {"max": options.max, "progress": progress, **exactness_of(options)}
        sources = points(options.sources)
        if options.into is not None:
            if options.at or options.output is not None:
                raise ValueError("--into has the whole field, and is a file of its own")
            asked = {"max": options.max, **exactness_of(options), "from": sources}
            if options.signed:
                asked["signed"] = True
            asked["deadline_ms"] = milliseconds(asked.pop("deadline"))
            return save_annotated(options, mesh, "distance", asked, progress)
        asked["signed"] = options.signed
        if options.at:
            field = mesh.distance_at(sources, points(options.at), **asked)
        else:
            field = mesh.distance(sources, **asked)
    if options.output is None:
        print("\n".join(numbers(field)))
        return 0
    if options.output.suffix == ".csv":
        save_csv(options.output, "index,distance", map(str, range(len(field))), numbers(field))
    else:
        require(options.output, (".npy",))
        np.save(options.output, field)
    reached = field[np.isfinite(field)]
    farthest = f", the farthest {reached.max():.6g}" if len(reached) else ""
    people.print(f"{options.output}: {len(reached):,} of {len(field):,} reached{farthest}")
    return 0


def _path(options: argparse.Namespace) -> int:
    endings = (".csv", ".npy", ".json", ".glb")
    if options.output is not None:
        require(options.output, endings)
    source, target, via = point(options.sources), point(options.to), points(options.via)
    asked: dict[str, Any] = {"refine": options.refine, **exactness_of(options)}
    with mesh_of(options) as mesh, bar("path") as progress:
        path = mesh.path(source, target, via=via, progress=progress, **asked)
        if options.output is not None and options.output.suffix == ".glb":
            asked.pop("deadline")
            asked |= {"from": source, "to": target, "via": via}
            options.output.write_bytes(mesh.query("path", asked, format="glb").data)
    if not path.reachable:
        people.print("geodesic: there is no path", style="red")
        return 1
    print(number(path.length if path.cost is None else path.cost))
    if options.output is not None:
        save_line(options.output, path)
    return 0


def _print_errors(found: dict[str, float]) -> None:
    people.print(
        f"estimated by {found['landmarks']} landmarks: {100 * found['mean']:.2g} % off on average,"
        f" 99 of 100 at most {100 * found['percentile_99']:.2g} %"
    )


def _table(options: argparse.Namespace) -> int:
    sources = listed(options.sources, options.from_file)
    if not sources:
        raise ValueError("give --from POINT or --from-file FILE, which has points")
    targets = listed(options.to, options.to_file) or sources
    with mesh_of(options) as mesh, bar("table") as progress:
        asked: dict[str, Any] = {"max": options.max, "progress": progress, **exactness_of(options)}
        if options.landmarks is not None and getattr(options.output, "suffix", "") != ".npy":
            raise ValueError("with --landmarks a table goes to a .npy file: name one with -o")
        if options.output is not None:
            require(options.output, (".npy", ".npz"))
            if options.output.suffix == ".npy":
                asked |= {"landmarks": options.landmarks, "estimated": _print_errors}
                mesh.table_file(options.output, points(sources), points(targets), **asked)
            else:
                sparse = mesh.sparse_table(points(sources), points(targets), **asked)
                save_sparse(options.output, sparse)
            return 0
        table = mesh.table(points(sources), points(targets), **asked)
    quoted = [f'"{name}"' if "," in name else name for name in targets]
    print(",".join(["", *quoted]))
    for name, row in zip(sources, table, strict=True):
        first = f'"{name}"' if "," in name else name
        print(",".join([first, *numbers(row)]))
    return 0


def _plot(options: argparse.Namespace) -> int:
    from .plot import plot

    view: Any = options.view
    if view is not None and "," in view:
        azimuth, _, elevation = view.partition(",")
        view = (float(azimuth), float(elevation))
    with mesh_of(options) as mesh, bar("distances") as progress:
        title = Path(options.mesh).name if Path(options.mesh).is_file() else None
        figure = plot(
            mesh,
            points(options.sources),
            target=None if options.to is None else point(options.to),
            via=points(options.via),
            isolines=options.isolines,
            view=view,
            up=options.up or "y",
            colormap=options.colormap,
            title=title,
            signed=options.signed,
            progress=progress,
            **exactness_of(options),
        )
    if options.output is not None:
        figure.savefig(options.output)
        people.print(f"{options.output}")
        return 0
    from .plot import show

    show(figure)
    return 0


if __name__ == "__main__":
    sys.exit(main())
