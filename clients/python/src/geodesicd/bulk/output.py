"""The folder that a run writes to. What is there is whole, since each answer is written beside it
and then renamed; a manifest says which question it answers."""

from __future__ import annotations

import fcntl
import json
import os
import shutil
import tempfile
from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from .questions import Columns

_PARTS = ".parts"  # of answers being written; names that begin so are no data to anybody


class Output(ABC):
    """A folder of answers, each under a key. Workers write to it, and one run at a time reads and
    changes its manifest."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder.absolute()  # workers may be in another one

    @contextmanager
    def opened(self, question: dict[str, Any]) -> Iterator[dict[str, Any]]:
        """The manifest, for a run that asks this; it is written at the end as it is then.

        Raises:
            ValueError: there are answers to another question, something else, or another run.
        """
        self.folder.mkdir(parents=True, exist_ok=True)
        with self._locked():
            manifest = self._checked(json.loads(json.dumps(question)))  # as it is read again
            shutil.rmtree(self.folder / _PARTS, ignore_errors=True)  # of workers that were killed
            (self.folder / _PARTS).mkdir()
            self._write_manifest(manifest)
            try:
                yield manifest
            finally:
                self._write_manifest(manifest)
                shutil.rmtree(self.folder / _PARTS, ignore_errors=True)

    @contextmanager
    def _locked(self) -> Iterator[None]:
        """For one run at a time; the kernel ends it with the process."""
        lock = os.open(self.folder, os.O_RDONLY)
        try:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise ValueError(
                    f"another run is writing to {self.folder}: wait for its end"
                ) from None
            yield
        finally:
            os.close(lock)

    def _checked(self, question: dict[str, Any]) -> dict[str, Any]:
        known = self._read_manifest()
        another = f"Write to another folder than {self.folder}"
        if known is None and any(one.name != _PARTS for one in self.folder.iterdir()):
            raise ValueError(f"that folder has something else in it. {another}")
        if known is None or known["engine"] is None:  # no server has been found so far
            return {"question": question, "engine": None, "meshes": {}, "failures": {}}
        if known["question"] != question:
            raise ValueError(
                f"that folder has answers to another question, {json.dumps(known['question'])}, "
                f"and this one is {json.dumps(question)}. {another}"
            )
        return known

    def note_engine(self, manifest: dict[str, Any], engine: str) -> None:
        """Notes in the manifest which build of the server answers.

        Raises:
            ValueError: what is there is by another build, whose last digits may differ.
        """
        if manifest["engine"] not in (None, engine):
            raise ValueError(
                f"the answers there are by another build of the server, {manifest['engine']}, and "
                f"this one is {engine}. Go on with that build, or write to another folder than "
                f"{self.folder}"
            )
        manifest["engine"] = engine
        self._write_manifest(manifest)

    @contextmanager
    def part(self) -> Iterator[Path]:
        """A folder of its own to write an answer in, on the same file system."""
        folder = Path(tempfile.mkdtemp(dir=self.folder / _PARTS))
        try:
            yield folder
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    @abstractmethod
    def place(self, key: str) -> Path:
        """Where the answer with this key is, or would be."""

    @abstractmethod
    def keys(self) -> set[str]:
        """The keys of all answers that are there."""

    @abstractmethod
    def write(self, key: str, found: Columns, about: dict[str, Any]) -> None:
        """Writes an answer, and what it is about: whole, or not at all."""

    @abstractmethod
    def _read_manifest(self) -> dict[str, Any] | None: ...

    @abstractmethod
    def _write_manifest(self, manifest: dict[str, Any]) -> None: ...

    def prepare(self, rows: int, columns: int, run: int) -> None:
        """Makes room for a matrix of that shape, which is written so many rows at a time."""
        return

    def has(self, key: str) -> bool:
        """Whether that answer is there."""
        return self.place(key).exists()

    def _into_place(self, part: Path, key: str) -> None:
        place = self.place(key)
        place.parent.mkdir(parents=True, exist_ok=True)
        try:
            part.replace(place)
        except OSError:
            # A folder is not replaced: a worker that was taken for lost has written the same.
            if not place.exists():
                raise


def output_at(place: str | os.PathLike[str], of_matrix: bool = False) -> Output:
    """The output of that name: ``….zarr`` or ``….parquet``.

    Raises:
        ValueError: another name. ImportError: what writes it is not installed.
    """
    folder = Path(place)
    if folder.suffix == ".parquet":
        from .parquet_output import ParquetOutput

        return ParquetOutput(folder)
    if folder.suffix == ".zarr":
        from .zarr_output import ZarrMatrix, ZarrOutput

        return ZarrMatrix(folder) if of_matrix else ZarrOutput(folder)
    raise ValueError(f"{folder} should end with .zarr or .parquet")
