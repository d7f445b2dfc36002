#!/usr/bin/env python3
"""same_replies.py OLD NEW: two servers, of two commits, give the same bytes.

    same_replies.py OLD_BUILD NEW_BUILD [--questions N] [--seed S]

For a change that is to change no answer. Both folders are builds (geodesicd, make_samples). Each
server gets the sample meshes and small awkward ones from the seed. Both are then asked the same in
the same order: fields (f64) and tables of each mesh by each method, paths as they are traced and
refined, and N questions at random. Status and body must be the same to the last byte; what differs
is printed, and the exit status is then 1.
"""

import argparse
import json
import pathlib
import random
import re
import subprocess
import sys
import tempfile
import urllib.parse

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
sys.path.insert(0, str(HERE.parent / "crash"))
from service import Service  # noqa: E402
from torture_clients import Mesh  # noqa: E402
from torture_meshes import MUDDY, every_mesh  # noqa: E402
from torture_questions import METHODS, question_about  # noqa: E402

OPTIONS = {"auto": [{}, {"bound": "upper"}, {"tolerance": 0.001}],
           "steiner": [{"points_per_edge": 2}]}


def systematic(vertices):
    """What every mesh is asked: targets by every method."""
    last, middle = vertices - 1, vertices // 2
    for method in METHODS:
        for options in OPTIONS.get(method, [{}]):
            asked = {"method": method, **options, "deadline_ms": 60000}
            for query in ("distance?from=v:0&format=f64",
                          f"distance?from=v:0&from=f:0,0.2,0.3&at=v:{last}&at=f:1,0.1,0.7",
                          f"table?from=v:0&from=v:{middle}&to=v:{last}&to=v:1&format=f64",
                          f"table?from=v:0&from=v:{middle}&to=v:{last}&to=f:0,0.2,0.3&stream=1",
                          f"isolines?from=v:{middle}&count=5"):
                yield f"/{query}&{urllib.parse.urlencode(asked)}"
            if "tolerance" not in options:
                for refine in ("none", "shortest"):
                    yield (f"/path?from=v:0&to=v:{last}&refine={refine}&format=f64&"
                           + urllib.parse.urlencode(asked))
    yield "/distance?from=boundary&from=v:9&method=exact&format=f64"
    yield "/distance?from=curve:closed;v:0;v:7;f:0,0.3,0.3&at=f:1,0.1,0.7"
    yield "/distance?from=curve:closed;v:0;v:7;f:0,0.3,0.3&signed=1"
    yield "/path?from=faces:0-3&to=v:9"
    yield "/table?from=boundary&from=curve:v:0;v:7&from=faces:0-3&from=v:5&to=v:9&to=f:0,0.2,0.3&method=exact"
    yield "/table?from=faces:0-3&from=v:5&from=curve:v:0;v:7&to=v:9&to=v:20&stream=1&format=f64"
    yield "/table?from=faces:0-3&from=curve:v:0;v:7&to=v:9&to=v:20&sparse=1&max=3"
    yield "/samples?count=5"
    yield "/trace?from=f:0,0.3,0.3&angle=1&length=1"
    yield "/measure?from=f:0,0.3,0.3&radii=1&radii=3"
    yield "/extent?of=center&fields=5"
    yield "/extent?of=mean&fields=3"
    yield "/extent?of=means&fields=3"
    yield "/extent?of=means&fields=3&format=f32"
    yield "/voronoi?from=f:0,0.3,0.3&from=v:5&from=v:9&relax=2"
    yield "/voronoi?from=v:5&from=v:9&part=cells"
    yield "/voronoi?from=boundary&from=curve:v:0;v:7&from=faces:0-3&from=v:9&method=exact"
    yield "/voronoi?from=curve:v:0;v:7&from=faces:0-3&part=bisectors"
    yield "/loop?through=v:0&through=v:7&through=f:0,0.3,0.3"
    yield "/loop?around=v:0&around=v:7&around=v:20"
    yield "/loop?at=f:0,0.3,0.3&normal=0.2,0.3,1"
    yield "/loop?at=v:9&normal=1,0.1,0.2&hull=1"
    yield "/samples?count=3&within=faces:0"
    yield "/path?from=v:0&to=v:9&weights=3*faces:0-9&slope=tobler"
    yield "/isolines?from=v:0&count=3&slope=-1:2,0:1,1:3&up=0,0,1"
    yield "/samples?count=3&forbid=faces:0-2,5&forbid=sphere:0,0,0,0.1"
    yield "/samples?count=3&walls=v:0;v:7;v:20"
    yield "/measure?from=v:0&within=inside:v:0;v:7;v:20"
    yield "/logmap?from=f:0,0.3,0.3&radius=3"
    yield "/logmap?from=v:0&radius=3&transport=1"
    yield "/distance?from=v:0&labels=1&format=annotated"


def of_weights_in_files():
    """What is asked of meshes with weights in their files."""
    for query in ("distance?from=v:0&format=f64", "distance?from=v:0&at=v:9&at=f:1,0.1,0.7", "path?from=v:0&to=v:9",
                  "isolines?from=v:0&count=3", "table?from=v:0&from=v:9&to=v:5"):
        yield f"/{query}&weight_attribute=_MUD"
        yield f"/{query}&weight_attribute=_MUD&slope=-1:2,0:1,1:3&weights=3*faces:0-9"
    yield "/distance?from=v:0&weight_attribute=_SNOW"


DEADLINE = re.compile(r'(deadline_ms"?[=:] ?)\d+')
# A problem says which request it is of.
REQUEST = re.compile(rb'"request_id":"[^"]*"')


class Pair:
    """Both servers, asked the same."""

    def __init__(self, old, new):
        self.both = (old, new)
        self.asked = self.different = 0

    def ask(self, method, target, body=None):
        """What both answer; says where it is not the same."""
        (old, _, was), (new, _, is_now) = (
            service.ask(method, target, body, timeout=120) for service in self.both)
        self.asked += 1
        if (old, REQUEST.sub(b"", was)) != (new, REQUEST.sub(b"", is_now)):
            self.different += 1
            print(f"DIFFERENT: {method} {target} {(body or b'')[:200]}: {old} {was[:200]} and now "
                  f"{new} {is_now[:200]}", flush=True)
        return new, is_now

    def add(self, file, name):
        """The id of an uploaded mesh and its vertices; None if it is refused."""
        status, body = self.ask("POST", f"/v1/meshes?{name}", file)
        if status not in (200, 201):
            return None
        told = json.loads(body)
        return told["id"], told["vertices"]


def main():
    """Asks, and says how many questions had the same answer."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("old", type=pathlib.Path)
    parser.add_argument("new", type=pathlib.Path)
    parser.add_argument("--questions", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=random.randrange(2**31))
    arguments = parser.parse_args()
    print(f"seed {arguments.seed}")
    chance = random.Random(arguments.seed)
    with tempfile.TemporaryDirectory() as folder:
        servers = [Service(str(build / "geodesicd"), ["--store", f"{folder}/{name}", "--log-level", "error"],
                           f"{folder}/{name}.log")
                   for name, build in (("old", arguments.old), ("new", arguments.new))]
        pair = Pair(*servers)
        subprocess.run([arguments.new / "make_samples", f"{folder}/samples"], check=True,
                       stdout=subprocess.DEVNULL)
        for file in sorted(pathlib.Path(f"{folder}/samples").iterdir()):
            added = pair.add(file.read_bytes(), "")
            for question in systematic(added[1]) if added else ():
                pair.ask("GET", f"/v1/meshes/{added[0]}{question}")
        print(f"{pair.asked} questions of the samples, {pair.different} answered otherwise", flush=True)
        small = []
        for kind, shape in every_mesh(chance).items():
            mesh = Mesh(kind, shape, str(arguments.seed))
            if added := pair.add(mesh.data, ""):
                small.append((added[0], mesh))
                for question in of_weights_in_files() if kind in MUDDY else ():
                    pair.ask("GET", f"/v1/meshes/{added[0]}{question}")
        for _ in range(arguments.questions):
            identity, mesh = chance.choice(small)
            question = question_about(chance, mesh)
            # Whether a short deadline is met is chance.
            target, body = (DEADLINE.sub(r"\g<1>60000", text) for text in (
                question.target, (question.body or b"").decode()))
            pair.ask(question.method, f"/v1/meshes/{identity}{target}", body.encode() or None)
        for server in servers:
            server.stop()
    print(f"{pair.asked} questions, {pair.different} answered otherwise")
    sys.exit(1 if pair.different or pair.asked < 500 else 0)


if __name__ == "__main__":
    main()
