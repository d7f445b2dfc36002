"""Meshes as people call them: by a name, by an id or by how it begins. Names are no part of the
contract's URLs, so the list of meshes is searched here."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

from . import service
from .errors import NotFound, printable
from .flows import Flow

_WHOLE = re.compile(r"[0-9a-f]{64}(~([0-9a-f]{32}|[0-9a-f]{12}))?")
_BEGINNING = re.compile(r"[0-9a-f]{4,64}(~[0-9a-f]*)?")
_MOST_LISTED = 10


def mesh_id(text: str) -> Flow[str]:
    """The id of the one mesh that has this id or name, or else whose id begins so: with 4 digits
    at least, and behind a ``~`` with the beginning of what follows there. A beginning that fits a
    file read as it is, and else only that file read in other ways, means the first. A name does
    not go before the beginning of another mesh's id: what anybody may name is not to change what
    ``delete`` deletes.

    Raises:
        NotFound: none. ValueError: several; the message lists them.
    """
    if _WHOLE.fullmatch(text):
        return text
    known = yield from service.meshes()
    found = [one for one in known if one.get("name") == text]
    if _BEGINNING.fullmatch(text):
        begun = [one for one in known if _begins(one["id"], text)]
        plain = [one for one in begun if "~" not in one["id"]]
        if len({_file(one["id"]) for one in begun}) == 1 and plain:
            begun = plain
        found += [one for one in begun if one not in found]
    if not found:
        detail = f"no mesh on the server has the name {text!r} or an id that begins so"
        if re.fullmatch("[0-9a-f]{1,3}", text):
            detail += "; of an id, 4 digits are the least"
        raise NotFound(404, "mesh_unknown", detail)
    if len(found) > 1:
        raise ValueError(
            f"{text!r} may be any of {len(found)} meshes. Say which by its id:\n"
            + "\n".join(_candidates(found, _unmistaken_ids(known)))
        )
    return str(found[0]["id"])


def metadata(text: str) -> Flow[dict[str, Any]]:
    """The metadata of the mesh that :func:`mesh_id` finds."""
    return (yield from service.metadata((yield from mesh_id(text))))


def _file(mesh: str) -> str:
    return mesh.partition("~")[0]


def _begins(mesh: str, text: str) -> bool:
    file, _, reading = mesh.partition("~")
    of_file, mark, of_reading = text.partition("~")
    if mark and not reading:
        return False
    return file.startswith(of_file) and reading.startswith(of_reading)


def short_ids(meshes: Iterable[str]) -> dict[str, str]:
    """Ids by how they begin, as short as tells them apart: 8 digits or more, and 4 behind ``~``."""
    parts = {mesh: mesh.partition("~") for mesh in meshes}
    files = {file for file, _, _ in parts.values()}
    length, more = 8, 4
    while len({file[:length] for file in files}) < len(files):
        length += 1
    while len({(file, rest[:more]) for file, _, rest in parts.values()}) < len(parts):
        more += 1
    return {mesh: file[:length] + mark + rest[:more] for mesh, (file, mark, rest) in parts.items()}


def _unmistaken_ids(meshes: list[dict[str, Any]]) -> dict[str, str]:
    """Ids as :func:`short_ids` has them, but whole where a mesh has the short one as its name."""
    names = {one.get("name") for one in meshes}
    short = short_ids(one["id"] for one in meshes)
    return {mesh: mesh if begun in names else begun for mesh, begun in short.items()}


def _candidates(found: list[dict[str, Any]], short: Mapping[str, str]) -> list[str]:
    shown = [
        f"  {short[one['id']]}  {printable(one.get('name') or '')}  {reading_text(one['import'])}"
        for one in found[:_MOST_LISTED]
    ]
    rest = len(found) - len(shown)
    return [line.rstrip() for line in shown] + ([f"  and {rest} more"] if rest else [])


def reading_text(reading: Mapping[str, Any]) -> str:
    """How a file was told to be read, as the options of an upload: ``scale=0.001 up=z``."""
    return printable(" ".join(f"{name}={value}" for name, value in sorted(reading.items())))
