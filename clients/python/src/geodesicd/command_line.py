"""What the commands of ``geodesic`` share: how their arguments are told, how points, meshes and
files are named by them."""

from __future__ import annotations

import argparse
import hashlib
import os
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Any, Unpack

import numpy as np
from rich.console import Console

from .client import Client, Mesh
from .costs import Costs
from .errors import Misuse, NotFound, printable
from .outputs import require, save_bytes
from .progress import progress_bar
from .service import Reading

# Results go to standard output, for pipes; everything else is for people.
people = Console(stderr=True)
results = Console(highlight=False, soft_wrap=True)


ON_SERVER = "a mesh's name, its id, or how that begins"


class _Layout(argparse.HelpFormatter):
    """A line for each argument: so all fit into a screen of 24 lines of 80 letters."""

    def __init__(self, prog: str) -> None:
        super().__init__(prog, max_help_position=24, width=80)

    def _format_action_invocation(self, action: argparse.Action) -> str:
        if not action.option_strings or action.nargs == 0:
            return super()._format_action_invocation(action)
        name = action.metavar or action.dest.upper()
        return f"{', '.join(action.option_strings)} {name}"


class Parser(argparse.ArgumentParser):
    """One whose help has one list, of what has to be given first. An argument may have a second
    line there, an action of its own that is its ``also``."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options, formatter_class=_Layout, add_help=False)
        self.add_argument("-h", "--help", action="help", help=argparse.SUPPRESS)
        # What begins with a negative number is a value, as in `--slope -1:3,1:4`: no option does.
        self._negative_number_matcher = re.compile(r"-\.?\d")

    def format_help(self) -> str:
        """As argparse calls it."""
        layout = self._get_formatter()
        layout.add_usage(self.usage, [], [])
        layout.add_text(self.description)
        layout.start_section(None)
        for action in sorted(self._actions, key=lambda one: bool(one.option_strings)):
            if isinstance(action, argparse._SubParsersAction):
                layout.add_arguments(action._choices_actions)
            else:
                layout.add_arguments([action, *getattr(action, "also", ())])
        layout.end_section()
        return layout.format_help().replace("\n\n", "\n", 1)  # none between usage and what it does


def in_one_line(first: Any, second: Any, help: str) -> None:
    """One line of the help for two arguments that belong together."""
    names = [action.option_strings[0] for action in (first, second)]
    first.help = second.help = argparse.SUPPRESS
    first.also = [argparse.Action(names, first.dest, nargs=0, help=help)]


def connection(parser: argparse.ArgumentParser) -> None:
    """Which server, and who asks."""
    in_one_line(
        parser.add_argument("--url"),
        parser.add_argument("--token"),
        "else $GEODESICD_URL or 127.0.0.1:8080; $GEODESICD_TOKEN",
    )


def sources(parser: argparse.ArgumentParser, *, lines: bool = True, **more: Any) -> None:
    """What distances are from: points and, unless that is said otherwise, lines and faces."""
    action: Any = parser.add_argument(
        "--from",
        dest="sources",
        metavar="POINT",
        help="12, p:X,Y,Z, f:FACE,W0,W1 or ray:X,Y,Z,DX,DY,DZ",
        **more,
    )
    if lines:
        told = "curve:POINT;POINT…, boundary, faces:0-9, label:_A=3, …"
        action.also = [argparse.Action(["--from"], "sources", metavar="LINE", help=told)]


def the_mesh(parser: argparse.ArgumentParser) -> None:
    """What all queries are about."""
    parser.add_argument("mesh", metavar="MESH", help=f"a file, or {ON_SERVER}")


def mesh_and_sources(
    parser: argparse.ArgumentParser, several: bool = True, lines: bool = True, **more: Any
) -> None:
    """What most queries are about."""
    the_mesh(parser)
    needed = {"required": True, "action": "append" if several else Once}
    sources(parser, lines=lines, **(needed | more))


def exactness(parser: argparse.ArgumentParser, steiner: bool = True) -> None:
    """How distances are computed: alike for all queries. Without ``steiner``, what is for that
    method alone is left out."""
    parser.add_argument(
        "--method", metavar="NAME", help="auto, exact, …; else the server's default"
    )
    in_one_line(
        parser.add_argument("--tolerance", type=float, metavar="T"),
        parser.add_argument("--bound", metavar="WHICH"),
        "auto: largest relative error; upper: never too short",
    )
    if steiner:
        parser.add_argument("--points-per-edge", type=int, metavar="N", help="of steiner")
    parser.add_argument("--deadline", type=float, metavar="SECONDS", help="give up then")


def signed(parser: argparse.ArgumentParser) -> None:
    """Distances with a sign."""
    parser.add_argument("--signed", action="store_true", help="below 0 inside one closed curve")


def surface(parser: argparse.ArgumentParser) -> None:
    """The part of the surface that a query is about: alike for all queries."""
    in_one_line(
        parser.add_argument("--within", action="append", metavar="REGION"),
        parser.add_argument("--forbid", action="append", metavar="REGION"),
        "keep to, or leave out, faces:0-99, sphere:X,Y,Z,R, box:…",
    )
    parser.add_argument(
        "--walls", action="append", metavar="LINE", help="POINT;POINT…, which no path crosses"
    )


def costs(parser: argparse.ArgumentParser, up: bool = True) -> None:
    """What ways cost instead of their length. Without ``up``, a command has an ``--up`` of its own,
    which is an axis."""
    parser.add_argument(
        "--weight",
        action="append",
        default=[],
        metavar="N*REGION",
        help="cost of length there, or _NAME of the file's",
    )
    parser.add_argument(
        "--face-weights",
        type=Path,
        metavar="FILE",
        help="one for each face: a .npy file, or numbers as text",
    )
    in_one_line(
        parser.add_argument("--slope", metavar="HOW"),
        parser.add_argument("--steepest", type=float, metavar="SLOPE"),
        "tobler, energy or -1:3,0:1,1:4; steeper is not walked",
    )
    if up:
        parser.add_argument(
            "--up", metavar="X,Y,Z", help="where up is, for slopes; or x, y, z; else y"
        )


def _costs_of(options: argparse.Namespace) -> Costs | None:
    """What :func:`costs` added; None where nothing of it is given."""
    weights = []
    attribute = None
    for text in options.weight:
        weight, star, region = text.partition("*")
        if star and _is_number(weight):
            weights.append((float(weight), region))
        elif text.startswith("_") and attribute in (None, text):
            attribute = text
        else:
            raise Misuse(
                f"--weight {text}: it is NUMBER*REGION, such as 3*faces:0-99, or one attribute of "
                "the file's vertices, such as _MUD"
            )
    file: Path | None = options.face_weights
    # Where up is an axis of the picture, too, it may be given without a slope.
    has_slope = options.slope is not None or options.steepest is not None
    up = options.up if has_slope or not hasattr(options, "view") else None
    found = Costs(
        weights,
        None if file is None else _numbers_in(file),
        options.slope,
        options.steepest,
        None if up is None else _up(up),
        attribute,
    )
    return None if found == Costs([]) else found


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _numbers_in(file: Path) -> list[float]:
    """The numbers of a file: a ``.npy`` array, or a text with spaces, commas or lines between."""
    if file.suffix == ".npy":
        try:
            found = np.load(file, allow_pickle=False)
        except EOFError:
            raise ValueError(f"{file} is empty") from None
        if not isinstance(found, np.ndarray):
            raise ValueError(f"{file} is an archive, and not one array")
        if found.ndim != 1 or found.dtype.kind not in "fiu":
            told = f"{found.dtype} with the shape {found.shape}"
            raise ValueError(f"{file} has {told}, and not one number for each face")
    else:
        words = words_of(file, ",")
        try:
            found = np.array(words, dtype=np.float64)
        except ValueError as error:
            raise ValueError(f"{file} should have numbers alone: {error}") from None
    if not np.isfinite(found).all():
        raise ValueError(f"{file} has numbers that are not finite")
    return list(map(float, found))


_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


def _up(text: str) -> tuple[float, float, float]:
    return _AXES[text] if text in _AXES else vector(text, "--up")


def vector(text: str, name: str) -> tuple[float, float, float]:
    """A direction as it is written on a command line.

    Raises:
        Misuse: it is none of three numbers; the message says what the argument ``name`` is.
    """
    try:
        x, y, z = map(float, text.split(","))
    except ValueError:
        raise Misuse(f"{name} is three numbers, such as 0,0,1, and not {text}") from None
    return x, y, z


def exactness_of(options: argparse.Namespace) -> dict[str, Any]:
    """What :func:`exactness`, :func:`surface` and :func:`costs` added, as the queries take it."""
    names = ("method", "tolerance", "bound", "points_per_edge", "deadline")
    found = {name: getattr(options, name) for name in names if hasattr(options, name)}
    found |= surface_of(options)
    if hasattr(options, "weight"):
        found["costs"] = _costs_of(options)
    return found


def surface_of(options: argparse.Namespace) -> dict[str, Any]:
    """What :func:`surface` added, as the queries take it."""
    kept = ("within", "forbid", "walls")
    return {name: getattr(options, name) for name in kept if hasattr(options, name)}


def into(parser: argparse.ArgumentParser) -> None:
    """How to have the mesh's own file with the answer in it."""
    parser.add_argument(
        "--into",
        type=Path,
        metavar="FILE",
        help="its own .glb or .gltf with it",
    )
    parser.add_argument("--attribute", metavar="_NAME", help="of the vertices, in that file")


def require_into(options: argparse.Namespace) -> None:
    """Misuse: of what :func:`into` added, there is a name of the attribute and no file for it."""
    if options.attribute is not None and options.into is None:
        raise Misuse("--attribute is for --into")


def save_annotated(
    options: argparse.Namespace, mesh: Mesh, query: str, asked: dict[str, Any], progress: Any
) -> int:
    """Writes the file that :func:`into` asks for; ``asked`` is in the contract's words."""
    file: Path = options.into
    require(file, (".glb", ".gltf"))
    if file.suffix != f".{mesh.format}" and mesh.format in ("glb", "gltf"):
        raise Misuse(f"{file} should end with .{mesh.format}, as the mesh's own file")
    parameters = {**asked, "attribute": options.attribute}
    answer = mesh.query(query, parameters, format="annotated", progress=progress)
    save_bytes(file, answer.data)
    people.print(str(file), markup=False, soft_wrap=True)
    return 0


def connect(options: argparse.Namespace) -> Client:
    """A client as the options say."""
    return Client(options.url, token=options.token or os.environ.get("GEODESICD_TOKEN"))


def bar(what: str) -> AbstractContextManager[Callable[[float], None]]:
    """A progress bar, on a terminal only; a function that moves it, from 0 to 1."""
    return progress_bar(what, people)


def sent(client: Client, file: Path, name: str | None = None, **reading: Unpack[Reading]) -> Mesh:
    """A file's mesh."""
    with bar(f"uploading {printable(file.name)}") as progress:
        return client.upload(file, name=name, progress=progress, **reading)


def _named(client: Client, text: str) -> Mesh:
    """The mesh of a file, or one on the server by what it is called there.

    Raises:
        ValueError: neither is there, or several meshes are called so.
    """
    if Path(text).is_file():
        return sent(client, Path(text))
    try:
        return client.mesh(text)
    except NotFound as error:
        raise ValueError(
            f"there is no file {text}, and {error.detail}. 'geodesic list' tells what is there"
        ) from None


def stored(client: Client, text: str) -> str:
    """The id of a mesh on the server: of a file's bytes, or by what it is called there.

    Raises:
        NotFound: neither is there. ValueError: several meshes are called so, or one that the file
            may not mean: it has other bytes.
    """
    file = Path(text)
    if file.is_file():
        digest = hashlib.sha256(file.read_bytes()).hexdigest()
        if any(mesh.id == digest for mesh in client.meshes()):
            return digest
    found = client.mesh(text).id
    if file.is_file() and file.suffix != ".gltf":  # which is uploaded with its other files
        raise ValueError(
            f"the server has not what is in the file {text}. A mesh that is called so is {found}"
        )
    return found


class Once(argparse.Action):
    """Stores a value, and refuses another one: the first would be lost."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: Any,
        option_string: str | None = None,
    ) -> None:
        """As argparse calls it."""
        if getattr(namespace, self.dest, None) is not None:
            parser.error(f"{option_string} may be given once")
        setattr(namespace, self.dest, values)


@contextmanager
def mesh_of(options: argparse.Namespace) -> Iterator[Mesh]:
    """The mesh that the options name, on a connection that is closed at the end.

    Raises:
        Misuse: what is to be written is what is read.
    """
    _keep_inputs(options)
    with connect(options) as client:
        yield _named(client, options.mesh)


def point(text: str) -> int | str:
    """A point as it is written on a command line: a number is a vertex."""
    return int(text) if text.isdigit() else text


def points(texts: Sequence[str]) -> list[Any]:
    """Several of them."""
    return [point(text) for text in texts]


def _keep_inputs(options: argparse.Namespace) -> None:
    read = [Path(options.mesh), getattr(options, "face_weights", None)]
    for name in ("from_file", "to_file"):
        read += getattr(options, name, [])
    for name in ("output", "into"):
        file: Path | None = getattr(options, name, None)
        for one in read:
            if file and one and file.is_file() and one.is_file() and file.samefile(one):
                raise Misuse(f"{file} is what is read here; write into another file")


def words_of(file: Path, apart: str = " ") -> list[str]:
    """The words of a text file, but for lines that begin with #; ``apart`` parts them, too.

    Raises:
        OSError: it cannot be read. ValueError: it is no text.
    """
    try:
        text = file.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError(f"{file} is no text in UTF-8 ({error.reason})") from None
    lines = (line for line in text.splitlines() if not line.lstrip().startswith("#"))
    return " ".join(lines).replace(apart, " ").split()


def listed(texts: Sequence[str], files: Sequence[Path]) -> list[str]:
    """Points as they are written on a command line and, with spaces or lines between them, in
    files.

    Raises:
        ValueError: a file has none.
    """
    found = list(texts)
    for file in files:
        words = words_of(file)
        if not words:
            raise ValueError(f"{file} has no points")
        found += words
    return found


def cell(text: str) -> str:
    """A point as it is written on a command line, in a row of CSV."""
    return f'"{text}"' if "," in text else text
