"""A .gltf file whose buffers are in files beside it: which those are, and all of them as one form,
which the server packs into one GLB. Images are left where they are: they change no distance."""

from __future__ import annotations

import json
import re
import secrets
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

# In quotes, some read a backslash as itself and others as an escape of the next character. They
# differ where that is the closing quote or another backslash.
_AMBIGUOUS = re.compile(r"\\+$|\\{2,}")


def buffer_files(document: Path) -> dict[str, Path]:
    """The files that hold the buffers of a .gltf file, by their names in it; none if it holds
    its data itself, or cannot be read, which is the server's to say.

    Raises:
        FileNotFoundError: some are not there; the message names them.
        ValueError: one is not beside the .gltf file, or below.
    """
    try:
        content: Any = json.loads(document.read_bytes())
        buffers = content.get("buffers", [])
        uris = [buffer["uri"] for buffer in buffers if isinstance(buffer.get("uri"), str)]
    except (ValueError, AttributeError, TypeError):
        return {}
    folder = document.parent.resolve()
    found: dict[str, Path] = {}
    for uri in uris:
        if uri.startswith("data:"):
            continue
        name = unquote(uri).removeprefix("./")
        file = (folder / name).resolve()
        # A file from somewhere else is not to make this client read and send any other.
        if urlsplit(uri).scheme or not file.is_relative_to(folder) or not name.isprintable():
            raise ValueError(
                f"{document} names the buffer {name!r}, which is not in its folder: put it there, "
                "and name it so"
            )
        found[name] = file
    if missing := [name for name, file in found.items() if not file.is_file()]:
        raise FileNotFoundError(
            f"{document} names {', '.join(missing)}, which {'is' if len(missing) == 1 else 'are'} "
            f"not in {document.parent}: put {'it' if len(missing) == 1 else 'them'} beside it"
        )
    return found


def form(files: dict[str, Path]) -> tuple[str, list[bytes | Path]]:
    """The form of files by their names in it: its media type, and its pieces."""
    boundary = secrets.token_hex(24)
    pieces: list[bytes | Path] = []
    for name, file in files.items():
        quoted = _AMBIGUOUS.sub(lambda found: "/" * len(found[0]), name).replace('"', "%22")
        head = f'Content-Disposition: form-data; name="files"; filename="{quoted}"'
        pieces += [f"--{boundary}\r\n{head}\r\n\r\n".encode(), file, b"\r\n"]
    return f"multipart/form-data; boundary={boundary}", [*pieces, f"--{boundary}--\r\n".encode()]
