#!/usr/bin/env python3
"""What a server answers depends on nothing but the question.

    tags_test.py GEODESICD [--questions N]

Four servers have the same meshes: one keeps whatever it can, and is asked everything twice; one
keeps nothing, so that it is cold at each question; one is another's replica, asked the same in
another order; and one keeps nothing in memory, but maps what it has prepared before. Where a reply's tag is strong, all of them give the same tag and the same bytes, and
errors too are the same. Where it is weak, the numbers are the same as far as openapi.yaml says.

GEODESICD_SEED=NUMBER sets what is drawn; it is printed.
"""

import argparse
import collections
import os
import pathlib
import random
import re
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "crash"), str(HERE.parent / "load")]

import torture_questions  # noqa: E402
from service import Service  # noqa: E402
from torture_clients import Connection, Mesh  # noqa: E402
from torture_meshes import every_mesh, grid  # noqa: E402

torture_questions.WEAK = 1e-4  # in parts of the greatest number; what openapi.yaml leaves open
COLD = [f"--{cache}-cache-bytes=0" for cache in ("mesh", "adjacency", "field", "reply")]
DEADLINE = re.compile(r'(deadline_ms"?[=:] ?)\d+')
# A problem says which request it is of.
REQUEST = re.compile(rb'"request_id":"[^"]*"')


def drawn(chance, meshes, count):
    """Questions about meshes; whether a short deadline is met is chance, so there is none."""
    for _ in range(count):
        mesh = chance.choice(meshes)
        question = torture_questions.question_about(chance, mesh)
        target, body = (DEADLINE.sub(r"\g<1>60000", text) for text in (question.target, (question.body or b"").decode()))
        yield mesh, question._replace(target=target, body=body.encode() or None)


def differs(question, one, other):
    """What two replies to a question do not have in common; nothing if they are the same."""
    if one.status != other.status:
        return f"{one.status} and {other.status}"
    if one.headers.get("etag") != other.headers.get("etag"):
        return f"the tags {one.headers.get('etag')} and {other.headers.get('etag')}"
    mine, others = (reply._replace(body=REQUEST.sub(b"", reply.body)) for reply in (one, other))
    if mine.status != 200:
        return "" if mine.body == others.body else f"the errors {mine.body[:200]} and {others.body[:200]}"
    if torture_questions.is_strong(mine) or question.format == "bytes":
        return "" if mine.body == others.body else "bytes"
    return "" if torture_questions.is_same(question, mine, others) else "numbers"


def metric(server, series):
    """A number among a server's metrics."""
    text = server.ask("GET", "/metrics")[2].decode()
    return int(re.search(rf"^geodesicd_{re.escape(series)} (\d+)$", text, re.M)[1])


def wait_until_written(server, count):
    """Until it has so many prepared meshes in files."""
    end = time.monotonic() + 60
    while metric(server, 'prepared_writes_total{outcome="written"}') < count:
        if time.monotonic() > end:
            raise TimeoutError("prepared meshes are not written")
        time.sleep(0.05)


def main():
    """Asks; exits with 1 if something was not the same."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("--questions", type=int, default=2000)
    arguments = parser.parse_args()
    seed = os.environ.get("GEODESICD_SEED") or str(random.randrange(1 << 32))
    print(f"GEODESICD_SEED={seed}", flush=True)
    chance = random.Random(seed)
    # One on which pairs are searched for where no field is at hand.
    shapes = every_mesh(chance) | {"wide terrain": grid(80, 80, lambda x, y: chance.random() / 4)}
    with tempfile.TemporaryDirectory() as folder:
        def start(name, *flags):
            return Service(arguments.program, ["--store", f"{folder}/{name}", "--log-level", "error", *flags],
                           f"{folder}/{name}.log")

        mapping = ["mapping", "--prepared", f"{folder}/files", "--prepared-min-faces", "0"]
        servers = {"warm": start("warm"), "cold": start("cold", *COLD), "replica": start("replica"), "mapping": start(*mapping)}
        connections = {name: Connection(server.port) for name, server in servers.items()}
        warm = connections["warm"]
        meshes = []
        for kind, shape in shapes.items():
            mesh = Mesh(kind, shape, seed)
            taken = {to.ask("POST", "/v1/meshes", mesh.data).status for to in connections.values()}
            assert len(taken) == 1, (kind, taken)
            if taken == {201}:
                meshes.append(mesh)
        wait_until_written(servers["mapping"], len(meshes))
        servers["mapping"].stop()
        servers["mapping"] = start(*mapping, *COLD)  # maps a mesh for each question
        connections["mapping"] = Connection(servers["mapping"].port)
        meshes += [meshes[-1]] * (len(meshes) // 4)  # it is asked about more often
        asked = list(drawn(chance, meshes, arguments.questions))
        first = [warm.ask(question.method, mesh.base + question.target, question.body) for mesh, question in asked]
        counts, faults = collections.Counter(), 0
        for at in chance.sample(range(len(asked)), len(asked)):
            mesh, question = asked[at]
            counts["strong" if torture_questions.is_strong(first[at]) else
                   "errors" if first[at].status != 200 else "weak"] += 1
            for name, to in connections.items():
                reply = to.ask(question.method, mesh.base + question.target, question.body)
                counts["compared"] += 1
                if what := differs(question, first[at], reply):
                    faults += 1
                    print(f"FAILED: {name}: {mesh.kind}: {question.method} {question.target} {question.body}: {what}")
        counts["mapped"] = metric(servers["mapping"], 'prepared_lookups_total{result="hit"}')
        for server in servers.values():
            server.stop()
    print(", ".join(f"{count} {what}" for what, count in sorted(counts.items())))
    enough = counts["strong"] > len(asked) / 5 and counts["weak"] > len(asked) / 20
    enough = enough and counts["mapped"] > len(asked) / 2
    print("ok" if not faults and enough else f"FAILED: {faults} differ, of kinds enough: {enough}")
    return 1 if faults or not enough else 0


if __name__ == "__main__":
    sys.exit(main())
