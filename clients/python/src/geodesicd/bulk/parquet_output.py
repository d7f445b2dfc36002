"""Answers as a Parquet data set: a file for each, with a row for each number."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from ..exports import library
from .output import Output
from .questions import Columns

pyarrow = library("pyarrow")
parquet = library("pyarrow.parquet")

_MANIFEST = "_manifest.json"  # readers of data sets leave out names that begin so


class ParquetOutput(Output):
    """A folder of Parquet files, which pandas, Dask and DuckDB read as one table."""

    def place(self, key: str) -> Path:
        """The answer's file."""
        return self.folder / f"{key}.parquet"

    def keys(self) -> set[str]:
        """Those of the files."""
        return {file.stem for file in self.folder.glob("*.parquet")}

    def write(self, key: str, found: Columns, about: dict[str, Any]) -> None:
        """Writes a file: the columns ``file`` and ``mesh``, one for each axis, which counts along
        it, and one for each array."""
        axes = len(found.axes)
        shape = next(iter(found.arrays.values())).shape[:axes]
        rows = int(np.prod(shape))
        columns = {}
        for name in ("file", "mesh"):
            columns[name] = pyarrow.repeat(about[name], rows).dictionary_encode()
        for axis, name in enumerate(found.axes):
            count = np.arange(shape[axis]) + (found.first if axis == 0 else 0)
            along = count.reshape([-1 if one == axis else 1 for one in range(axes)])
            columns[name] = pyarrow.array(np.broadcast_to(along, shape).ravel())
        for name, array in found.arrays.items():
            flat = pyarrow.array(np.ascontiguousarray(array).ravel())
            if array.ndim > axes:
                flat = pyarrow.FixedSizeListArray.from_arrays(flat, array.shape[-1])
            columns[name] = flat
        table = pyarrow.table(columns)
        table = table.replace_schema_metadata({"geodesicd": json.dumps(about)})
        with self.part() as part:
            parquet.write_table(table, part / "file")
            self._into_place(part / "file", key)

    def _read_manifest(self) -> dict[str, Any] | None:
        file = self.folder / _MANIFEST
        if not file.exists():
            return None
        found: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
        return found

    def _write_manifest(self, manifest: dict[str, Any]) -> None:
        with self.part() as part:
            (part / "file").write_text(json.dumps(manifest, indent=1) + "\n", encoding="utf-8")
            (part / "file").replace(self.folder / _MANIFEST)
