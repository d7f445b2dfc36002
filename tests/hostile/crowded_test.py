#!/usr/bin/env python3
"""crowded_test.py GEODESICD [--faces N] [--every] [--only WORD]: meshes whose faces crowd on one
edge or at one vertex, through a running server.

Uploads copies of a face, books, fans, heaps of faces on few vertices, columns at powers of 0.1
and points on a line, about N faces each, and asks every kind of question about them by every
method, also from inside faces: one of each method, drawn from a seed that is printed
(GEODESICD_SEED=NUMBER sets it), or all with --every. Each is answered soon after its deadline,
if not before, and by 200, or with the limit that was met. All the while the server
keeps within the memory that its flags allow, and afterwards its slots are free.

The sizes that the server must stand are larger than a test has time for; by hand: --every with
--faces 20000, 60000, 300000 and 1000000."""

import argparse
import array
import concurrent.futures
import http.client
import json
import math
import os
import pathlib
import random
import struct
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "crash"))

from service import Service  # noqa: E402

DEADLINE = 0.3  # seconds
LATE = 2.0  # more seconds, on a machine with much else to do
CLIENTS = 2
MIB = 1 << 20
# A question that has no answer on such a surface is not refused for a limit.
NO_ANSWER = ("no_hit", "no_loop", "mesh_invalid", "outside_region")
METHODS = [
    {"method": name}
    for name in ("wavefront", "novotni", "fast_marching", "dijkstra", "exact", "chen_han", "steiner", "auto")
]
METHODS += [{"method": "auto", "bound": "upper"}, {"method": "auto", "tolerance": 0.001}]
METHODS += [{"method": "steiner", "points_per_edge": 20}]


def copies(count, height):
    """One face over and over."""
    return [(0, 0, 0), (1, 0, 0), (0.4, height, 0)], [(0, 1, 2)] * count


def book(pages, rows):
    """Pages of so many rows of two faces each, on one edge."""
    points, faces = [(0, 0, 0), (0, 1, 0)], []
    for page in range(pages // (2 * rows)):
        turn = 2 * math.pi * page / (pages / (2 * rows))
        low, high = 0, 1
        for row in range(1, rows + 1):
            at = len(points)
            points += [(row * math.cos(turn), y, row * math.sin(turn)) for y in (0, 1)]
            faces += [(low, at, high), (at, at + 1, high)]
            low, high = at, at + 1
    return points, faces


def pages_of_one_face(count):
    """A book of triangles."""
    return [(0, 0, 0), (0, 1, 0)] + [
        (math.cos(6.28 * i / count), 0.1 * (i % 11), math.sin(6.28 * i / count)) for i in range(count)
    ], [(0, 1, i + 2) for i in range(count)]


def fan(count, height):
    """A disc or a cone of faces round vertex 0."""
    turns = [2 * math.pi * i / count for i in range(count)]
    points = [(0, 0, height), *((math.cos(t), math.sin(t), 0) for t in turns)]
    return points, [(0, 1 + i, 1 + (i + 1) % count) for i in range(count)]


def folded_fan(count, leaf):
    """Faces round vertex 0 that go to and fro, so many in a leaf."""
    points = [(0, 0, 0)]
    for i in range(count + 1):
        turn = abs((i % (2 * leaf)) - leaf) / leaf
        points.append((math.cos(turn), math.sin(turn), 1e-3 * i / count))
    return points, [(0, 1 + i, 2 + i) for i in range(count)]


def spindle(count):
    """Faces that all have one of two vertices."""
    points, faces = fan(count // 2, 1)
    faces += [(len(points), b, a) for _, a, b in faces]
    return [*points, (0, 0, -1)], faces


def heap(chance, count):
    """Faces thrown together on few vertices: crowded everywhere."""
    points = [tuple(chance.uniform(-1, 1) for _ in range(3)) for _ in range(12)]
    return points, [tuple(chance.sample(range(12), 3)) for _ in range(count)]


def columns(count):
    """A grid whose columns come closer together by 0.1."""
    across = 30
    down = max(count // (2 * across), 1)
    points = [(0.1**i, j / down, 0) for j in range(down + 1) for i in range(across + 1)]
    return points, grid_faces(across, down)


def grid_faces(across, down):
    """Two faces in each square."""
    faces = []
    for j in range(down):
        for i in range(across):
            a = j * (across + 1) + i
            faces += [(a, a + 1, a + across + 2), (a, a + across + 2, a + across + 1)]
    return faces


def line(chance, count):
    """Faces without area."""
    vertices = count // 2
    points = [(x, 2 * x, 3 * x) for x in (chance.random() for _ in range(vertices))]
    return points, [tuple(chance.sample(range(vertices), 3)) for _ in range(count)]


def meshes(chance, count):
    """By name."""
    thin = 10 ** chance.uniform(-12, -3)
    rows = chance.randint(2, 6)
    leaf = chance.randint(1, 50)
    return {
        "copies": copies(count, 0.7),
        f"copies {thin:.1e} thin": copies(count, thin),
        f"a book of {rows} rows": book(count, rows),
        "a book of triangles": pages_of_one_face(count),
        "a fan": fan(count, 0),
        "a cone": fan(count, 1),
        f"a fan in leaves of {leaf}": folded_fan(count, leaf),
        "a spindle": spindle(count),
        "a heap": heap(chance, count),
        "columns at powers of 0.1": columns(count),
        "a line": line(chance, count),
    }


def shuffled(chance, mesh):
    """Its faces in any order and turned any way."""
    points, faces = mesh
    faces = [face if chance.random() < 0.5 else face[1:] + face[:1] for face in faces]
    faces = [face if chance.random() < 0.9 else face[::-1] for face in faces]
    chance.shuffle(faces)
    return points, faces


def packed(mesh):
    """As .glb, in single precision."""
    points, faces = mesh
    positions = array.array("f", (x for point in points for x in point)).tobytes()
    indices = array.array("I", (corner for face in faces for corner in face)).tobytes()
    gltf = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3",
             "min": [min(p[i] for p in points) for i in range(3)],
             "max": [max(p[i] for p in points) for i in range(3)]},
            {"bufferView": 1, "componentType": 5125, "count": 3 * len(faces), "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": len(positions)},
            {"buffer": 0, "byteOffset": len(positions), "byteLength": len(indices)},
        ],
        "buffers": [{"byteLength": len(positions) + len(indices)}],
    }  # fmt: skip
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(positions) + len(indices))
    head += struct.pack("<I4s", len(text), b"JSON") + text
    return head + struct.pack("<I4s", len(positions) + len(indices), b"BIN\0") + positions + indices


def places(chance, vertices, faces):
    """Vertices, the crowded ones among them, and points inside faces and on their edges."""
    inside = [f"f:{chance.randrange(faces)},{w}" for w in ("0.3,0.3", "0.5,0.5", "1e-9,0.5")]
    return ["v:0", "v:1", f"v:{vertices - 1}", f"v:{chance.randrange(vertices)}", *inside]


def on_sides(chance, faces):
    """Many points, perhaps on one edge."""
    found = []
    for _ in range(100):
        part = chance.random()
        weights = chance.choice([(0, part), (part, 0), (0.5, 0.5)])
        found.append(f"f:{chance.randrange(faces)},{weights[0]:.3g},{weights[1]:.3g}")
    return found


def questions(chance, vertices, faces, method):
    """(query, parameters), shuffled, of one method."""
    found = []
    spots = places(chance, vertices, faces)
    for i, spot in enumerate(spots):
        other = spots[(i + chance.randrange(1, len(spots))) % len(spots)]
        found.append(("distance", {"from": spot}))
        found.append(("distance", {"from": spot, "at": [other, spots[0]]}))
        found.append(("path", {"from": spot, "to": other}))
        found.append(("path", {"from": spot, "to": other, "refine": "none"}))
        found.append(("isolines", {"from": spot, "count": 7}))
    found.append(("distance", {"from": [spots[0], spots[-2]], "labels": 1}))
    found.append(("path", {"from": spots[2], "to": spots[4], "refine": "shortest"}))
    found.append(("table", {"from": spots[-3:], "to": spots}))
    found.append(("samples", {"count": 5}))
    many = on_sides(chance, faces)
    found.append(("table", {"from": spots[0], "to": many}))
    found.append(("table", {"from": spots[-3:], "to": many, "stream": 1}))
    found.append(("table", {"from": many[:200], "to": spots, "max": 0.5, "sparse": 1}))
    found.append(("distance", {"from": spots[1], "at": many}))
    found.append(("distance", {"from": many, "at": spots, "labels": 1}))
    found.append(("measure", {"from": spots[1], "radii": [0.1, 0.5, 1]}))
    found.append(("extent", {"of": "diameter", "fields": 4}))
    found.append(("voronoi", {"from": spots, "relax": 1}))
    if method.get("method") not in ("wavefront", "novotni"):  # of points alone
        found.append(("distance", {"from": "faces:0-7"}))
        found.append(("distance", {"from": f"curve:{spots[0]};{spots[-1]}", "at": spots}))
        found.append(("path", {"from": "faces:1", "to": spots[-2]}))
    found.append(("path", {"from": spots[1], "to": spots[0], "forbid": "faces:0"}))
    found.append(("distance", {"from": spots[1], "at": spots[:1], "walls": ";".join(spots[:2])}))
    found.append(("samples", {"count": 2, "forbid": "inside:" + ";".join(spots[:3])}))
    if method.get("method") == "steiner":  # the only one that knows costs
        found.append(("path", {"from": spots[1], "to": spots[0], "weights": "3*faces:0", "slope": "tobler"}))
    found.append(("logmap", {"from": spots[0], "radius": 0.5}))
    found.append(("logmap", {"from": spots[1], "transport": 1}))
    found.append(("loop", {"through": spots[:4]}))
    found.append(("loop", {"around": spots[-4:]}))
    chance.shuffle(found)
    # Paths have no tolerance.
    return [(query, {**method, **asked}) for query, asked in found
            if query not in ("path", "loop", "logmap") or "tolerance" not in method]  # fmt: skip


def plain_questions(chance, vertices, faces):
    """Those that have no method."""
    spots = places(chance, vertices, faces)
    rays = [f"ray:{chance.uniform(-1, 1):.3f},{chance.uniform(-1, 1):.3f},9,0.01,0,-1" for _ in range(50)]
    far = ["p:" + ",".join(f"{chance.uniform(-9, 9):.3f}" for _ in range(3)) for _ in range(200)]
    many = on_sides(chance, faces)
    found = [("table", {"from": "v:0", "to": many, "deadline_ms": ms}) for ms in (1, 2, 5, 10, 20)]
    found += [("nearest", {"point": many}), ("nearest", {"point": rays}), ("nearest", {"point": [*far, *spots, "p:1e9,0,0"]})]
    for spot in spots:
        found.append(("trace", {"from": spot, "angle": f"{chance.uniform(-7, 7):.6f}", "length": 10}))
        found.append(("trace", {"from": spot, "direction": "-1,0.01,0", "length": 1000}))
        found.append(("loop", {"at": spot, "normal": "0.3,0.01,1"}))
        found.append(("loop", {"at": spot, "normal": "1,0.2,0.1", "hull": 1}))
    return found


class Crowd:
    """A server, and what it does not do as it must."""

    def __init__(self, service, seed, every):
        self.service = service
        self.seed = seed
        self.every = every
        self.faults = []
        self.by_status = {}
        self.slowest = (0.0, "")

    def ask(self, mesh, what, query, asked):
        """One question, judged by when and how it is answered."""
        asked = {"deadline_ms": round(1000 * DEADLINE), **asked}
        parts = [(key, one) for key, value in asked.items() for one in (value if isinstance(value, list) else [value])]
        target = f"/v1/meshes/{mesh}/{query}?" + "&".join(f"{key}={value}" for key, value in parts)
        name = f"{what}: {query} {target.split('?')[1][:200]}"
        begun = time.monotonic()
        try:
            status, _, body = self.service.ask("GET", target)
        except (OSError, http.client.HTTPException) as error:
            # Rows that are streamed are broken off by their deadline.
            if "stream" in asked and isinstance(error, http.client.IncompleteRead):
                took = time.monotonic() - begun
                if DEADLINE <= took <= DEADLINE + LATE:
                    return
            self.faults.append(f"{name}: {error!r}")
            return
        took = time.monotonic() - begun
        self.by_status[status] = self.by_status.get(status, 0) + 1
        self.slowest = max(self.slowest, (took, name))
        if took > DEADLINE + LATE:
            self.faults.append(f"{name}: {status} after {took:.1f} s")
        if status == 200:
            return
        problem = json.loads(body)
        # Lines need not divide such surfaces.
        may_have_none = query in ("trace", "logmap") or "no inside" in problem["detail"]
        no_such_way = may_have_none and problem["code"] == "value_out_of_range"
        if status == 422 and (no_such_way or problem["code"] in NO_ANSWER):
            return
        # Clients that ask at once are in each other's way, and all come from one address.
        limits = {413: ("too_large",), 422: ("too_much_memory", "value_out_of_range"),
                  429: ("too_many_requests",), 503: ("overloaded",), 504: ("deadline",)}  # fmt: skip
        if problem["code"] not in limits.get(status, ()) or (status < 500 and "limit" not in problem):
            self.faults.append(f"{name}: {status} {problem['code']}: {problem['detail']}")
        elif not problem["detail"]:
            self.faults.append(f"{name}: {status} without a reason")

    def storm(self, what, mesh, data):
        """Uploads a mesh and asks about it."""
        chance = random.Random(f"{self.seed} {what}")
        status, _, body = self.service.ask("POST", "/v1/meshes", data, timeout=300)
        if status != 201:
            self.faults.append(f"{what}: uploaded, {status} {body[:300]!r}")
            return
        name = json.loads(body)["id"]
        vertices, faces = len(mesh[0]), len(mesh[1])
        asked = plain_questions(chance, vertices, faces)
        for method in METHODS:
            drawn = questions(chance, vertices, faces, method)
            asked += drawn if self.every else drawn[:3]
        with concurrent.futures.ThreadPoolExecutor(CLIENTS) as pool:
            list(pool.map(lambda one: self.ask(name, what, *one), asked))
        self.check_it_is_free(what)
        self.service.ask("DELETE", f"/v1/meshes/{name}")

    def metric(self, name):
        """The value of a metric without labels."""
        text = self.service.ask("GET", "/metrics")[2].decode()
        return float(next(row for row in text.splitlines() if row.startswith(name + " ")).split()[1])

    def check_it_is_free(self, what):
        """The slots are: nothing runs on, and a small question is answered at once."""
        if self.metric("geodesicd_compute_unanswering") != 0:
            self.faults.append(f"{what}: a computation runs on")
        triangle = packed(([(0, 0, 0), (3, 0, 0), (0, 4, random.random())], [(0, 1, 2)]))
        mesh = json.loads(self.service.ask("POST", "/v1/meshes", triangle)[2])["id"]
        for _ in range(2 * CLIENTS):
            status, _, body = self.service.ask("GET", f"/v1/meshes/{mesh}/path?from=v:0&to=v:1&deadline_ms=1000")
            if status != 200:
                self.faults.append(f"{what}: a small question after it is answered {status} {body[:300]!r}")

    def most_memory(self):
        """Of the server so far, in bytes."""
        status = pathlib.Path(f"/proc/{self.service.process.pid}/status").read_text(encoding="utf-8")
        return 1024 * int(next(row for row in status.splitlines() if row.startswith("VmHWM")).split()[1])


def budgets(faces):
    """The flags that bound memory, in bytes: small ones for a small test, so that they matter."""
    unit = MIB * max(faces // 8000, 4)
    return {
        "query-memory-bytes": 16 * unit, "compute-memory-bytes": 32 * unit, "mesh-cache-bytes": 2 * unit,
        "adjacency-cache-bytes": 8 * unit, "field-cache-bytes": 4 * unit, "reply-cache-bytes": 2 * unit,
        "reply-memory-bytes": max(4 * unit, 64 * MIB),
    }  # fmt: skip


def main():
    """Prints what came of it; exit status 1 if anything is not as it must be."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--faces", type=int, default=6000)
    parser.add_argument("--every", action="store_true", help="ask all questions, not some by each method")
    parser.add_argument("--only", default="", help="only meshes with this word in their names")
    options = parser.parse_args()
    seed = int(os.environ.get("GEODESICD_SEED", random.randrange(1 << 32)))
    print(f"GEODESICD_SEED={seed}", flush=True)
    chance = random.Random(seed)
    flags = budgets(options.faces)
    words = [word for flag, value in flags.items() for word in (f"--{flag}", str(value))]
    words += ["--compute-threads", str(CLIENTS), "--log-level", "warn"]
    with tempfile.TemporaryDirectory(prefix="crowded_") as folder:
        folder = pathlib.Path(folder)
        service = Service(options.program, ["--store", str(folder / "store"), *words], folder / "log")
        crowd = Crowd(service, seed, options.every)
        count = options.faces - chance.randrange(options.faces // 4)
        for what, mesh in meshes(chance, count).items():
            if options.only not in what:
                continue
            mesh = shuffled(chance, mesh)
            begun = time.monotonic()
            crowd.storm(what, mesh, packed(mesh))
            print(f"{what}, {len(mesh[1])} faces: {time.monotonic() - begun:.1f} s, "
                  f"memory at most {crowd.most_memory() / MIB:.0f} MiB", flush=True)  # fmt: skip
        unanswered = crowd.metric("geodesicd_compute_unanswered_total")
        memory = crowd.most_memory()
        stopped = service.stop()
        log = (folder / "log").read_text(encoding="utf-8", errors="replace")
    print(f"by status {crowd.by_status}, slowest {crowd.slowest[0]:.2f} s: {crowd.slowest[1]}")
    if unanswered:
        crowd.faults.append(f"{unanswered:.0f} computations ran on for a second after their deadline")
    # The program, uploads and what the allocator keeps.
    allowed = sum(flags.values()) + 256 * MIB
    if memory > allowed:
        crowd.faults.append(f"{memory / MIB:.0f} MiB of memory, where {allowed / MIB:.0f} are allowed")
    if stopped != 0:
        crowd.faults.append(f"the server ended with status {stopped}")
    for fault in crowd.faults[:40]:
        print("FAILED:", fault)
    if crowd.faults:
        print(log[-3000:])
    sys.exit(1 if crowd.faults else 0)


if __name__ == "__main__":
    main()
