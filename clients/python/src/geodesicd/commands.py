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

from rich.table import Table
from rich.text import Text

from . import __version__, hints, query_commands
from .client import Mesh
from .command_line import (
    ON_SERVER,
    Parser,
    connect,
    connection,
    people,
    results,
    sent,
    stored,
    the_mesh,
)
from .errors import GeodesicError, GeodesicWarning, Misuse, printable
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
    except Misuse as error:
        _failed(str(error))
        return 2
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
        text = f"geodesic: warning: {hints.remark_in_shell(str(message))}"
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
        usage="geodesic COMMAND ... | --version",
        description="Geodesic distances and paths on triangle meshes. "
        "More: geodesic COMMAND --help",
    )
    version = f"geodesic {__version__}"
    parser.add_argument("--version", action="version", version=version, help=argparse.SUPPRESS)
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
    the_mesh(rename)
    rename.add_argument("name", metavar="NAME", help='at most 200 bytes; "" takes the name away')
    connection(rename)

    delete = command("delete", "MESH...", _delete, "Delete meshes from the server.")
    delete.add_argument("mesh", nargs="+", metavar="MESH", help=f"a file, or {ON_SERVER}")
    connection(delete)

    query_commands.add(command)

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
        raise Misuse("--name is for one file")
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


if __name__ == "__main__":
    sys.exit(main())
