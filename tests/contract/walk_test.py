#!/usr/bin/env python3
"""walk_test.py BUILD: walks the contract and the service against each other.

From the document to the service: every operation is asked with the document's own
examples, in every format; every status that an operation lists, and every error code
that a reply names, is brought about at least once. From the service to the document:
every reply of the walk has a status, a type, headers, a schema and a code that are
described. What cannot be brought about from outside is listed in UNREACHED, with the
test that has it."""

import atexit
import collections
import gzip
import hashlib
import json
import pathlib
import shutil
import sys
import tempfile
import urllib.parse

import bodies
from ruamel.yaml import YAML

from contract import Contract
from server import Server, wait_until
from troubles import walk_damage, walk_deadlines, walk_drain, walk_load, walk_memory
from walk import UPLOADS, Walk, first_request, least_query, samples

UNKNOWN = "f" * 64
BEYOND = 999999999

# What each format is sent as.
TYPES = {
    "json": "application/json",
    "f32": "application/octet-stream",
    "f64": "application/octet-stream",
    "u16": "application/octet-stream",
    "npy": "application/x-npy",
    "ndjson": "application/x-ndjson",
    "npz": "application/x-npz",
    "frame": "application/vnd.geodesic.frame",
    "glb": "model/gltf-binary",
    "png": "image/png",
    "annotated": "model/gltf-binary",
}
# What a table is to be for these.
LARGE = {"ndjson": ("stream", "1"), "npz": ("sparse", "1")}
# What only a mesh that was uploaded as one has; the plane is a GLB.
OF_OTHER_FILES = {"model/gltf+json"}

# (status or code, operation or None for all) -> where it is tested instead.
UNREACHED = {
    ("500", "uploadMesh"): "needs a disk that fails: store/disk_test.cpp",
    ("500", "putMesh"): "needs a disk that fails: store/disk_test.cpp",
    ("500", "deleteMesh"): "needs a disk that fails: store/disk_test.cpp",
    ("503", "getMesh"): "needs a store that does not answer: s3_store_test.cpp",
    ("503", "probeMesh"): "needs a store that does not answer: s3_store_test.cpp",
    ("503", "listMeshes"): "needs a store that does not answer: s3_store_test.cpp",
    ("503", "getMeshSource"): "needs a store that does not answer: s3_store_test.cpp",
    ("503", "postBatch"): "needs as many streams as there may be: edge/slow_test.cpp",
    ("503", "watchJob"): "needs as many streams as there may be: edge/slow_test.cpp",
    ("500", "listMeshes"): "needs a disk that fails: store/disk_test.cpp",
    ("internal", None): "a fault of the server's own: edge/server_test.cpp",
    ("store_failed", None): "needs a disk that fails: store/disk_test.cpp",
    ("store_full", None): "needs a full disk: store/disk_test.cpp",
    ("store_unavailable", None): "needs a store that does not answer: s3_store_test.cpp",
}


def check_examples(contract, walk):
    """Every example of the document is what its own schema says."""

    def look(node, path):
        if isinstance(node, list):
            for index, item in enumerate(node):
                look(item, f"{path}[{index}]")
        if not isinstance(node, dict):
            return
        if "schema" in node and isinstance(node["schema"], dict):
            for example in contract.examples_of({k: v for k, v in node.items() if k != "schema"}):
                for error in contract.errors(example, node["schema"]):
                    walk.fail(f"the example at {path}: {error}")
        for key, item in node.items():
            if key not in ("example", "examples"):
                look(item, f"{path}.{key}")

    look(contract.document["paths"], "paths")
    look(contract.document["components"], "components")
    for name, schema in contract.document["components"]["schemas"].items():
        examples = list(schema.get("examples", []))
        for example in examples:
            for error in contract.errors(example, schema):
                walk.fail(f"the example of the schema {name}: {error}")
        if not examples:
            walk.fail(f"the schema {name} has no example")


def walk_examples(walk, server, plane):
    """Every operation as the document shows it, in every format."""
    for operation in walk.contract.operations:
        if operation.id in UPLOADS:
            data = bodies.NEEDLE if operation.id == "putMesh" else bodies.TRIANGLE
            for status in (201, 200):
                walk.ask_for(status, server, operation, *first_request(operation, data))
            if "202" in operation.responses:
                later = {"Prefer": "respond-async"}
                walk.ask_for(202, server, operation, *first_request(operation, data), later)
            continue
        if operation.method == "DELETE" or operation.path.startswith("/v1/jobs"):
            continue
        targets = [operation.target(operation.example_query(True))]
        values = [value for _, value in operation.example_bodies()]
        if not values:
            targets.insert(0, operation.target(least_query(operation)))
        for target in targets:
            for value in values or [None]:
                reply = walk.ask_for(200, server, operation, target, value)
        tag = reply.headers.get("etag")
        if tag and operation.method in ("GET", "HEAD"):
            walk.ask_for(304, server, operation, target, value, {"If-None-Match": tag})
        if "202" in operation.responses:
            walk.ask_for(202, server, operation, target, value, {"Prefer": "respond-async"})
        walk_formats(walk, server, operation, value)


def walk_annotated(walk, server, operation):
    """A mesh that was uploaded as a .gltf comes back as one, with a name of one's own in it."""
    uploaded = server.ask("POST", "/v1/meshes", bodies.NEEDLE)
    path = f"/v1/meshes/{json.loads(uploaded.body)['id']}/" + operation.path.rsplit("/", 1)[1]
    what = {"of": "means"} if operation.path.endswith("/extent") else {"from": "v:0"}
    asked = {**what, "format": "annotated", "attribute": "_HEAT"}
    if operation.method == "GET":
        reply = walk.ask_for(200, server, operation, path + "?" + urllib.parse.urlencode(asked))
    else:
        reply = walk.ask_for(200, server, operation, path, asked)
    if b'"_HEAT"' not in reply.body:
        walk.fail(f"{operation.id}: no attribute of the name that was asked for")


def walk_formats(walk, server, operation, value):
    """Each format that `format` lists, and each type by Accept."""
    described = operation.responses["200"].get("content", {})
    formats = [p for p in operation.parameters_in("query") if p["name"] == "format"]
    for parameter in formats:
        for name in walk.contract.resolve(parameter["schema"])["enum"]:
            query = [(k, v) for k, v in least_query(operation) if k != "format"]
            more = [LARGE[name]] if name in LARGE else []
            target = operation.target(query + more + [("format", name)])
            if TYPES[name] not in described:
                walk.ask_for(406, server, operation, target)
            elif walk.ask(server, operation, target).status != 200 and name != "u16":
                walk.fail(f"{operation.id}: no {name}")
    if isinstance(value, dict) and len(described) > 1:
        # Some formats are for whole fields only.
        least = {k: v for k, v in value.items() if k not in ("at", "format")}
        for kind in set(described) - OF_OTHER_FILES:
            large = dict(LARGE[name] for name in LARGE if TYPES[name] == kind)
            asked = {**least, **large} if operation.path.endswith("/table") else least
            walk.ask_for(200, server, operation, operation.target(), asked, {"Accept": kind})
    if formats or isinstance(value, dict):
        if operation.path.endswith(("/distance", "/logmap", "/extent")):
            walk_annotated(walk, server, operation)
        missing = set(described) - walk.types[operation.id]
        if missing:
            walk.fail(f"{operation.id}: never answered with {missing}")


def wrong_values(operation):
    """Requests that parse and cannot be: (query, body), each wrong in one way."""
    query = least_query(operation)
    body = next((value for _, value in operation.example_bodies()), None)
    point = {"nearest": "point", "loop": "through"}.get(operation.path.rsplit("/", 1)[1], "from")
    for text in (f"v:{BEYOND}", "p:1e61,0,0", "ray:0,0,9,0,0,1"):
        if isinstance(body, dict):
            yield [], {**body, point: text}
        elif any(name in (point, "from") for name, _ in query):
            yield [(k, v) for k, v in query if k != point] + [(point, text)], None
    if point == "through":  # the whole of the plane is in this one
        flat = {"at": "v:0", "normal": "0,0,1"}
        yield ([], flat) if isinstance(body, dict) else (list(flat.items()), None)
    if isinstance(body, dict):
        yield [], {**body, "method": "none"} if point == "from" else {**body, "precision": 99}
        yield [], {**body, point: {"xyz": [1, 1, 50], "max_snap": 0.1}}
        yield [], {**body, point: "v:0", "within": "faces:9999"}
        yield [], {**body, "forbid": {"part": 0}}
    else:
        yield query + [("method", "none")], None
        yield query + [("precision", "99")], None
        yield query + [("limit", "5000")], None
        yield query + [("deadline_ms", "0")], None


def walk_refusals(walk, server, contract):
    """What a client may do wrong, at every operation."""
    for operation in contract.operations:
        target, body = first_request(operation)
        glue = "&" if "?" in target else "?"
        if "400" in operation.responses:
            walk.ask(server, operation, f"{target}{glue}no_such_parameter=1", body)
            if isinstance(body, dict):
                walk.ask_for(400, server, operation, target, "{")
            elif least_query(operation):
                broken = [(name, "!") for name, _ in least_query(operation)]
                walk.ask_for(400, server, operation, operation.target(broken))
        for parameter in operation.parameters_in("query"):
            if "enum" in parameter.get("schema", {}):
                walk.ask(server, operation, f"{target}{glue}{parameter['name']}=!", body)
        if "404" in operation.responses:
            path = {p["name"]: UNKNOWN for p in operation.parameters_in("path")}
            walk.ask(server, operation, first_request(operation, **path)[0], body)
        if "406" in operation.responses:
            walk.ask(server, operation, target, body, {"Accept": "font/woff"})
        if "415" in operation.responses:
            packed = gzip.compress(bodies.TRIANGLE)
            walk.ask_for(415, server, operation, target, packed, {"Content-Encoding": "gzip"})
        if "422" in operation.responses and operation.id not in UPLOADS:
            for query, value in wrong_values(operation):
                walk.ask(server, operation, operation.target(query), value)
        if "405" not in operation.responses and "default" in operation.responses:
            reply = server.ask("BREW", operation.target())
            if reply.status not in (405, 501):
                walk.fail(f"BREW {operation.path}: {reply.status}")


def walk_uploads(walk, build, contract):
    """Every file that is refused, by both ways of uploading."""
    with Server(build, "--max-vertices", 100, "--max-faces", 30) as server:
        for operation in contract.operations:
            if operation.id not in UPLOADS:
                continue
            for code, data in bodies.REFUSED.items():
                reply = walk.ask(server, operation, *first_request(operation, data))
                got = json.loads(reply.body).get("code")
                if got != code:
                    walk.fail(f"{operation.id}: {got} instead of {code}")
            if operation.id == "putMesh":
                walk.ask_for(422, server, operation, operation.target(id=UNKNOWN), bodies.TRIANGLE)


def walk_limits(walk, build, contract):
    """Bodies that are too large, and those that never come."""
    flags = ["--max-json-bytes", 64, "--max-body-bytes", 64, "--body-timeout-seconds", 1]
    with Server(build, *flags) as server:
        for operation in contract.operations:
            target, _ = first_request(operation)
            if "307" in operation.responses:  # it has no documentation
                walk.ask_for(307, server, operation, target)
            for status, length in (("413", 10**9), ("408", 5)):
                if status in operation.responses:
                    reply = server.ask_without_sending(operation.method, target, length)
                    walk.note(operation, reply, f"a body of {length} that does not come")


def walk_tokens(walk, build, contract):
    """Without a token, and with one that does not allow it."""
    if not any("401" in operation.responses for operation in contract.operations):
        return
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "tokens"
        secrets = {scope: "geo_" + scope[0] * 43 for scope in ("read", "upload", "admin")}
        with open(file, "w", encoding="utf-8") as lines:
            for scope, secret in secrets.items():
                lines.write(f"{scope} {scope} {hashlib.sha256(secret.encode()).hexdigest()}\n")
        file.chmod(0o600)
        with Server(build, "--tokens", file) as server:
            for operation in contract.operations:
                target, body = first_request(operation)
                if "401" in operation.responses:
                    walk.ask_for(401, server, operation, target, body)
                if "403" in operation.responses:
                    for secret in secrets.values():
                        walk.ask(
                            server, operation, target, body, {"Authorization": f"Bearer {secret}"}
                        )


def walk_jobs(walk, server, contract, mesh, slow):
    """What jobs go through: done, failed to be done yet, cancelled."""
    by_id = {operation.id: operation for operation in contract.operations}
    if "getJob" not in by_id:
        return

    def begin(method, target, body=None):
        reply = server.ask(method, target, body, {"Prefer": "respond-async"})
        return json.loads(reply.body)["id"]

    def ask_for(status, name, job, headers=None):
        return walk.ask_for(status, server, by_id[name], by_id[name].target(job=job), None, headers)

    def has_ended(job):
        state = json.loads(ask_for(200, "getJob", job).body)["state"]
        return state not in ("queued", "running")

    asked = begin("GET", f"/v1/meshes/{mesh}/distance?from=v:5")
    uploaded = begin("POST", "/v1/meshes", bodies.TRIANGLE + b" ")
    for job, status in ((asked, 200), (uploaded, 201)):
        wait_until(lambda job=job: has_ended(job), "a job goes on for ever")
        ask_for(status, "getJobResult", job)
        ask_for(200, "watchJob", job)
        ask_for(204, "watchJob", job, {"Last-Event-ID": "end"})
    running = begin("GET", f"/v1/meshes/{slow}/distance?from=v:5&method=chen_han")
    ask_for(409, "getJobResult", running)
    ask_for(204, "cancelJob", running)
    wait_until(lambda: has_ended(running), "a cancelled job goes on")
    ask_for(409, "getJobResult", running)
    ask_for(204, "cancelJob", asked)
    ask_for(404, "getJob", asked)


def check_covered(walk, contract):
    """What the document lists and the walk has not seen."""
    unused = set(UNREACHED)
    seen_codes = collections.defaultdict(set)
    named = collections.defaultdict(set)
    for operation in contract.operations:
        for status in operation.responses:
            only_reads = status == "304" and operation.method == "POST"
            if status != "default" and not only_reads and status not in walk.statuses[operation.id]:
                if (status, operation.id) in UNREACHED:
                    unused.discard((status, operation.id))
                else:
                    walk.fail(f"{operation.id} never answered {status}")
            reply = operation.node["responses"][status]
            place = reply.get("$ref", f"{operation.id} {status}")
            if status != "default":
                named[place] |= set(operation.codes(status))
                seen_codes[place] |= {c for s, c in walk.codes[operation.id] if s == status}
    for place, codes in named.items():
        for code in sorted(codes - seen_codes[place]):
            if (code, None) in UNREACHED:
                unused.discard((code, None))
            else:
                walk.fail(f"{place.rsplit('/', 1)[-1]}: `{code}` is named and never came")
    for status, operation in sorted(unused, key=str):
        if operation:
            walk.fail(
                f"UNREACHED has {status} of {operation}, which came after all or is not described"
            )


def main():
    """Walks, and says what is wrong."""
    build = sys.argv[1]
    meshes = samples(build)
    plane, slow = meshes["plane.glb"], meshes["torus_knot.glb"]
    site = pathlib.Path(tempfile.mkdtemp(prefix="contract_docs_"))
    atexit.register(shutil.rmtree, site, True)
    (site / "index.html").write_text("<!doctype html><title>site</title>", encoding="utf-8")
    with Server(build, "--docs", site) as server:
        contract = Contract(json.loads(server.ask("GET", "/openapi.json").body))
        walk = Walk(contract)
        check_examples(contract, walk)
        for place in contract.unknown_keys():
            walk.fail(f"{place[1:]} is no key of OpenAPI's: are quotes missing round a comma?")
        # By a reader of YAML 1.2 that the build does not use.
        document = YAML(typ="safe", pure=True).load(server.ask("GET", "/openapi.yaml").body)
        if document != contract.document:
            walk.fail("/openapi.json is not what /openapi.yaml says")
        server.upload(plane)
        slow_id = server.upload(slow)
        walk_examples(walk, server, plane)
        walk_refusals(walk, server, contract)
        walk_jobs(walk, server, contract, hashlib.sha256(plane).hexdigest(), slow_id)
        for data, target in (
            (bodies.HUGE, "/geometry"),
            (bodies.NEEDLE, "/distance?from=f:1,0.2,0.3"),
        ):
            mesh = server.upload(data)
            for operation in contract.operations:
                if (
                    operation.path == "/v1/meshes/{id}" + urllib.parse.urlsplit(target).path
                    and operation.method == "GET"
                ):
                    walk.ask_for(422, server, operation, f"/v1/meshes/{mesh}{target}")
        store = server.store
        for operation in contract.operations:
            if operation.id == "deleteMesh":
                walk.ask_for(
                    204, server, operation, operation.target(id=server.upload(bodies.TRIANGLE))
                )
    walk_uploads(walk, build, contract)
    walk_limits(walk, build, contract)
    walk_tokens(walk, build, contract)
    walk_damage(walk, build, contract, store)
    walk_load(walk, build, contract, store, slow_id, UNREACHED)
    walk_deadlines(walk, build, contract, store)
    walk_memory(walk, build, contract, store)
    walk_drain(walk, build, contract, store, slow_id)
    check_covered(walk, contract)
    for problem in walk.problems:
        print(f"FAILED: {problem}")
    print(
        f"{walk.replies} replies of {len(contract.operations)} operations, "
        f"{len(walk.problems)} problems"
    )
    sys.exit(1 if walk.problems else 0)


if __name__ == "__main__":
    main()
