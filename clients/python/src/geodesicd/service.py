"""The calls that are no queries: uploading, listing, renaming and deleting meshes, and what the
server says of itself."""

from __future__ import annotations

import json
from typing import Any, Literal, TypedDict
from urllib.parse import urlencode

from .errors import GeodesicError, NotAllowed, NotFound
from .flows import Flow, Progress, Request, Send, ask
from .mesh_input import UploadBody
from .wire import Reply


class Reading(TypedDict, total=False):
    """How a file is to be read. The same file read in two ways is two meshes."""

    scene: int | str  # of a glTF file, by index or name; else its default scene
    node: int | str  # of a glTF file: what it and its children draw, nothing else
    weld: float | Literal["off"]  # join vertices at most so far apart; 0 without it
    up: Literal["x", "y", "z"]  # the axis that points up in the file; y without it
    scale: float  # all positions times this


def upload(
    body: UploadBody,
    progress: Progress | None = None,
    *,
    probe: bool = True,
    reading: Reading | None = None,
    name: str | None = None,
) -> Flow[dict[str, Any]]:
    """Sends a mesh; its metadata. ``probe`` asks first, by the digest, whether the server has it
    already, unless it is to be read in a way of its own. ``name`` is what to call the mesh, if it
    has no name yet, and is refused where that may not be; without it, the body's, if that may be.
    ``progress``: the first half is sending, the second
    the server's work on it."""
    reading = reading or {}
    called = body.name if name is None else name
    if unknown := reading.keys() - Reading.__annotations__.keys():
        raise TypeError(f"upload() got an unexpected keyword argument {min(unknown)!r}")
    # A form's id is that of the one file that the server makes of it.
    where = "/v1/meshes" if body.form else f"/v1/meshes/{body.digest}"
    parameters: dict[str, Any] = {**reading, **({"name": called} if called else {})}
    target = f"{where}?{urlencode(parameters)}" if parameters else where
    if probe and not reading and not body.form:
        try:
            yield Send(Request("HEAD", where))
        except (NotFound, NotAllowed):
            pass  # a token may allow to upload and not to ask
        else:
            known = yield from metadata(body.digest)
            if called and not known.get("name"):
                known = yield from _named(known, called, asked=name is not None)
            if progress is not None:
                progress(1.0)
            return known
    media_type = body.form or "application/octet-stream"
    sending = Request("POST" if body.form else "PUT", target, {"Content-Type": media_type}, body)
    if progress is None:
        return (yield from ask(sending, _object))
    body.progress = lambda sent: progress(sent / 2)
    return (yield from ask(sending, _object, lambda done: progress(0.5 + done / 2)))


def _named(known: dict[str, Any], name: str, asked: bool) -> Flow[dict[str, Any]]:
    """A mesh that has no name gets one, as sending its file again would give it. The mesh is there
    without it, so that only a name that was asked for is worth an error."""
    try:
        return (yield from rename(known["id"], name))
    except GeodesicError:  # a token may allow to ask and not to change
        if asked:
            raise
        return known


def _object(reply: Reply) -> dict[str, Any]:
    document: dict[str, Any] = reply.json()
    return document


def metadata(mesh: str) -> Flow[dict[str, Any]]:
    """A mesh's metadata."""
    return ask(Request("GET", f"/v1/meshes/{mesh}"), _object)


def meshes(page_size: int = 1000) -> Flow[list[dict[str, Any]]]:
    """The metadata of all meshes, in the order of their ids, asked for by the page."""
    found: list[dict[str, Any]] = []
    cursor: str | None = None
    while True:
        after = "" if cursor is None else f"&cursor={cursor}"
        page = yield from ask(Request("GET", f"/v1/meshes?limit={page_size}{after}"), _object)
        found += page["meshes"]
        cursor = page["next"]
        if cursor is None:
            return found


def prepare(mesh: str, progress: Progress | None = None) -> Flow[dict[str, Any]]:
    """Builds now what queries need, so that the first is quick; the mesh's metadata then."""
    return ask(Request("POST", f"/v1/meshes/{mesh}/prepare"), _object, progress)


def rename(mesh: str, name: str) -> Flow[dict[str, Any]]:
    """Gives a mesh a name, in place of one that it has; an empty one takes that away. Its metadata
    then."""
    body = json.dumps({"name": name}).encode()
    headers = {"Content-Type": "application/json"}
    return ask(Request("PATCH", f"/v1/meshes/{mesh}", headers, body), _object)


def delete(mesh: str) -> Flow[None]:
    """Deletes a mesh."""
    return ask(Request("DELETE", f"/v1/meshes/{mesh}"), lambda reply: None)


def status() -> Flow[dict[str, Any]]:
    """Version, limits, load and caches, as ``/v1/status`` has them."""
    return ask(Request("GET", "/v1/status"), _object)


def methods() -> Flow[list[dict[str, Any]]]:
    """The methods: ``name``, ``paper``, ``exact``, ``cost`` and ``parameters`` of each."""
    return ask(Request("GET", "/v1/methods"), lambda reply: list(reply.json()["methods"]))
