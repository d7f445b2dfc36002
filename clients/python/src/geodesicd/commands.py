"""The command ``geodesic``: what the client does, from a shell. ``geodesic COMMAND --help``
tells each one's arguments. Exit status: 0 done, 1 refused or failed, 2 asked wrongly, 130
interrupted."""

from __future__ import annotations

import argparse
import json
import os
import re
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Any, Unpack, cast

import numpy as np
from rich.console import Console
from rich.table import Table

from . import __version__
from .client import Client, Mesh
from .errors import GeodesicError
from .local_server import serve
from .progress import progress_bar
from .results import Float64
from .service import Reading

# Results go to standard output, for pipes; everything else is for people.
people = Console(stderr=True)
results = Console(highlight=False, soft_wrap=True)


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command; its exit status."""
    parser = _parser()
    options = parser.parse_args(arguments)
    run: Callable[[argparse.Namespace], int] = options.run
    try:
        return run(options)
    except KeyboardInterrupt:
        people.print("interrupted")
        return 130
    except BrokenPipeError:  # the reader of a pipe has gone, as head does
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except (GeodesicError, OSError, ValueError, TypeError, RuntimeError, ImportError) as error:
        people.print(
            f"geodesic: {error}", style="red", markup=False, highlight=False, soft_wrap=True
        )
        return 1


class _Layout(argparse.HelpFormatter):
    """A line for each argument: so all fit into a screen of 24 lines of 80 letters."""

    def __init__(self, prog: str) -> None:
        super().__init__(prog, max_help_position=23, width=80)

    def _format_action_invocation(self, action: argparse.Action) -> str:
        if not action.option_strings or action.nargs == 0:
            return super()._format_action_invocation(action)
        name = action.metavar or action.dest.upper()
        return f"{', '.join(action.option_strings)} {name}"


class _Parser(argparse.ArgumentParser):
    """One whose help has one list, of what has to be given first."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options, formatter_class=_Layout, add_help=False)
        self.add_argument("-h", "--help", action="help", help=argparse.SUPPRESS)

    def format_help(self) -> str:
        layout = self._get_formatter()
        layout.add_usage(self.usage, [], [])
        layout.add_text(self.description)
        layout.start_section(None)
        for action in sorted(self._actions, key=lambda one: bool(one.option_strings)):
            if isinstance(action, argparse._SubParsersAction):
                layout.add_arguments(action._choices_actions)
            else:
                layout.add_argument(action)
        layout.end_section()
        return layout.format_help()


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="geodesic",
        usage="geodesic COMMAND ...",
        description="Geodesic distances and shortest paths on triangle meshes. "
        "'geodesic COMMAND --help' tells a command's arguments.",
    )
    parser.add_argument(
        "--version", action="version", version=f"geodesic {__version__}", help="print the version"
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND", parser_class=_Parser)

    def command(name: str, usage: str, run: Callable[[argparse.Namespace], int], help: str) -> Any:
        full = f"geodesic {name} [options] {usage}".rstrip()
        made = commands.add_parser(name, help=help, description=help, usage=full)
        made.set_defaults(run=run)
        return made

    upload = command("upload", "FILE...", _upload, "Upload mesh files and print their ids.")
    upload.add_argument(
        "file", nargs="+", type=Path, metavar="FILE", help=".glb, .gltf, .drc, .obj, .ply or .stl"
    )
    upload.add_argument("--scene", help="of a glTF file: the scene to read, by index or name")
    upload.add_argument("--node", help="of a glTF file: the node to read, by index or name")
    upload.add_argument("--weld", metavar="DISTANCE", help='join vertices so near; "off": none')
    upload.add_argument("--up", choices="xyz", metavar="AXIS", help="in the file: x, y or z")
    upload.add_argument("--scale", type=float, metavar="N", help="multiply all positions by this")
    _connection(upload)

    listing = command("list", "", _list, "List the server's meshes.")
    listing.add_argument("--json", action="store_true", help="all metadata, as JSON")
    _connection(listing)

    delete = command("delete", "MESH...", _delete, "Delete meshes from the server.")
    delete.add_argument("mesh", nargs="+", metavar="MESH", help="an id, or how it begins")
    _connection(delete)

    distance = command(
        "distance", "MESH --from POINT", _distance, "Save a distance field, or print distances."
    )
    _query(distance)
    distance.add_argument("--at", action="append", default=[], metavar="POINT", help="only there")
    distance.add_argument("--max", type=float, metavar="N", help="farther is unreached")
    distance.add_argument(
        "-o", "--output", type=Path, metavar="FILE", help="a .npy file, or .csv; else printed"
    )
    _exactness(distance)
    _connection(distance)

    path = command(
        "path", "MESH --from POINT --to POINT", _path, "Find the shortest path between two points."
    )
    _query(path, several=False)
    path.add_argument("--to", required=True, metavar="POINT", help="where it ends")
    path.add_argument("--via", action="append", default=[], metavar="POINT", help="on the way")
    path.add_argument(
        "--refine", choices=["none", "shortest"], default="shortest", metavar="HOW",
        help="shortest, or none: as it was traced",
    )  # fmt: skip
    path.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FILE",
        help=".csv, .npy, .json or .glb",
    )
    _exactness(path)
    _connection(path)

    table = command("table", "MESH --from POINT", _table, "Print distances among points, as CSV.")
    _query(table)
    table.add_argument("--to", action="append", metavar="POINT", help="a column; else the rows")
    table.add_argument("--max", type=float, metavar="N", help="farther is unreached")
    _exactness(table)
    _connection(table)

    plot = command("plot", "MESH --from POINT", _plot, "Draw a field with isolines and a path.")
    _query(plot)
    plot.add_argument("--to", metavar="POINT", help="draw the path there from the first source")
    plot.add_argument("--via", action="append", default=[], metavar="POINT", help="on the way")
    plot.add_argument(
        "-o", "--output", type=Path, metavar="FILE", help="a .png, .svg or .pdf; else on screen"
    )
    plot.add_argument("--isolines", type=int, default=12, metavar="N", help="0: none")
    plot.add_argument("--view", help="front, back, left, right, top, bottom, corner, AZ,EL")
    plot.add_argument("--up", choices=["y", "z"], default="y", metavar="AXIS", help="y or z")
    plot.add_argument("--colormap", default="viridis", metavar="NAME", help="one of matplotlib's")
    _exactness(plot, points_per_edge=False)
    _connection(plot)

    from .bench import command as bench

    bench.arguments(command("bench", "[URL]", bench.run, "Load a server and measure it."))

    server = command("serve", "[FILE...]", _serve, "Run a server on this machine until Ctrl-C.")
    server.add_argument(
        "file", nargs="*", type=Path, metavar="FILE", help="meshes to upload at the start"
    )
    server.add_argument("--server", metavar="FILE", help="its program; else $GEODESICD_BINARY")
    server.add_argument(
        "--listen", default="127.0.0.1:8080", metavar="ADDRESS", help="HOST:PORT (%(default)s)"
    )
    server.add_argument("--store", type=Path, metavar="FOLDER", help="keep meshes there")
    return parser


def _connection(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--url", help="the server; else $GEODESICD_URL, or 127.0.0.1:8080")
    parser.add_argument("--token", help="else $GEODESICD_TOKEN")


def _query(parser: argparse.ArgumentParser, several: bool = True) -> None:
    parser.add_argument(
        "mesh", metavar="MESH", help="a file, uploaded if need be, or an id or how it begins"
    )
    parser.add_argument(
        "--from",
        dest="sources",
        action="append" if several else "store",
        required=True,
        metavar="POINT",
        help="12, p:X,Y,Z, f:FACE,W0,W1 or ray:X,Y,Z,DX,DY,DZ" + (", …" if several else ""),
    )


def _exactness(parser: argparse.ArgumentParser, points_per_edge: bool = True) -> None:
    """How distances are computed: alike for all queries."""
    parser.add_argument(
        "--method", metavar="NAME", help="auto, exact, …; else the server's default"
    )
    parser.add_argument(
        "--tolerance",
        type=float,
        metavar="T",
        help="auto: largest relative error",
    )
    parser.add_argument("--bound", metavar="WHICH", help="auto: upper, never below the truth")
    if points_per_edge:
        parser.add_argument("--points-per-edge", type=int, metavar="N", help="of steiner")
        parser.add_argument("--deadline", type=float, metavar="SECONDS", help="give up then")


def _asked(options: argparse.Namespace) -> dict[str, Any]:
    """What :func:`_exactness` added, as the queries take it."""
    names = ("method", "tolerance", "bound", "points_per_edge", "deadline")
    return {name: getattr(options, name) for name in names if hasattr(options, name)}


def connect(options: argparse.Namespace) -> Client:
    """A client as the options say."""
    return Client(options.url, token=options.token or os.environ.get("GEODESICD_TOKEN"))


def bar(what: str) -> AbstractContextManager[Callable[[float], None]]:
    """A progress bar, on a terminal only; a function that moves it, from 0 to 1."""
    return progress_bar(what, people)


def _mesh(client: Client, name: str, **reading: Unpack[Reading]) -> Mesh:
    """A mesh by its id, or a file's."""
    if re.fullmatch(r"[0-9a-f]{8,64}(~[0-9a-f]{0,32})?", name) and not Path(name).exists():
        return client.mesh(_whole_id(client, name))
    with bar(f"uploading {Path(name).name}") as progress:
        return client.upload(Path(name), progress=progress, **reading)


def _whole_id(client: Client, name: str) -> str:
    """The id that begins so.

    Raises:
        ValueError: none or several do.
    """
    if re.fullmatch(r"[0-9a-f]{64}(~([0-9a-f]{32}|[0-9a-f]{12}))?", name):
        return name
    found = [mesh.id for mesh in client.meshes() if mesh.id.startswith(name)]
    if plain := [one for one in found if "~" not in one]:  # and the same file read in other ways
        found = plain
    if len(found) != 1:
        raise ValueError(f"{len(found)} meshes have an id that begins with {name}; see 'list'")
    return found[0]


@contextmanager
def mesh_of(options: argparse.Namespace) -> Iterator[Mesh]:
    """The mesh that the options name, on a connection that is closed at the end."""
    with connect(options) as client:
        yield _mesh(client, options.mesh)


def point(text: str) -> int | str:
    """A point as it is written on a command line: a number is a vertex."""
    return int(text) if text.isdigit() else text


def _points(texts: Sequence[str]) -> list[Any]:
    return [point(text) for text in texts]


def _upload(options: argparse.Namespace) -> int:
    asked = {name: getattr(options, name) for name in Reading.__annotations__}
    reading = cast(Reading, {name: value for name, value in asked.items() if value is not None})
    with connect(options) as client:
        for file in options.file:
            mesh = _mesh(client, str(file), **reading)
            for warning in mesh.warnings:
                people.print(f"{file}: {warning}", style="yellow", markup=False)
            results.print(mesh.id)
    return 0


def _list(options: argparse.Namespace) -> int:
    with connect(options) as client:
        meshes = client.meshes()
        if options.json:
            found = [client.fetch("GET", f"/v1/meshes/{mesh.id}").json() for mesh in meshes]
            print(json.dumps(found, indent=2))
            return 0
    table = Table(box=None, pad_edge=False)
    for column in ("id", "name", "vertices", "faces", "format", "bytes"):
        numbers = column in ("vertices", "faces", "bytes")
        table.add_column(column, justify="right" if numbers else "left", no_wrap=True)
    for mesh in meshes:
        name = next((part.name for part in mesh.parts if part.name), "")
        row = (mesh.id, name, mesh.vertices, mesh.faces, mesh.format, mesh.bytes)
        if results.is_terminal:
            table.add_row(
                mesh.id[:16], name, *(f"{v:,}" if isinstance(v, int) else v for v in row[2:])
            )
        else:
            print(*row, sep="\t")
    if results.is_terminal:
        results.print(table)
    return 0


def _delete(options: argparse.Namespace) -> int:
    with connect(options) as client:
        for whole in [_whole_id(client, name) for name in options.mesh]:
            client.fetch("DELETE", f"/v1/meshes/{whole}")
            results.print(whole)
    return 0


def _distance(options: argparse.Namespace) -> int:
    with mesh_of(options) as mesh, bar("distances") as progress:
        asked: dict[str, Any] = {"max": options.max, "progress": progress, **_asked(options)}
        sources = _points(options.sources)
        if options.at:
            field = mesh.distance_at(sources, _points(options.at), **asked)
        else:
            field = mesh.distance(sources, **asked)
    if options.output is None:
        print("\n".join(_number(value) for value in field))
        return 0
    if options.output.suffix == ".csv":
        numbered = np.column_stack([np.arange(len(field)), field])
        np.savetxt(
            options.output, numbered, ["%d", "%.17g"], ",", header="index,distance", comments=""
        )
    else:
        _require(options.output, (".npy",))
        np.save(options.output, field)
    reached = field[np.isfinite(field)]
    farthest = f", the farthest {reached.max():.6g}" if len(reached) else ""
    people.print(f"{options.output}: {len(reached):,} of {len(field):,} reached{farthest}")
    return 0


def _number(value: float) -> str:
    """As few digits as read back to the same number."""
    return np.format_float_positional(value, trim="-")


def _save_csv(file: Path, rows: Float64, header: str, kinds: list[str]) -> None:
    np.savetxt(file, rows, kinds, ",", header=header, comments="")


def _require(file: Path, endings: tuple[str, ...]) -> None:
    if file.suffix not in endings:
        raise ValueError(f"{file} should end with {' or '.join(endings)}")


def _path(options: argparse.Namespace) -> int:
    endings = (".csv", ".npy", ".json", ".glb")
    if options.output is not None:
        _require(options.output, endings)
    source, target, via = point(options.sources), point(options.to), _points(options.via)
    asked: dict[str, Any] = {"refine": options.refine, **_asked(options)}
    with mesh_of(options) as mesh, bar("path") as progress:
        path = mesh.path(source, target, via=via, progress=progress, **asked)
        if options.output is not None and options.output.suffix == ".glb":
            asked.pop("deadline")
            asked |= {"from": source, "to": target, "via": via}
            options.output.write_bytes(mesh.query("path", asked, format="glb").data)
    if not path.reachable:
        people.print("geodesic: there is no path", style="red")
        return 1
    print(_number(path.length))
    if options.output is not None:
        _save_path(options.output, path)
    return 0


def _save_path(file: Path, path: Any) -> None:
    if file.suffix == ".csv":
        rows = np.column_stack([path.points, path.faces, path.along])
        _save_csv(file, rows, "x,y,z,face,along", ["%.17g"] * 3 + ["%d", "%.17g"])
    elif file.suffix == ".npy":
        np.save(file, path.points)
    elif file.suffix == ".json":
        document = {
            "length": path.length,
            "points": path.points.tolist(),
            "faces": path.faces.tolist(),
            "bary": [None if np.isnan(b).any() else b.tolist() for b in path.bary],
        }
        file.write_text(json.dumps(document) + "\n", encoding="utf-8")


def _table(options: argparse.Namespace) -> int:
    with mesh_of(options) as mesh, bar("table") as progress:
        sources, targets = options.sources, options.to or options.sources
        asked: dict[str, Any] = {"max": options.max, "progress": progress, **_asked(options)}
        table = mesh.table(_points(sources), _points(targets), **asked)
    quoted = [f'"{name}"' if "," in name else name for name in targets]
    print(",".join(["", *quoted]))
    for name, row in zip(sources, table, strict=True):
        first = f'"{name}"' if "," in name else name
        print(",".join([first, *(_number(value) for value in row)]))
    return 0


def _plot(options: argparse.Namespace) -> int:
    from .plot import plot

    view: Any = options.view
    if view is not None and "," in view:
        azimuth, _, elevation = view.partition(",")
        view = (float(azimuth), float(elevation))
    with mesh_of(options) as mesh, bar("distances") as progress:
        title = None if re.fullmatch("[0-9a-f]{64}", options.mesh) else Path(options.mesh).name
        figure = plot(
            mesh,
            _points(options.sources),
            target=None if options.to is None else point(options.to),
            via=_points(options.via),
            isolines=options.isolines,
            view=view,
            up=options.up,
            colormap=options.colormap,
            title=title,
            progress=progress,
            **_asked(options),
        )
    if options.output is not None:
        figure.savefig(options.output)
        people.print(f"{options.output}")
        return 0
    from .plot import show

    show(figure)
    return 0


def _serve(options: argparse.Namespace) -> int:
    server = serve(options.server, store=options.store, listen=options.listen)

    def interrupt(number: int, frame: Any) -> None:
        raise KeyboardInterrupt

    # Whoever stops this process wants the server to stop with it.
    signal.signal(signal.SIGTERM, interrupt)
    signal.signal(signal.SIGINT, interrupt)
    try:
        url = server.start()
        with Client(url) as client:
            for file in options.file:
                mesh = _mesh(client, str(file))
                print(f"{mesh.id}  {file}", file=sys.stderr)
        print(f"listening on {url}", flush=True)
        return server.wait()
    finally:
        server.stop()


if __name__ == "__main__":
    sys.exit(main())
