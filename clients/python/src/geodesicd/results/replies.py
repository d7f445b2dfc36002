"""Replies in the contract's own words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from ..errors import GeodesicError


@dataclass(frozen=True)
class BatchReply:
    """The answer to one line of a batch: a ``reply`` as the query alone would have in JSON, or
    an ``error``. ``id`` is the line's own, if it had one."""

    status: int
    reply: dict[str, Any] | None
    error: GeodesicError | None
    id: str | int | float | None = None


@dataclass(frozen=True, eq=False)
class Answer:
    """A reply in the contract's own words.

    Attributes:
        document: the JSON, also of a frame; None if there is none.
        arrays: a frame's by name, lengths in mesh units; ``"array"`` of a bare one, as it came.
        data: the body of a picture, or of a .glb or .gltf file, else empty.
        media_type: the reply's.
        max: the greatest finite distance of a bare array of distances, mesh units, else None.
    """

    document: dict[str, Any] | None
    arrays: dict[str, NDArray[Any]]
    data: bytes
    media_type: str
    max: float | None
