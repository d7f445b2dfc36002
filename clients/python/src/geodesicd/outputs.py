"""The files that commands write: each is whole, or what was there before stays."""

from __future__ import annotations

import io
import json
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import ArrayLike

from .client import Mesh
from .digits import number, numbers, short
from .encoding import milliseconds
from .errors import Misuse
from .flows import Progress
from .growing_file import require_place
from .replacing import replaced


@contextmanager
def whole(file: Path) -> Iterator[IO[bytes]]:
    """Where to write what becomes this file when all of it is there.

    Raises:
        OSError: it cannot be written; the message names the file.
    """
    if file.exists() and not file.is_file():  # a pipe, or a terminal
        try:
            with file.open("wb") as out:
                yield out
        except OSError as error:
            raise type(error)(error.errno, error.strerror, str(file)) from None
        return
    with replaced(file) as fresh, fresh.open("wb") as out:
        yield out


def save_bytes(file: Path, data: bytes | memoryview) -> None:
    """A file of these bytes."""
    with whole(file) as out:
        out.write(data)


def save_text(file: Path, text: str) -> None:
    """A text in UTF-8."""
    save_bytes(file, text.encode())


def save_array(file: Path, array: ArrayLike) -> None:
    """A ``.npy`` file."""
    made = io.BytesIO()  # given a file, NumPy does not say why it cannot be written
    np.save(made, array)
    save_bytes(file, made.getbuffer())


def save_arrays(file: Path, **arrays: ArrayLike) -> None:
    """A ``.npz`` file."""
    with whole(file) as out:
        np.savez(out, **arrays)  # type: ignore[arg-type]


def save_csv(file: Path, header: str, *columns: Iterable[str]) -> None:
    """A row for each element of the columns, which are as long as each other."""
    lines = (",".join(row) for row in zip(*columns, strict=True))
    save_text(file, "\n".join([header, *lines]) + "\n")


def save_sparse(file: Path, table: Any) -> None:
    """A sparse table as SciPy's ``save_npz`` writes it."""
    save_arrays(
        file,
        indices=table.indices,
        indptr=table.indptr,
        format=b"csr",
        shape=np.array(table.shape),
        data=table.data,
    )


def save_line(file: Path, line: Any) -> None:
    """A path or a loop, as .csv, .npy or .json; nothing by another ending."""
    if file.suffix == ".csv":
        columns = [numbers(axis) for axis in line.points.T]
        faces = map(str, line.faces.tolist())
        save_csv(file, "x,y,z,face,along", *columns, faces, numbers(line.along))
    elif file.suffix == ".npy":
        save_array(file, line.points)
    elif file.suffix == ".json":
        document = {
            "length": float(number(line.length)),
            "points": short(line.points).tolist(),
            "faces": line.faces.tolist(),
            "bary": [None if np.isnan(b).any() else b.tolist() for b in short(line.bary)],
        }
        save_text(file, json.dumps(document) + "\n")


def save_reply(
    file: Path, mesh: Mesh, query: str, asked: dict[str, Any], progress: Progress | None
) -> None:
    """The server's reply itself, in the format that the file's name ends with. ``asked``: by the
    contract's names, but for ``deadline`` in seconds."""
    format = file.suffix.removeprefix(".")
    parameters = {**asked, "deadline_ms": milliseconds(asked.get("deadline"))}
    parameters.pop("deadline", None)
    answer = mesh.query(query, parameters, format=format, progress=progress)
    if format == "json":
        save_text(file, json.dumps(answer.document) + "\n")
    else:
        save_bytes(file, answer.data)


def save_rows(file: Path | None, rows: Iterable[str]) -> None:
    """Lines of CSV, printed where there is no file for them."""
    text = "\n".join(rows)
    if file is None:
        print(text)
    else:
        save_text(file, text + "\n")


def require(file: Path | None, endings: tuple[str, ...]) -> None:
    """Says before the work that a file, if there is to be one, cannot be written so.

    Raises:
        Misuse: its name ends otherwise. OSError: its folder is not there, or it is one itself.
    """
    if file is None:
        return
    if file.suffix not in endings:
        raise Misuse(f"{file} should end with {' or '.join(endings)}")
    require_place(file)
