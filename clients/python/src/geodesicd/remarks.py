"""What the server remarks on an answer, such as a point far from the surface: Python's warnings,
which name the line that asked."""

from __future__ import annotations

import asyncio
import os
import sys
import warnings
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

from .errors import GeodesicWarning, printable

_MOST = 10  # of one answer: more are a flood that nobody reads
_LONGEST = 1000
_NOBODYS = tuple(f"{Path(file).parent}{os.sep}" for file in (__file__, asyncio.__file__))

_kept: ContextVar[list[str] | None] = ContextVar("_kept", default=None)


@contextmanager
def kept_remarks() -> Iterator[list[str]]:
    """What is remarked in a block of this thread, as a list in place of warnings."""
    kept: list[str] = []
    before = _kept.set(kept)
    try:
        yield kept
    finally:
        _kept.reset(before)


def remarks_in(headers: Mapping[str, str]) -> list[str]:
    """The sentences of a reply's ``Geo-Warnings``."""
    return [one.strip() for one in headers.get("geo-warnings", "").split("; ") if one.strip()]


def remark(sentences: Iterable[str]) -> None:
    """Warns of each, at the first line up the stack that is not this package's. Where a task of
    asyncio's makes the call itself, that is the line that runs the loop."""
    told = list(dict.fromkeys(sentences))
    left = len(told) - _MOST
    kept = _kept.get()
    for sentence in [*told[:_MOST], *([f"and {left} more warnings"] if left > 0 else [])]:
        shown = printable(sentence[:_LONGEST])
        if kept is None:
            warnings.warn(shown, GeodesicWarning, _level_of_caller())
        else:
            kept.append(shown)


def _level_of_caller() -> int:
    """The ``stacklevel`` for :func:`remark` itself to give."""
    frame = sys._getframe(1)
    level = 1
    while frame.f_back is not None and frame.f_code.co_filename.startswith(_NOBODYS):
        frame = frame.f_back
        level += 1
    return level
