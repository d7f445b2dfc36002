"""Answers as Zarr: a group a mesh, or a matrix whose chunks are runs of its rows."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np

from ..exports import library
from .output import Output
from .questions import Columns

zarr = library("zarr")

_MANIFEST = "geodesicd"  # an attribute of the whole


class ZarrOutput(Output):
    """A Zarr group with a group for each answer, whose attributes say what it is about."""

    def place(self, key: str) -> Path:
        """The answer's group."""
        return self.folder / key

    def keys(self) -> set[str]:
        """Those of the groups."""
        return {file.parent.name for file in self.folder.glob("*/zarr.json")}

    def write(self, key: str, found: Columns, about: dict[str, Any]) -> None:
        """Writes a group."""
        with self.part() as part:
            made = part / "group"
            group = zarr.create_group(made, zarr_format=3, attributes=about)
            for name, array in found.arrays.items():
                more = [None] * (array.ndim - len(found.axes))
                group.create_array(name, data=array, dimension_names=[*found.axes, *more])
            self._into_place(made, key)

    def _read_manifest(self) -> dict[str, Any] | None:
        if not (self.folder / "zarr.json").exists():
            return None
        found: dict[str, Any] | None = zarr.open_group(self.folder, mode="r").attrs.get(_MANIFEST)
        return found

    def _write_manifest(self, manifest: dict[str, Any]) -> None:
        with self.part() as part:
            zarr.create_group(part / "group", zarr_format=3, attributes={_MANIFEST: manifest})
            (part / "group" / "zarr.json").replace(self.folder / "zarr.json")


class ZarrMatrix(ZarrOutput):
    """A Zarr group with one array, ``distance``: NaN where nothing has been written yet. Its keys
    are the numbers of its chunks, each of which is a run of whole rows."""

    def prepare(self, rows: int, columns: int, run: int) -> None:
        """Makes the array, unless it is there."""
        if (self.folder / "distance").exists():
            return
        with self.part() as part:
            zarr.create_array(
                part / "distance",
                zarr_format=3,
                shape=(rows, columns),
                chunks=(run, columns),
                dtype=np.float64,
                fill_value=np.nan,
                dimension_names=["source", "target"],
            )
            (part / "distance").replace(self.folder / "distance")

    def place(self, key: str) -> Path:
        """The chunk's file."""
        return self.folder / "distance" / "c" / key / "0"

    def keys(self) -> set[str]:
        """Those of the chunks."""
        return {file.parent.name for file in self.folder.glob("distance/c/*/0")}

    def write(self, key: str, found: Columns, about: dict[str, Any]) -> None:
        """Writes a chunk."""
        block = found.arrays["distance"]
        with self.part() as part:
            shutil.copy(self.folder / "distance" / "zarr.json", part)
            zarr.open_array(part, mode="r+")[found.first : found.first + len(block)] = block
            self._into_place(part / "c" / key / "0", key)
