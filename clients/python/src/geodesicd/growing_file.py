"""A .npy file that grows row by row: what it holds of a table that is not whole yet, and how it is
gone on with."""

from __future__ import annotations

import errno
import hashlib
import json
import os
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import DTypeLike

from .encoding import body_json
from .replacing import replaced
from .results import FloatArray

_SAVE_EVERY = 2.0  # seconds between notes of how far a file has come
_BLOCK = 1 << 20  # numbers that are written at once


class GrowingFile:
    """A table's file, and how many of its rows are there. It has whole rows only; NaN stands for
    the others. How far it has come stands beside it, in ``<file>.part``, until it is whole.

    What was there before is not touched until the first row has come.
    """

    def __init__(
        self, file: Path, mesh: str, asked: dict[str, Any], dtype: DTypeLike, resume: bool
    ) -> None:
        require_place(file)
        text = json.dumps([mesh, body_json(asked)], sort_keys=True, allow_nan=False)
        self._question = hashlib.sha256(text.encode()).hexdigest()
        self._file = file
        self._beside = file.with_name(file.name + ".part")
        self._shape = (len(asked["from"]), len(asked["to"]))
        self._dtype = np.dtype(dtype)
        self._row_bytes = self._shape[1] * self._dtype.itemsize
        self._begun = bytearray()  # of the next row
        self.rows = self._found() if resume else 0
        self._array: FloatArray | None = None
        if self.rows > 0:
            self._array = np.lib.format.open_memmap(file, "r+")
        self._noted = time.monotonic()

    def _found(self) -> int:
        """How many rows of this table the file has."""
        try:
            note = json.loads(self._beside.read_text(encoding="utf-8"))
            array = np.lib.format.open_memmap(self._file, "r")
            same = note["question"] == self._question
            if same and array.shape == self._shape and array.dtype == self._dtype:
                return min(int(note["rows"]), self._shape[0])
        except (OSError, ValueError, LookupError, TypeError):
            pass
        return 0

    def begin_again(self) -> None:
        """Drops what has come of a row that is not whole."""
        self._begun.clear()

    def write(self, data: bytes) -> None:
        """What comes next."""
        self._begun += data
        if self.rows * self._row_bytes + len(self._begun) > self._shape[0] * self._row_bytes:
            raise ValueError("the server sends more than the table has")
        rows = len(self._begun) // self._row_bytes
        if rows == 0:
            return
        if self._array is None:
            self._array = self._replaced()
            self.note()
        whole = self._begun[: rows * self._row_bytes]
        there = self._array[self.rows : self.rows + rows]
        there[:] = np.frombuffer(whole, self._dtype).reshape(there.shape)
        del self._begun[: len(whole)]
        self.rows += rows
        if time.monotonic() - self._noted > _SAVE_EVERY:
            self.note()

    def _replaced(self) -> FloatArray:
        """A file of NaN in place of what was there. It is written elsewhere first: so a full disk
        is noticed while nothing is lost, and who has the earlier table mapped keeps it."""
        with replaced(self._file) as fresh:
            _write_nan(fresh, self._shape, self._dtype)
            self._beside.unlink(missing_ok=True)  # it is about what was there
        return np.lib.format.open_memmap(self._file, "r+")

    def note(self) -> None:
        """Says beside the file how far it has come."""
        if self._array is None:
            return
        self._array.flush()  # type: ignore[attr-defined]
        text = json.dumps({"question": self._question, "rows": self.rows})
        fresh = self._beside.with_name(self._beside.name + ".new")
        fresh.write_text(text, encoding="utf-8")
        fresh.replace(self._beside)
        self._noted = time.monotonic()

    def finished(self) -> FloatArray:
        """The whole, with no note any more."""
        assert self._array is not None
        self._beside.unlink()
        return self._array


def require_place(file: Path) -> None:
    """OSError: no file can be there. Better now than after the first row."""
    folder = file.resolve().parent
    if file.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(file))
    if not folder.is_dir():
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(folder))


def _write_nan(file: Path, shape: tuple[int, int], dtype: np.dtype[Any]) -> None:
    """A .npy file that is all NaN."""
    header = {
        "descr": np.lib.format.dtype_to_descr(dtype),
        "fortran_order": False,
        "shape": shape,
    }
    numbers = shape[0] * shape[1]
    block = np.full(min(numbers, _BLOCK), np.nan, dtype)
    with file.open("wb") as out:
        np.lib.format.write_array_header_1_0(out, header)
        for begin in range(0, numbers, _BLOCK):
            out.write(block[: numbers - begin].data)
