"""Bytes from the server as values: a body gathered into one buffer, arrays that are views of
that buffer, frames, and the records made of JSON."""

from __future__ import annotations

import io
import json
import math
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .results import (
    Answer,
    Bisector,
    Extent,
    Float64,
    FloatArray,
    Geometry,
    Index,
    Isoline,
    LabelledDistances,
    Logmap,
    Loop,
    Measure,
    Path,
    Samples,
    SparseTable,
    SurfacePoint,
    Trace,
    Voronoi,
)

_NONE = 0xFFFFFFFF  # in frames: no face, no label


class Body:
    """A reply's body while it arrives. If its size is announced, there is one buffer of that
    size, and each piece is copied to its place: a field of a million vertices is in memory
    once."""

    def __init__(self, method: str, headers: Mapping[str, str]) -> None:
        length = headers.get("content-length", "")
        plain = "content-encoding" not in headers and method != "HEAD"
        self._buffer = bytearray(int(length) if plain and length.isdigit() else 0)
        self._end = 0

    def feed(self, chunk: bytes) -> None:
        """Takes the next piece."""
        end = self._end + len(chunk)
        if end <= len(self._buffer):
            self._buffer[self._end : end] = chunk
        else:
            del self._buffer[self._end :]
            self._buffer += chunk
        self._end = end

    def finish(self) -> bytearray:
        """The whole."""
        del self._buffer[self._end :]
        return self._buffer


@dataclass(frozen=True)
class Reply:
    """A reply in full. Header names are in lower case."""

    status: int
    headers: Mapping[str, str]
    body: bytearray

    def json(self) -> Any:
        """The body as JSON."""
        return json.loads(self.body)


def raw(reply: Reply) -> bytes:
    """The body of a reply as it came."""
    return bytes(reply.body)


def bare_array(reply: Reply) -> NDArray[Any]:
    """The bare array of a reply, in the shape that its headers tell: a view of the body, without
    a copy."""
    shape = tuple(int(size) for size in reply.headers["geo-shape"].split(","))
    return np.frombuffer(reply.body, dtype=np.dtype(reply.headers["geo-dtype"])).reshape(shape)


def array(reply: Reply) -> FloatArray:
    """The bare array of a reply. Quantised numbers become float32 over [0, Geo-Max], with
    infinity for what was not reached."""
    numbers = bare_array(reply)
    if numbers.dtype != np.dtype("<u2"):
        return numbers
    greatest = float(reply.headers.get("geo-max", "0"))
    field = numbers * np.float32(greatest / 65534)
    field[numbers == 65535] = np.inf
    return field


def answer(reply: Reply, format: str) -> Answer:
    """A reply in the format that was asked for."""
    document: dict[str, Any] | None = None
    arrays: dict[str, NDArray[Any]] = {}
    data = b""
    if format == "json":
        document = reply.json()
    elif format == "frame":
        document, arrays = frame(reply.body)
    elif format == "npy":
        arrays = {"array": np.load(io.BytesIO(reply.body), allow_pickle=False)}
    elif format in ("f32", "f64", "u16"):
        arrays = {"array": bare_array(reply)}
    else:
        data = raw(reply)
    greatest = reply.headers.get("geo-max")
    media_type = reply.headers.get("content-type", "").partition(";")[0]
    return Answer(document, arrays, data, media_type, None if greatest is None else float(greatest))


def frame(body: bytearray) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """A frame's JSON and its arrays, which are views of the body.

    Raises:
        ValueError: it is no frame of version 1, or is cut off.
    """
    if len(body) < 24:
        raise ValueError("a frame has a header of 24 bytes")
    magic, version, json_length, _, length = struct.unpack_from("<4sIIIQ", body)
    if magic != b"GEOD" or version != 1 or length != len(body):
        raise ValueError(f"no whole frame of version 1: {magic!r}, {version}, {length} bytes")
    document = json.loads(body[24 : 24 + json_length])
    arrays: dict[str, NDArray[Any]] = {}
    for entry in document.pop("arrays"):
        dtype = np.dtype(entry["dtype"])
        flat = np.frombuffer(body, dtype, entry["nbytes"] // dtype.itemsize, entry["offset"])
        arrays[entry["name"]] = flat.reshape(entry["shape"])
    return document, arrays


def _length(value: float | None) -> float:
    return math.inf if value is None else float(value)


def _signed(indices: NDArray[Any]) -> Index:
    signed = indices.astype(np.int64)
    signed[signed == _NONE] = -1
    return signed


def surface_point(reply: Mapping[str, Any]) -> SurfacePoint:
    """A resolved point."""
    face, bary = reply["face"], reply["bary"]
    return SurfacePoint(
        face=-1 if face is None else int(face),
        bary=np.array([math.nan] * 3 if bary is None else bary, dtype=np.float64),
        xyz=np.array(reply["xyz"], dtype=np.float64),
        snap_distance=float(reply["snap_distance"]),
        vertex=reply.get("vertex"),
        ray_distance=reply.get("ray_distance"),
        kind=reply.get("kind"),
        length=reply.get("length"),
        pieces=reply.get("pieces"),
    )


def _line(points: list[dict[str, Any]]) -> tuple[Float64, Index, Float64]:
    """The arrays of a line's points in JSON."""
    nowhere = [math.nan] * 3
    xyz = np.array([p["xyz"] for p in points], dtype=np.float64).reshape(-1, 3)
    faces = np.array([-1 if p["face"] is None else p["face"] for p in points], dtype=np.int64)
    bary = np.array([p["bary"] or nowhere for p in points], dtype=np.float64).reshape(-1, 3)
    return xyz, faces, bary


def _path(document: Mapping[str, Any], xyz: Float64, faces: Index, bary: Float64) -> Path:
    return Path(
        points=xyz,
        faces=faces,
        bary=bary,
        length=_length(document["length"]),
        reachable=bool(document["reachable"]),
        source=surface_point(document["from"]),
        via=tuple(surface_point(point) for point in document["via"]),
        target=surface_point(document["to"]),
        method=document["method"],
        refine=document["refine"],
        cost=_length(document["cost"]) if "cost" in document else None,
        unit=document.get("unit"),
        segment_costs=_costs(document["segments"]) if "segments" in document else None,
    )


def _costs(segments: Sequence[Mapping[str, Any]]) -> Float64:
    return np.array([segment["cost"] for segment in segments], dtype=np.float64)


def path_of_json(document: Mapping[str, Any]) -> Path:
    """A path from its JSON, as a batch has it."""
    return _path(document, *_line(document["points"]))


def path_of_frame(reply: Reply) -> Path:
    """A path from its frame."""
    document, arrays = frame(reply.body)
    return _path(document, arrays["points"], _signed(arrays["faces"]), arrays["bary"])


def trace_of_frame(reply: Reply) -> Trace:
    """A straightest geodesic from its frame."""
    document, arrays = frame(reply.body)
    return Trace(
        points=arrays["points"],
        faces=_signed(arrays["faces"]),
        bary=arrays["bary"],
        length=float(document["length"]),
        end=document["end"],
        direction_at_end=np.array(document["direction_at_end"], dtype=np.float64),
        source=surface_point(document["from"]),
        target=surface_point(document["to"]),
    )


def loop_of_frame(reply: Reply) -> Loop:
    """A closed curve from its frame."""
    document, arrays = frame(reply.body)
    start = document["start"]
    asked = [document["at"]] if start == "plane" else document[start]
    return Loop(
        points=arrays["points"],
        faces=_signed(arrays["faces"]),
        bary=arrays["bary"],
        length=float(document["length"]),
        start_length=float(document["start_length"]),
        geodesic=bool(document["geodesic"]),
        turn=document["turn"],
        start=start,
        asked=tuple(surface_point(point) for point in asked),
        hull=bool(document.get("hull", False)),
        method=document.get("method"),
    )


def logmap_of_frame(reply: Reply) -> Logmap:
    """The surface round a point in the plane, from its frame."""
    document, arrays = frame(reply.body)
    return Logmap(
        vertices=arrays["vertices"].astype(np.int64),
        distances=arrays["distances"],
        angles=arrays["angles"],
        straight=arrays["straight"].astype(np.bool_),
        coordinates=arrays["coordinates"],
        angle=float(document["angle"]),
        radius=float(document["radius"]),
        total_angle=float(document["total_angle"]),
        all_round=bool(document["all_round"]),
        source=surface_point(document["from"]),
        method=document["method"],
        directions=arrays.get("directions"),
    )


def sparse_of_frame(reply: Reply) -> SparseTable:
    """A sparse table from its frame."""
    document, arrays = frame(reply.body)
    return SparseTable(
        data=arrays["data"],
        indices=arrays["indices"].astype(np.int64),
        indptr=arrays["indptr"].astype(np.int64),
        shape=(len(document["rows"]), len(document["columns"])),
    )


def labelled_of_frame(reply: Reply) -> LabelledDistances:
    """A distance field with labels from its frame."""
    _, arrays = frame(reply.body)
    return LabelledDistances(arrays["distances"], _signed(arrays["labels"]))


def geometry_of_frame(reply: Reply) -> Geometry:
    """A mesh's positions and triangles from their frame."""
    _, arrays = frame(reply.body)
    return Geometry(arrays["positions"], arrays["triangles"].astype(np.int64))


def isolines_of_json(reply: Reply) -> list[Isoline]:
    """Isolines, ascending by level."""
    return [
        Isoline(
            level=float(line["level"]),
            closed=bool(line["closed"]),
            length=float(line["length"]),
            points=np.array(line["points"], dtype=np.float64),
        )
        for line in reply.json()["isolines"]
    ]


def samples_of_json(reply: Reply) -> Samples:
    """Evenly spread vertices."""
    document = reply.json()
    samples = document["samples"]
    return Samples(
        vertices=np.array([sample["vertex"] for sample in samples], dtype=np.int64),
        points=np.array([sample["xyz"] for sample in samples], dtype=np.float64).reshape(-1, 3),
        radii=np.array([_length(sample["radius"]) for sample in samples], dtype=np.float64),
        covering_radius=_length(document["covering_radius"]),
    )


def measure_of_json(reply: Reply) -> Measure:
    """The measures of discs."""
    document = reply.json()

    def column(name: str, kind: Any) -> Any:
        return np.array([disc[name] for disc in document["discs"]], dtype=kind)

    return Measure(
        area=float(document["area"]),
        mean=float(document["mean"]),
        max=_length(document["max"]),
        farthest=document["farthest"],
        radii=column("radius", np.float64),
        areas=column("area", np.float64),
        means=column("mean", np.float64),
        perimeters=column("perimeter", np.float64),
        boundaries=column("boundary", np.float64),
        lines=column("lines", np.int64),
        vertices=column("vertices", np.int64),
        euler=column("euler", np.int64),
        whole=column("whole", np.bool_),
    )


def extent_of_json(reply: Reply) -> Extent:
    """An extent with its bounds."""
    document = reply.json()
    vertices = document["vertices"]
    return Extent(
        of=document["of"],
        value=float(document["value"]),
        lower=float(document["lower"]),
        upper=_length(document["upper"]),
        confidence=float(document["confidence"]),
        exact=bool(document["exact"]),
        vertices=np.array([vertex["vertex"] for vertex in vertices], dtype=np.int64),
        points=np.array([vertex["xyz"] for vertex in vertices], dtype=np.float64).reshape(-1, 3),
        fields=int(document["fields"]),
        part_vertices=int(document["part_vertices"]),
        means=np.array([_length(d) for d in document.get("means", ())], dtype=np.float64),
        margins=np.array([_length(d) for d in document.get("margins", ())], dtype=np.float64),
    )


def voronoi_of_json(reply: Reply) -> Voronoi:
    """Cells, bisectors and triangles."""
    document = reply.json()
    cells, pairs, triangles = document["cells"], document["neighbors"], document["triangles"]

    def column(rows: list[Any], name: str, kind: Any = np.float64) -> Any:
        return np.array([row[name] for row in rows], dtype=kind)

    nowhere = {"xyz": [math.nan] * 3}
    return Voronoi(
        sites=[surface_point(cell["site"]) for cell in cells],
        points=column([cell["site"] for cell in cells], "xyz").reshape(-1, 3),
        areas=column(cells, "area"),
        perimeters=column(cells, "perimeter"),
        boundaries=column(cells, "boundary"),
        vertices=column(cells, "vertices", np.int64),
        centroids=column([cell["centroid"] or nowhere for cell in cells], "xyz").reshape(-1, 3),
        neighbors=column(pairs, "cells", np.int64).reshape(-1, 2),
        lengths=column(pairs, "length"),
        bisectors=[
            Bisector(
                cells=(int(line["cells"][0]), int(line["cells"][1])),
                closed=bool(line["closed"]),
                length=float(line["length"]),
                points=np.array(line["points"], dtype=np.float64),
            )
            for line in document["bisectors"]
        ],
        triangles=column(triangles, "cells", np.int64).reshape(-1, 3),
        corners=column([row["point"] for row in triangles], "xyz").reshape(-1, 3),
        distances=column(triangles, "distance"),
    )


def nearest_of_json(reply: Reply) -> list[SurfacePoint]:
    """Resolved points, in the order asked."""
    return [surface_point(point) for point in reply.json()["points"]]
