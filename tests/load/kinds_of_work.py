"""Work that a client may hang up on: uploads and every query, each in those forms whose code
differs. A question is asked once: each turn has places and lengths of its own."""

import json
import pathlib
import random
import sys
from functools import partial

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

from decoder_overhead import grid  # noqa: E402
from torture_meshes import obj, torus  # noqa: E402

CURVE = "curve:{a};{b};{c};{d}"
CLOSED = "curve:closed;{a};{b};{c};{d}"
WALLS = "walls={a};{c}&walls={b};{e}"
SITES = "from={a}&from={b}&from={c}&from={d}&from={e}"
UPHILL = "slope=tobler&up=0,0,1"
ROUND_TUBE = "at={ring}&normal=0.{n},0.2,1"

# On the large terrain: name, query, its parameters.
LARGE = [
    *(
        (name, "distance", "from={a}&format=f32&method=" + name)
        for name in ("dijkstra", "wavefront", "auto", "novotni", "fast_marching", "steiner")
    ),
    ("exact", "distance", "from={e}&format=f32&method=exact&max={long}"),
    ("chen_han", "distance", "from={e}&format=f32&method=chen_han&max={long}"),
    ("tolerance", "distance", "from={a}&format=f32&tolerance=0.01"),
    ("JSON", "distance", "from={a}&from={c}&labels=1&method=dijkstra"),
    ("frame", "distance", "from={a}&from={c}&labels=1&method=dijkstra&format=frame"),
    ("GLB", "distance", "from={a}&method=dijkstra&format=glb"),
    ("picture", "distance", "from={a}&method=dijkstra&format=png"),
    ("annotated", "distance", "from={a}&from={c}&labels=1&method=dijkstra&format=annotated"),
    ("along a curve", "distance", "from=" + CURVE + "&format=f32&method=dijkstra"),
    ("along faces", "distance", "from=faces:{faces}&format=f32&method=dijkstra"),
    ("forbidden ball", "distance", "from={a}&forbid=sphere:{x},{y},0,{long}&format=f32"),
    ("weights", "distance", "from={a}&points_per_edge=1&weights=3*faces:{faces}&format=f32"),
    ("slope", "distance", "from={a}&points_per_edge=1&format=f32&" + UPHILL),
    ("path", "path", "from={a}&to={c}"),
    ("path, exact", "path", "from={e}&to={near}&method=exact"),
    ("path, refined", "path", "from={a}&to={c}&method=dijkstra&refine=shortest"),
    ("path past a ball", "path", "from={a}&to={c}&forbid=sphere:{x},{y},0,{long}"),
    ("path within", "path", "from={e}&to={near}&within=inside:{a};{b};{c};{d}"),
    ("path by cost", "path", "from={e}&to={near}&weights=3*faces:{faces}&" + UPHILL),
    ("isolines", "isolines", "from={a}&count=50"),
    ("isolines, GLB", "isolines", "from={a}&method=dijkstra&count=50&format=glb"),
    ("measure", "measure", "from={a}&method=dijkstra&radii={short}&radii={long}"),
    ("strips", "measure", "from={a}&method=dijkstra&radii={short}&radii={long}&format=glb"),
    ("voronoi", "voronoi", "method=dijkstra&" + SITES),
    ("cells, GLB", "voronoi", "method=dijkstra&format=glb&" + SITES),
    ("samples", "samples", "count=4&from={a}&method=dijkstra"),
]

# On a terrain of half the side: slow queries.
MIDDLE = [
    ("walls", "distance", "from={d}&format=f32&method=dijkstra&" + WALLS),
    ("inside a line", "distance", "from={e}&within=inside:{a};{b};{c};{d}&format=f32"),
    ("from the boundary", "distance", "from=boundary&from={e}&format=f32"),
    ("signed, dijkstra", "distance", "from=" + CLOSED + "&signed=1&format=f32&method=dijkstra"),
    ("path round walls", "path", "from={d}&to={b}&" + WALLS),
    ("logmap", "logmap", "from={e}&radius={short}"),
    ("logmap, carried", "logmap", "from={e}&radius={short}&transport=1"),
    ("logmap, GLB", "logmap", "from={e}&radius={short}&format=glb"),
    ("logmap, annotated", "logmap", "from={e}&radius={short}&format=annotated"),
    ("from a curve", "distance", "from=" + CURVE + "&format=f32"),
    ("from faces", "distance", "from=faces:{faces}&format=f32"),
    ("signed", "distance", "from=" + CLOSED + "&signed=1&format=f32"),
]

# On a terrain of a quarter of it: queries that compute many fields, among others.
SMALL = [
    ("from a curve, exact", "distance", "from=" + CURVE + "&format=f32&method=exact"),
    ("from a curve, chen_han", "distance", "from=" + CURVE + "&format=f32&method=chen_han"),
    ("from the boundary, exact", "distance", "from=boundary&from={e}&format=f32&method=exact"),
    ("signed, exact", "distance", "from=" + CLOSED + "&signed=1&format=f32&method=exact"),
    ("loop through", "loop", "through={a}&through={b}&through={c}&method=exact"),
    ("voronoi, exact", "voronoi", "method=exact&" + SITES),
    ("bisectors", "voronoi", "part=bisectors&" + SITES),
    ("voronoi, relaxed", "voronoi", "relax=4&" + SITES),
    ("voronoi of lines", "voronoi", "from=curve:{a};{e}&from=faces:{faces}&from={c}"),
    *(
        ("extent, " + of, "extent", "method=exact&fields={n}&of=" + of)
        for of in ("diameter", "center", "median", "mean", "means")
    ),
    ("samples, exact", "samples", "count={n}&from={a}&method=exact"),
    ("table", "table", "method=exact&" + SITES),
    ("table of lines", "table", "from=" + CURVE + "&from=faces:{faces}&from={e}&to=" + CLOSED),
]

# On a tube that closes: loops are held there, and ways have no end.
TUBE = [
    ("trace", "trace", "from={ring}&direction=0.{n},0.3,1&length=1{n}0"),
    ("loop around", "loop", "around={ring}&around={second}&around={third}"),
    ("loop of a plane", "loop", ROUND_TUBE),
    ("loop of a long plane", "loop", "at={ring}&normal=0,1,0.0{n}"),
    ("tape", "loop", ROUND_TUBE + "&hull=1"),
]

# Tables of the small terrain, and the number of their points.
TABLES = [
    ("table, streamed", {"stream": True, "format": "npy"}, 50),
    ("table, lines of JSON", {"stream": True, "method": "exact"}, 10),
    ("table, sparse", {"sparse": True, "format": "npz", "max": 30}, 300),
    ("table, estimated", {"stream": True, "format": "npy", "landmarks": 20}, 200),
]


def places(name, side, turn):
    """What stands in a question of that turn: a to d go round e, all about the middle."""
    chance = random.Random(f"{name} {turn}")

    def vertex(across, along):
        at = [round(side * (share + chance.uniform(-0.08, 0.08))) for share in (across, along)]
        return f"v:{at[1] * side + at[0]}"

    first = chance.randrange(side * side)
    return {
        "a": vertex(0.25, 0.25),
        "b": vertex(0.75, 0.25),
        "c": vertex(0.75, 0.75),
        "d": vertex(0.25, 0.75),
        "e": vertex(0.5, 0.5),
        "near": vertex(0.55, 0.6),
        "faces": f"{first}-{first + side * side // 10}",
        "x": side * chance.uniform(0.45, 0.55),
        "y": side * chance.uniform(0.45, 0.55),
        "short": side * chance.uniform(0.06, 0.07),
        "long": side * chance.uniform(0.15, 0.2),
        "n": 11 + turn,
    }


def on_tube(rings, sides, turn):
    """The same on a tube: points on three places of it, as far from each other."""
    at = (turn + 2) % (rings // 20)
    thirds = [f"v:{(at + part * rings // 3) * sides + 7 * turn % sides}" for part in range(3)]
    return {"ring": thirds[0], "second": thirds[1], "third": thirds[2], "n": 11 + turn}


def kinds_of_work(upload, side):
    """Name, and what to ask for in a turn: method, target, body. `upload` stores a file and
    returns its mesh's id."""
    small = side // 4

    def uploaded(query):
        return lambda turn: ("POST", "/v1/meshes" + query, grid(side, 0.06 + 1e-4 * turn))

    def asked(mesh, what, query, shape):
        target = f"/v1/meshes/{mesh}/{what}?{query}"
        return lambda turn: ("GET", target.format_map(shape(turn)), None)

    def asked_of_many(mesh, what, body_of):
        return lambda turn: ("POST", f"/v1/meshes/{mesh}/{what}", body_of(random.Random(str(turn))))

    def table(asking, count):
        return lambda chance: json.dumps(
            {"from": [f"v:{chance.randrange(small**2)}" for _ in range(count)]} | asking
        )

    def batch(chance):
        ends = [[f"v:{chance.randrange(small**2)}" for _ in "ab"] for _ in range(100)]
        return "\n".join(json.dumps({"query": "path", "from": a, "to": b}) for a, b in ends)

    def in_space(chance):
        spots = [[small * chance.random() for _ in "xyz"] for _ in range(20000)]
        return json.dumps({"point": [{"xyz": spot} for spot in spots]})

    yield "upload", uploaded("?up=z")
    yield "upload, welded within", uploaded("?weld=0.01")
    small_mesh = upload(grid(small, 0.05))
    large_mesh, middle_mesh = (upload(grid(width, 0.05)) for width in (side, side // 2))
    for mesh, width, kinds in (
        (large_mesh, side, LARGE),
        (middle_mesh, side // 2, MIDDLE),
        (small_mesh, small, SMALL),
    ):
        for name, what, query in kinds:
            yield name, asked(mesh, what, query, partial(places, name, width))
    for name, asking, count in TABLES:
        yield name, asked_of_many(small_mesh, "table", table(asking, count))
    yield "batch", asked_of_many(small_mesh, "batch", batch)
    yield "nearest", asked_of_many(small_mesh, "nearest", in_space)
    mesh = upload(obj(torus(side, small, 0.3), "tube"))
    for name, what, query in TUBE:
        yield name, asked(mesh, what, query, partial(on_tube, side, small))
