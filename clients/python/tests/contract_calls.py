"""The calls of the contract's table of cases, by this client's own methods."""

from __future__ import annotations

import json
import math
from typing import Any, NamedTuple

import numpy as np

import geodesicd

QUERIES = (
    "distance", "path", "table", "isolines", "nearest", "trace", "logmap", "samples", "measure",
    "extent", "voronoi", "loop",
)  # fmt: skip


def costs_among(arguments: dict[str, Any]) -> geodesicd.Costs:
    """Takes the contract's words for costs out of a call's arguments."""
    weights = []
    for one in arguments.pop("weights", ()):
        weight, _, region = one.partition("*") if isinstance(one, str) else (one["weight"], "", "")
        weights.append((float(weight), region or one["region"]))
    names = ("face_weights", "slope", "steepest", "up", "weight_attribute")
    return geodesicd.Costs(weights, *(arguments.pop(name, None) for name in names))


class Outcome(NamedTuple):
    """What a call gave: any of these, as the call has them."""

    document: Any = None
    arrays: dict[str, Any] | None = None
    data: bytes | None = None
    media_type: str | None = None
    max: float | None = None
    headers: Any = None
    status: int | None = None
    lines: list[geodesicd.BatchReply] | None = None


class Call:
    """The calls of the table, by this client's methods."""

    def __init__(self, client: geodesicd.Client, mesh: str, data: bytes, job: bool) -> None:
        self.client = client
        self.identity = mesh
        self.data = data
        self.told: list[float] = []
        self.progress = self.told.append if job else None

    def run(self, name: str, arguments: dict[str, Any]) -> Outcome:
        """Makes a call."""
        if name in QUERIES:
            outcome = self.query(name, dict(arguments))
        else:
            outcome = getattr(self, name)(**arguments)
        if self.progress is not None:
            assert self.told[-1] == 1, "a job tells its progress to the end"
        assert isinstance(outcome, Outcome)
        return outcome

    @property
    def subject(self) -> geodesicd.Mesh:
        """The mesh without asking whether it is there: a token may not allow to."""
        known: dict[str, Any] = dict.fromkeys(geodesicd.Metadata.__annotations__, 0)
        lists: dict[str, Any] = {"parts": [], "warnings": [], "report": [], "boundaries": []}
        lists["materials"] = []
        empty = {**known, **lists, "id": self.identity, "name": None, "import": {}}
        return geodesicd.Mesh(self.client, {**empty, "bbox": {"min": [0] * 3, "max": [0] * 3}})

    def upload(self, digest: bool = True, **reading: Any) -> Outcome:
        mesh = self.client.upload(self.data, probe=digest, progress=self.progress, **reading)
        return Outcome(document=as_json(mesh))

    def list(self, limit: int = 1000) -> Outcome:
        return Outcome({"meshes": [as_json(m) for m in self.client.meshes(page_size=limit)]})

    def mesh(self) -> Outcome:
        return Outcome(as_json(self.client.mesh(self.identity)))

    def delete(self) -> Outcome:
        self.subject.delete()
        return Outcome(status=204)

    def source(self) -> Outcome:
        return Outcome(data=self.subject.source())

    def geometry(self, format: str = "frame") -> Outcome:
        if format == "glb":
            return Outcome(data=self.subject.geometry_glb())
        positions, triangles = self.subject.geometry()
        assert triangles.dtype == np.int64
        return Outcome(arrays={"positions": positions, "triangles": triangles.astype("<u4")})

    def prepare(self) -> Outcome:
        return Outcome(as_json(self.subject.prepare(progress=self.progress)))

    def methods(self) -> Outcome:
        return Outcome({"methods": self.client.methods()})

    def status(self) -> Outcome:
        return Outcome(self.client.status())

    def batch(self, lines: list[dict[str, Any]]) -> Outcome:  # type: ignore[valid-type]
        return Outcome(lines=self.subject.batch(lines, progress=self.progress))

    def request(
        self,
        method: str,
        path: str,
        headers: dict[str, str] | None = None,
        json: Any = None,
        text: str | None = None,
    ) -> Outcome:
        body = text.encode() if text is not None else None
        if json is not None:
            body = dumped(json)
        reply = self.client.fetch(method, path, headers=headers, body=body)
        document = None
        if reply.body and "json" in reply.headers.get("content-type", ""):
            document = reply.json()
        return Outcome(document, headers=reply.headers, status=reply.status)

    def query(self, name: str, arguments: dict[str, Any]) -> Outcome:
        """A query in the contract's words and, where no format is named, by the method of its
        name, too: both have to say the same."""
        chosen = arguments.pop("format", None)
        natural = "json"
        if (name == "distance" and "at" not in arguments) or name in ("table", "logmap"):
            natural = "frame"
        answer = self.subject.query(
            name, arguments, format=chosen or natural, progress=self.progress
        )
        if chosen is None and not set(arguments) & {"precision"}:
            agrees(self.natural(name, dict(arguments)), answer, name)
        return Outcome(answer.document, answer.arrays, answer.data, answer.media_type, answer.max)

    def natural(self, name: str, arguments: dict[str, Any]) -> Any:
        """What the method of that name gives."""
        mesh = self.subject
        arguments["progress"] = self.progress
        if "deadline_ms" in arguments:
            arguments["deadline"] = arguments.pop("deadline_ms") / 1000
        if set(arguments) & {"weights", "face_weights", "weight_attribute", "slope", "steepest"}:
            arguments["costs"] = costs_among(arguments)
        start = arguments.pop("from", ())
        if name == "distance" and "at" in arguments:
            arguments.pop("labels", None)
            return mesh.distance_at(start, **arguments)
        if name == "distance":
            return mesh.distance(start, **arguments)
        if name == "path":
            return mesh.path(start, arguments.pop("to"), **arguments)
        if name == "table":
            return mesh.table(start, arguments.pop("to", None), **arguments)
        if name == "samples":
            return mesh.samples(covered=start, **arguments)
        if name == "nearest":
            return mesh.nearest(arguments.pop("point"), **arguments)
        if name == "trace":
            return mesh.trace(start, **arguments)
        if name == "extent":
            return mesh.extent(arguments.pop("of"), **arguments)
        if name == "measure":
            return mesh.measure(start, **arguments)
        if name == "voronoi":
            return mesh.voronoi(start, **arguments)
        if name == "loop":
            return mesh.loop(**arguments)
        if name == "logmap":
            return mesh.logmap(start, **arguments)
        return mesh.isolines(start, **arguments)


def agrees(value: Any, answer: geodesicd.Answer, name: str) -> None:
    """Whether a method's NumPy is the contract's JSON."""
    document = answer.document or {}
    if isinstance(value, geodesicd.LabelledDistances):
        labels = answer.arrays["labels"].astype(np.int64)
        labels[labels == 0xFFFFFFFF] = -1
        np.testing.assert_array_equal(value.labels, labels)
        np.testing.assert_array_equal(value.distances, answer.arrays["distances"])
    elif isinstance(value, np.ndarray):
        told = answer.arrays.get("distances")
        if told is None:
            told = np.array([np.inf if d is None else d for d in document["distances"]])
        np.testing.assert_array_equal(value, told)
        assert value.dtype == np.float64
    elif isinstance(value, geodesicd.Path | geodesicd.Trace):
        assert len(value.points) == len(document["points"])
        for key, array in (("xyz", value.points), ("bary", value.bary)):
            assert array.shape == (len(document["points"]), 3)
            told = np.array([p[key] or [np.nan] * 3 for p in document["points"]])
            np.testing.assert_array_equal(array, told.reshape(-1, 3))
        told_faces = [-1 if p["face"] is None else p["face"] for p in document["points"]]
        assert value.faces.tolist() == told_faces
        assert value.length == (math.inf if document["length"] is None else document["length"])
        assert value.source.xyz.tolist() == document["from"]["xyz"]
        assert value.target.vertex == document["to"].get("vertex")
        if isinstance(value, geodesicd.Path):
            assert value.reachable == document["reachable"]
            assert [v.face for v in value.via] == [v["face"] for v in document["via"]]
        else:
            assert value.direction_at_end.tolist() == document["direction_at_end"]
    elif isinstance(value, geodesicd.Loop):
        assert value.points.tolist() == [p["xyz"] for p in document["points"]]
        assert value.faces.tolist() == [p["face"] for p in document["points"]]
        for key in ("length", "start_length", "geodesic", "turn", "start"):
            assert getattr(value, key) == document[key]
        assert (value.method, value.hull) == (document.get("method"), document.get("hull", False))
    elif isinstance(value, geodesicd.Logmap):
        for key in ("vertices", "distances", "angles", "straight", "coordinates"):
            np.testing.assert_array_equal(getattr(value, key), answer.arrays[key])
        if value.directions is not None:
            np.testing.assert_array_equal(value.directions, answer.arrays["directions"])
        assert (value.directions is None) == ("directions" not in answer.arrays)
        for key in ("angle", "radius", "total_angle", "all_round", "method"):
            assert getattr(value, key) == document[key]
        assert value.source.xyz.tolist() == document["from"]["xyz"]
    elif isinstance(value, geodesicd.Samples):
        assert value.vertices.tolist() == [s["vertex"] for s in document["samples"]]
        told_radii = [np.inf if s["radius"] is None else s["radius"] for s in document["samples"]]
        assert value.radii.tolist() == told_radii
    elif name == "extent":
        for key in ("of", "value", "lower", "confidence", "exact", "fields", "part_vertices"):
            assert getattr(value, key) == document[key]
        assert value.vertices.tolist() == [v["vertex"] for v in document["vertices"]]
        assert value.means.tolist() == document.get("means", [])
        assert value.margins.tolist() == document.get("margins", [])
    elif name == "voronoi":
        assert value.areas.tolist() == [cell["area"] for cell in document["cells"]]
        assert value.vertices.tolist() == [cell["vertices"] for cell in document["cells"]]
        assert value.points.tolist() == [cell["site"]["xyz"] for cell in document["cells"]]
        assert value.neighbors.tolist() == [pair["cells"] for pair in document["neighbors"]]
        assert value.lengths.tolist() == [pair["length"] for pair in document["neighbors"]]
        assert value.triangles.tolist() == [row["cells"] for row in document["triangles"]]
        assert value.corners.tolist() == [row["point"]["xyz"] for row in document["triangles"]]
        assert [line.points.tolist() for line in value.bisectors] == [
            line["points"] for line in document["bisectors"]
        ]
    elif name == "measure":
        told = document["discs"]
        assert (value.area, value.mean) == (document["area"], document["mean"])
        assert (value.max, value.farthest) == (document["max"], document["farthest"])
        for mine, its in (("radii", "radius"), ("areas", "area"), ("perimeters", "perimeter")):
            assert getattr(value, mine).tolist() == [disc[its] for disc in told]
    elif name == "isolines":
        assert len(value) == len(document["isolines"])
        for line, told in zip(value, document["isolines"], strict=True):
            assert (line.level, line.closed, line.length) == (
                told["level"], told["closed"], told["length"]
            )  # fmt: skip
            assert line.points.tolist() == told["points"]
    else:
        assert [p.xyz.tolist() for p in value] == [p["xyz"] for p in document["points"]]
        assert [p.vertex for p in value] == [p.get("vertex") for p in document["points"]]


def as_json(mesh: geodesicd.Mesh) -> dict[str, Any]:
    """A mesh's attributes as the contract's JSON has them."""
    document = {name: getattr(mesh, name) for name in geodesicd.Metadata.__annotations__}
    if mesh.name is None:
        del document["name"]
    document["bbox"] = {"min": mesh.bbox[0].tolist(), "max": mesh.bbox[1].tolist()}
    document["parts"] = [vars(part) for part in mesh.parts]
    document["materials"] = [vars(one) for one in mesh.materials]
    document["boundaries"] = [vars(loop) for loop in mesh.boundaries]
    document["warnings"] = list(mesh.warnings)
    document["import"] = document.pop("reading")
    document["report"] = [vars(finding) for finding in mesh.report]
    return document | {"unit": "mesh"}


def dumped(value: Any) -> bytes:
    """A JSON body."""
    return json.dumps(value).encode()
