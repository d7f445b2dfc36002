"""What a load test asks for: requests of four kinds in given shares, about random points."""

from __future__ import annotations

import random
from typing import Any

import numpy as np

from .. import queries, service, tables
from ..flows import Flow
from ..glb import glb_bytes
from ..mesh_input import UploadBody
from ..results import Float64, Index

KINDS = ("upload", "field", "path", "table")


def parse_mix(text: str) -> dict[str, float]:
    """Shares by kind of ``"path=8,field=1,table=1"``; a kind alone has the share 1.

    Raises:
        ValueError: an unknown kind, a share that is no positive number, or none at all.
    """
    mix: dict[str, float] = {}
    for part in filter(None, (part.strip() for part in text.split(","))):
        kind, _, share = part.partition("=")
        if kind not in KINDS:
            raise ValueError(f"'{kind}' is none of {', '.join(KINDS)}")
        try:
            mix[kind] = float(share or 1)
        except ValueError:
            raise ValueError(f"the share of {kind} is no number: '{share}'") from None
        if not (0 < mix[kind] < float("inf")):
            raise ValueError(f"the share of {kind} has to be positive: '{share}'")
    if not mix:
        raise ValueError("a mix has at least one kind")
    return mix


def hills(side: int, seed: int) -> tuple[Float64, Index]:
    """A landscape of ``side`` x ``side`` vertices a mesh unit apart: vertices (n, 3) and
    faces (m, 3). Another seed gives other hills, and so other bytes."""
    chance = np.random.default_rng(seed)
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(side), np.arange(side)))
    height = np.zeros(side * side)
    for _ in range(12):
        wave = chance.normal(size=2) * 6 / side
        height += np.sin(x * wave[0] + y * wave[1] + chance.uniform(0, 6.3))
    vertices = np.column_stack([x, y, height * side / 40]).astype(np.float64)
    corner = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    one = np.column_stack([corner, corner + 1, corner + side + 1])
    two = np.column_stack([corner, corner + side + 1, corner + side])
    return vertices, np.concatenate([one, two]).astype(np.int64)


class Workload:
    """Draws requests.

    Args:
        mesh: the id of the mesh that is asked about.
        vertices: how many it has.
        mix: shares by kind.
        sources: from how many different vertices fields start: few of them stay in the
            server's cache, many do not; 0: from any.
        table_side: rows and columns of a table.
        upload_side: uploads have the square of this many vertices.
        method: how distances are computed.
        seed: the same seed draws the same requests.
    """

    def __init__(
        self,
        mesh: str,
        vertices: int,
        mix: dict[str, float],
        *,
        sources: int = 0,
        table_side: int = 8,
        upload_side: int = 32,
        method: str | None = None,
        seed: int = 1,
    ) -> None:
        self.mesh = mesh
        self.mix = mix
        self.uploaded: list[str] = []
        self._chance = random.Random(seed)
        self._vertices = vertices
        self._sources = [self._chance.randrange(vertices) for _ in range(sources)]
        self._table_side = table_side
        self._upload_side = upload_side
        self._method = method

    def draw(self) -> tuple[str, Flow[Any]]:
        """The next request: its kind and its flow."""
        kind = self._chance.choices(list(self.mix), weights=list(self.mix.values()))[0]
        return kind, self.flow(kind)

    def flow(self, kind: str) -> Flow[Any]:
        """A request of that kind."""
        if kind == "upload":
            # Each another mesh: what is known already would not be decoded.
            seed = self._chance.getrandbits(48)
            body = UploadBody(glb_bytes(*hills(self._upload_side, seed)))
            self.uploaded.append(body.digest)
            return service.upload(body, probe=False)
        if kind == "field":
            return queries.distance(
                self.mesh, self._source(), dtype=np.float32, method=self._method
            )
        if kind == "path":
            return queries.path(self.mesh, self._source(), self._vertex(), method=self._method)
        rows = [self._source() for _ in range(self._table_side)]
        columns = [self._vertex() for _ in range(self._table_side)]
        return tables.table(self.mesh, rows, columns, method=self._method)

    def _vertex(self) -> int:
        return self._chance.randrange(self._vertices)

    def _source(self) -> int:
        return self._chance.choice(self._sources) if self._sources else self._vertex()
