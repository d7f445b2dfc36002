"""Questions about a mesh at random, and when two answers to one are the same."""

import collections
import json
import math
import struct
import urllib.parse

# method, target behind the mesh, body, format, seconds of its deadline
Question = collections.namedtuple("Question", "method target body format deadline")

METHODS = ["wavefront", "novotni", "fast_marching", "dijkstra", "steiner", "exact", "chen_han", "auto"]
# Milliseconds. On meshes as small as these an answer that takes longer is not worth waiting
# for; nor can work then pile up.
DEADLINE = 5000
# How far apart two answers under weak tags may be, in parts of the greatest of their
# numbers: they are the same field by the same method, read in single or double precision.
WEAK = 2e-6

# Errors that depend on what else goes on; any other must be the quiet server's answer too.
OF_THE_MOMENT = {"mesh_unknown", "job_unknown", "job_unfinished", "job_cancelled", "cancelled",
                 "request_timeout", "too_many_requests", "overloaded", "store_unavailable", "deadline",
                 "too_much_memory"}

def point_of(chance, mesh):
    """A point, as text."""
    kind = chance.random()
    points, faces = mesh.shape
    if kind < 0.7:
        return f"v:{chance.randrange(mesh.vertices)}"
    if kind < 0.85:
        a, b = sorted((chance.random(), chance.random()))
        weights = chance.choice([(a, b - a), (0.5, 0.5), (0.25, 0), (1e-9, 0.5), (1, 0)])
        return f"f:{chance.randrange(mesh.faces)},{weights[0]:.9g},{weights[1]:.9g}"
    near = points[chance.choice(faces[chance.randrange(mesh.faces)])]
    if kind < 0.95:
        far = chance.choice([0, 1e-3, 1, 1e3])
        size = max(abs(x) for x in near) or 1
        return "p:" + ",".join(f"{x + far * size * chance.uniform(-1, 1):.7g}" for x in near)
    if kind < 0.98:
        return "ray:" + ",".join(f"{x:.7g}" for x in (*near[:2], near[2] + 9, 0, 0, -1))
    return chance.choice([f"v:{mesh.vertices + 7}", f"f:{mesh.faces},0.1,0.1", "p:1,2", "v:-1", "x"])


def method_of(chance):
    """A method with its parameters."""
    method = chance.choice(METHODS)
    asked = {"method": method}
    if method == "steiner" and chance.random() < 0.7:
        asked["points_per_edge"] = chance.choice([1, 2, 5])
    if method == "auto":
        asked |= chance.choice([{}, {}, {"bound": "upper"}, {"tolerance": 0.001},
                                {"tolerance": 0.1}, {"tolerance": 0}])
    return {} if chance.random() < 0.1 else asked


def some(chance, mesh, most):
    """Several points."""
    return [point_of(chance, mesh) for _ in range(chance.randint(1, most))]


def size_of(mesh):
    """About how large a mesh is."""
    return max(max(abs(x) for x in point) for point in mesh.shape[0]) or 1.0


def parameters_of(chance, mesh, query):
    """The parameters of one kind of question, and the formats that it has."""
    size = size_of(mesh)
    if query == "nearest":
        return {"point": some(chance, mesh, 6)}, ["json"]
    if query == "trace":
        asked = {"from": point_of(chance, mesh), "length": size * 10 ** chance.uniform(-3, 1)}
        if chance.random() < 0.5:
            asked["angle"] = chance.uniform(-7, 7)
        else:
            asked["direction"] = ",".join(f"{chance.uniform(-1, 1):.4g}" for _ in range(3))
        return asked, ["json", "json", "json", "f64", "glb"]
    if query == "loop" and chance.random() < 0.5:
        asked = {"at": point_of(chance, mesh)}
        asked["normal"] = ",".join(f"{chance.uniform(-1, 1):.4g}" for _ in range(3))
        if chance.random() < 0.5:
            asked["hull"] = 1
        return asked, ["json", "json", "frame", "glb"]
    asked = method_of(chance)
    if query == "loop":
        asked.pop("tolerance", None)
        asked[chance.choice(["through", "around"])] = [point_of(chance, mesh) for _ in range(3)]
        return asked, ["json", "json", "f64", "glb"]
    if query == "path":
        asked |= {"from": point_of(chance, mesh), "to": point_of(chance, mesh)}
        asked.pop("tolerance", None)
        if chance.random() < 0.2:
            asked["via"] = some(chance, mesh, 2)
        if chance.random() < 0.4:
            asked["refine"] = "shortest"
        return asked, ["json", "json", "json", "f32", "f64", "glb"]
    if query == "logmap":
        asked |= {"from": point_of(chance, mesh), "radius": size * 10 ** chance.uniform(-2, 0)}
        asked.pop("tolerance", None)
        if chance.random() < 0.3:
            asked["angle"] = chance.uniform(-7, 7)
        if chance.random() < 0.3:
            asked["transport"] = 1
        return asked, ["json", "frame", "glb"]
    if query == "measure":
        asked["from"] = some(chance, mesh, 3)
        asked["radii"] = [size * 10 ** chance.uniform(-2, 0) for _ in range(chance.choice([0, 1, 5]))]
        return asked, ["json", "json", "glb"]
    if query == "extent":
        asked |= {"of": chance.choice(["diameter", "center", "median", "mean", "means"])}
        asked["fields"] = chance.choice([1, 3, 8])
        return asked, ["json", "frame", "npy", "glb"] if asked["of"] == "means" else ["json"]
    if query == "voronoi":
        asked["from"] = some(chance, mesh, chance.choice([1, 2, 5, 12]))
        if chance.random() < 0.3:
            asked["relax"] = chance.choice([1, 3])
        return asked, ["json", "json", "glb", "png"]
    if query == "samples":
        asked["count"] = chance.choice([1, 3, 10])
        if chance.random() < 0.3:
            asked["from"] = some(chance, mesh, 2)
        return asked, ["json"]
    asked["from"] = some(chance, mesh, 3 if chance.random() < 0.5 else 1)
    if chance.random() < 0.15:
        asked["max"] = size * chance.random()
    if query == "distance":
        if chance.random() < 0.5:
            asked["at"] = some(chance, mesh, 4)
        if chance.random() < 0.15:
            asked["labels"] = 1
        if chance.random() < 0.1:
            asked["signed"] = 1
            if chance.random() < 0.8:  # what a sign is for
                asked["from"] = "curve:closed;" + ";".join(point_of(chance, mesh) for _ in range(3))
        formats = ["json", "f32", "f64", "npy", "frame", "u16"]
        return asked, formats if "at" in asked else formats + ["png", "glb", "annotated"]
    if query == "table":
        asked["from"] = some(chance, mesh, 4)
        if chance.random() < 0.7:
            asked["to"] = some(chance, mesh, 4)
        if chance.random() < 0.3:
            asked["rows"] = chance.choice(["0-", "0-0", "1-", "3-2"])
        if chance.random() < 0.3:
            asked["stream"] = 1
            return asked, ["ndjson", "f32", "f64", "npy"]
        if chance.random() < 0.2:
            asked["sparse"] = 1
            return asked, ["json", "frame", "npz"]
        return asked, ["json", "f32", "f64", "npy"]
    asked["count"] = chance.choice([1, 4, 9])
    if chance.random() < 0.3:
        del asked["count"]
        asked["levels"] = [size * chance.random(), size * chance.random()]
    return asked, ["json", "json", "glb"]


def region_of(chance, mesh):
    """A region, as text: some that are everything, and some that are none."""
    points, faces = mesh.shape
    kind = chance.random()
    if kind < 0.4:
        first = chance.randrange(mesh.faces)
        return f"faces:{first}-{chance.randrange(first, mesh.faces)},{chance.randrange(mesh.faces)}"
    near = points[chance.choice(faces[chance.randrange(mesh.faces)])]
    size = size_of(mesh) * 10 ** chance.uniform(-2, 0)
    if kind < 0.7:
        return "sphere:" + ",".join(f"{x:.7g}" for x in (*near, size))
    if kind < 0.9:
        return "box:" + ",".join(f"{x:.7g}" for x in (*(x - size for x in near), *(x + size for x in near)))
    named = ["part:0", "part:99999", "part:nobody", "material:none", "material:0", "material:glass"]
    return chance.choice([*named, f"faces:{mesh.faces}", "sphere:0,0,0,-1", "box:1,2"])


def line_of(chance, mesh, count):
    """Points of a wall, or round an inside, as text; some that are nowhere."""
    points, faces = mesh.shape
    spots = []
    for _ in range(count):
        kind = chance.random()
        if kind < 0.4:
            spots.append(f"v:{chance.choice(faces[chance.randrange(mesh.faces)])}")
        elif kind < 0.7:
            spots.append(f"f:{chance.randrange(mesh.faces)},0.2,{chance.choice([0, 0.3, 0.8])}")
        elif kind < 0.98:
            spots.append("p:" + ",".join(f"{x:.7g}" for x in chance.choice(points)))
        else:
            spots.append(f"v:{len(points)}")
    return ";".join(spots)


def lines_of(chance, mesh):
    """What a field may start from that is no point, as text."""
    kind = chance.random()
    if kind < 0.3:
        return chance.choice(["boundary", "boundary", "boundary:0", "boundary:3", "boundary:x"])
    if kind < 0.5:
        return region_of(chance, mesh)
    points = [point_of(chance, mesh) for _ in range(chance.choice([1, 2, 2, 3, 5]))]
    return "curve:" + ";".join(chance.choice([[], ["closed"]]) + points)


def part_of(chance, mesh):
    """Parameters that keep a query to a part of the surface; mostly none."""
    asked = {}
    if chance.random() < 0.1:
        asked["within"] = [region_of(chance, mesh) for _ in range(chance.choice([1, 1, 3]))]
    if chance.random() < 0.15:
        asked["forbid"] = [region_of(chance, mesh) for _ in range(chance.choice([1, 1, 3]))]
    if chance.random() < 0.05:
        asked[chance.choice(["within", "forbid"])] = "inside:" + line_of(chance, mesh, 3)
    if chance.random() < 0.1:
        asked["walls"] = [line_of(chance, mesh, chance.choice([2, 2, 4])) for _ in range(chance.choice([1, 1, 3]))]
    return asked


def costs_of(chance, mesh, query, asked):
    """Parameters of cheap ways; mostly none."""
    if query not in ("distance", "path", "table", "isolines") or chance.random() > 0.1:
        return {}
    if asked.get("method", "steiner") != "steiner":
        return {}
    costs = {}
    if chance.random() < 0.6:
        costs["weights"] = [
            f"{10 ** chance.uniform(-2, 2):.4g}*{region_of(chance, mesh)}" for _ in range(chance.choice([1, 3]))
        ]
    if chance.random() < 0.4:
        costs["weight_attribute"] = chance.choice(["_MUD", "_MUD", "_MUD", "_SNOW"])
    if chance.random() < 0.6:
        costs["slope"] = chance.choice(["tobler", "-1:2,0:1,0.5:9", "0:0", "nonsense"])
    if chance.random() < 0.3:
        costs["steepest"] = chance.choice([0.2, 1, 0])
    return costs


QUERIES = ["distance"] * 4 + ["path"] * 4
QUERIES += ["table", "isolines", "samples", "measure", "extent", "voronoi"]
QUERIES += ["trace", "trace", "loop", "logmap", "nearest"]


def question_about(chance, mesh):
    """One question, by GET or by POST."""
    if chance.random() < 0.05:
        target = chance.choice(["/geometry", "/source", "/geometry?format=glb"])
        return Question("GET", target, None, "bytes", DEADLINE / 1000)
    query = chance.choice(QUERIES)
    asked, formats = parameters_of(chance, mesh, query)
    asked |= part_of(chance, mesh)
    if query in ("distance", "path", "isolines", "measure", "samples") and chance.random() < 0.15:
        asked["from"] = lines_of(chance, mesh)
    if query in ("table", "voronoi") and chance.random() < 0.3:
        rows = asked["from"] if isinstance(asked["from"], list) else [asked["from"]]
        asked["from"] = [lines_of(chance, mesh) if chance.random() < 0.5 else row for row in rows]
    asked |= costs_of(chance, mesh, query, asked)
    form = chance.choice(formats)
    asked["deadline_ms"] = chance.choice([1, 5, 50, 1000]) if chance.random() < 0.1 else DEADLINE
    if form != "json":
        asked["format"] = form
    elif chance.random() < 0.2:
        asked["precision"] = chance.choice([1, 3, 6, 17])
    if form == "png":
        asked |= {"width": 64, "height": 48}
    deadline = asked["deadline_ms"] / 1000
    if chance.random() < 0.85:
        return Question("GET", f"/{query}?" + urllib.parse.urlencode(asked, doseq=True, safe=":,"),
                        None, form, deadline)
    target = f"/{query}"  # what says how, not what, goes with the body too
    return Question("POST", target, json.dumps(asked).encode(), form, deadline)


def batch_of(chance, mesh):
    """Several questions in one."""
    lines = []
    for number in range(chance.randint(1, 6)):
        query = chance.choice(QUERIES)
        asked, _ = parameters_of(chance, mesh, query)
        asked |= part_of(chance, mesh)
        asked |= costs_of(chance, mesh, query, asked)
        line = {"id": number, "query": query, "deadline_ms": DEADLINE, **asked}
        lines.append(json.dumps(line).encode())
    return Question("POST", "/batch", b"\n".join(lines) + b"\n", "lines",
                    len(lines) * DEADLINE / 1000)


def numbers_in(value, found):
    """All numbers of a JSON value in their order, and its shape without them."""
    if isinstance(value, dict):
        return {key: numbers_in(part, found) for key, part in value.items()}
    if isinstance(value, list):
        return [numbers_in(part, found) for part in value]
    if isinstance(value, float) or (isinstance(value, int) and not isinstance(value, bool)):
        found.append(float(value))
        return 0
    return value


def are_near(ours, theirs):
    """Whether two rows of numbers are the same within what weak tags allow."""
    if len(ours) != len(theirs):
        return False
    size = max((abs(x) for x in theirs if math.isfinite(x)), default=0.0)
    return all(a == b or (math.isnan(a) and math.isnan(b)) or abs(a - b) <= WEAK * size
               for a, b in zip(ours, theirs))


def lengths_of(reply):
    """Of a path, how long it is: two that are equally short may go different ways."""
    return [float(part) for part in (reply.get("length"),) if part is not None]


def is_near_json(ours, theirs):
    """Two JSON answers under weak tags."""
    if isinstance(ours, dict) and "length" in ours and "length" in theirs:
        return are_near(lengths_of(ours), lengths_of(theirs))
    mine, other = [], []
    return numbers_in(ours, mine) == numbers_in(theirs, other) and are_near(mine, other)


def is_near_lines(ours, theirs):
    """Two batches' answers."""
    mine, other = ours.splitlines(), theirs.splitlines()
    if len(mine) != len(other):
        return False
    for left, right in zip(map(json.loads, mine), map(json.loads, other)):
        if left["id"] != right["id"]:
            return False
        if left.get("problem", {}).get("code") in OF_THE_MOMENT or right["status"] == 504:
            continue
        if left["status"] != right["status"]:
            return False
        if left["status"] == 200 and not is_near_json(left["reply"], right["reply"]):
            return False
    return True


def is_strong(reply):
    """Whether a reply's entity tag promises the very same bytes next time."""
    return reply.headers.get("etag", "").startswith('"')


def is_same(question, ours, theirs):
    """Whether an answer is the one that was expected."""
    if ours.body == theirs.body:
        return True
    if question.format == "lines":
        return is_near_lines(ours.body, theirs.body)
    if is_strong(ours) and question.method == "GET":
        return False
    if question.format == "json":
        return is_near_json(json.loads(ours.body), json.loads(theirs.body))
    if question.format in ("f32", "f64") and len(ours.body) == len(theirs.body):
        code = {"f32": "f", "f64": "d"}[question.format]
        width = struct.calcsize(code)
        return are_near(*(struct.unpack(f"<{len(r.body) // width}{code}", r.body) for r in (ours, theirs)))
    # Other forms of the same numbers: they are compared where they are numbers.
    return len(ours.body) > 0 and question.format in ("png", "glb", "annotated", "npy", "frame", "u16", "f32", "f64")
