#!/usr/bin/env python3
"""Mixed load for a long time, on caches far too small for it.

    soak.py BUILD [--seconds N] [--clients N] [--slack X] [OPTION...]

Asks every question once and records the answer; then several clients ask them at
random, upload and delete meshes meanwhile, hang up, and start jobs that they cancel.
Every answer is compared with the recorded one, byte by byte; a 503 with Retry-After
is no answer, and is counted apart. At the end: how many, how many wrong, how often the
caches threw something out, and how the resident memory went. Exit status 1 if an answer
was wrong, nothing was thrown out, or memory grew by more than is asked (times the slack).
OPTIONs go to the server.
"""

import argparse
import hashlib
import http.client
import json
import random
import statistics
import sys
import threading
import time
import urllib.request

from service import Checks, Service

# A fraction of what the meshes need, so that everything comes and goes.
SMALL = ["--mesh-cache-bytes", "2MiB", "--adjacency-cache-bytes", "4MiB",
         "--field-cache-bytes", "1MiB", "--reply-cache-bytes", "16KiB"]


def questions_about(mesh, chance):
    """Targets with a bit of everything."""
    base = f"/v1/meshes/{mesh['id']}"
    vertices = [chance.randrange(mesh["vertices"]) for _ in range(6)]
    a, b, c, d, e, f = (f"v:{v}" for v in vertices)
    return [
        f"{base}/distance?from={a}&format=f32",
        f"{base}/distance?from={b}&from={c}&labels=1",
        f"{base}/distance?from={c}&at={d}&at={e}&method=exact",
        f"{base}/path?from={a}&to={d}",
        f"{base}/path?from={b}&to={e}&refine=shortest",
        f"{base}/path?from={c}&to={f}&via={a}&format=glb",
        f"{base}/table?from={a}&from={b}&to={c}&to={d}&format=npy",
        f"{base}/isolines?from={f}&count=7",
        f"{base}/samples?count=5",
        f"{base}/nearest?point=p:1,2,3",
        # Not from a vertex, which may be in no face.
        f"{base}/trace?from=f:{chance.randrange(mesh['faces'])},0.4,0.3&angle=0.1&length=1",
        f"{base}/distance?from={e}&format=png&width=160&height=120",
        f"{base}/geometry",
        f"{base}/source",
    ]


class Refused(Exception):
    """The server has too much to do."""


class Client(threading.Thread):
    """Asks until it is told to stop."""

    def __init__(self, soak, seed):
        super().__init__(daemon=True)
        self._soak = soak
        self._random = random.Random(seed)
        self._connection = None
        self.asked = 0
        self.refused = 0
        self.wrong = []

    def _ask(self, method, target, body=None, headers=None):
        if self._connection is None:
            self._connection = http.client.HTTPConnection("127.0.0.1", self._soak.port, timeout=60)
        self._connection.request(method, target, body=body, headers=headers or {})
        reply = self._connection.getresponse()
        content = reply.read()
        if reply.status == 503 and reply.getheader("Retry-After"):
            raise Refused
        return reply.status, content

    def _expect(self, what, found, *allowed):
        if found not in allowed:
            self.wrong.append(f"{what}: {found}, not {' or '.join(map(str, allowed))}")

    def _question(self):
        target, digest = self._random.choice(self._soak.answers)
        status, body = self._ask("GET", target)
        self._expect(target, (status, hashlib.sha256(body).hexdigest()), (200, digest))

    def _come_and_go(self):
        """A mesh of this client's own: uploaded, asked, deleted."""
        data = self._soak.mesh_like(self._random.random())
        status, body = self._ask("POST", "/v1/meshes", data)
        self._expect("upload", status, 201)
        base = "/v1/meshes/" + json.loads(body)["id"]
        self._expect("its distance", self._ask("GET", base + "/distance?from=v:0")[0], 200)
        self._expect("delete", self._ask("DELETE", base)[0], 204)
        self._expect("after it", self._ask("GET", base)[0], 404)

    def _hang_up(self):
        """Asks, and does not wait for the answer."""
        self._ask("GET", "/v1/methods")
        target, _ = self._random.choice(self._soak.answers)
        self._connection.request("GET", target)
        self._connection.close()
        self._connection = None

    def _job(self):
        """Starts long work and cancels it."""
        target = self._random.choice(self._soak.bases) + "/distance?from=v:3&method=chen_han"
        status, body = self._ask("GET", target, headers={"Prefer": "respond-async"})
        self._expect("job", status, 202, 429)
        if status == 202:
            link = f"/v1/jobs/{json.loads(body)['id']}"
            self._expect("cancel", self._ask("DELETE", link)[0], 204)

    def run(self):
        kinds = [self._question] * 40 + [self._come_and_go, self._hang_up, self._job]
        while not self._soak.over.is_set():
            try:
                self._random.choice(kinds)()
            except Refused:
                self.refused += 1
            except (OSError, http.client.HTTPException, ValueError) as error:
                self.wrong.append(f"{type(error).__name__}: {error}")
                self._connection = None
            self.asked += 1


class Soak:
    """A service under load, and what it has to answer."""

    def __init__(self, service):
        self.port = service.port
        self.over = threading.Event()
        meshes = json.loads(service.get("/v1/meshes"))["meshes"]
        self.bases = [f"/v1/meshes/{mesh['id']}" for mesh in meshes]
        chance = random.Random(1)
        self.answers = []
        for mesh in meshes:
            for target in questions_about(mesh, chance):
                digest = hashlib.sha256(service.get(target)).hexdigest()
                self.answers.append((target, digest))
        smallest = min(meshes, key=lambda mesh: mesh["bytes"])
        self._file = service.get(f"/v1/meshes/{smallest['id']}/source")

    def mesh_like(self, number):
        """A file that nobody has seen: the smallest sample with another name in it."""
        length = int.from_bytes(self._file[12:16], "little")
        document = json.loads(self._file[20:20 + length])
        document["asset"]["extras"] = number
        text = json.dumps(document).encode()
        text += b" " * (-len(text) % 4)
        rest = self._file[20 + length:]
        size = 20 + len(text) + len(rest)
        return (self._file[:8] + size.to_bytes(4, "little") + len(text).to_bytes(4, "little")
                + b"JSON" + text + rest)


def evictions(service):
    """How often the caches threw something out."""
    with urllib.request.urlopen(service.url("/v1/status")) as reply:
        caches = json.load(reply)["caches"]
    return {name: cache["evictions"] for name, cache in caches.items()}


def main():
    """The whole run."""
    parser = argparse.ArgumentParser()
    parser.add_argument("build")
    parser.add_argument("--seconds", type=float, default=1800)
    parser.add_argument("--clients", type=int, default=6)
    parser.add_argument("--slack", type=float, default=1)
    arguments, options = parser.parse_known_args()
    with Service(arguments.build, *SMALL, *options) as service:
        soak = Soak(service)
        clients = [Client(soak, seed) for seed in range(arguments.clients)]
        for client in clients:
            client.start()
        begin, memory = time.monotonic(), []
        while time.monotonic() - begin < arguments.seconds:
            time.sleep(min(1, arguments.seconds / 40))
            memory.append(service.stat("VmRSS") / 1024)
        soak.over.set()
        for client in clients:
            client.join(60)
        thrown_out = evictions(service)
        wrong = [error for client in clients for error in client.wrong]
        asked = sum(client.asked for client in clients)
        # The first quarter fills pools and arenas. The most of what follows: now and then a server
        # gives much back to the system, and takes it again.
        early = max(memory[len(memory) // 4:len(memory) * 3 // 4])
        late = statistics.fmean(memory[len(memory) * 3 // 4:])
        print(f"{asked} rounds by {len(clients)} clients in {arguments.seconds:g} s, of "
              f"{len(soak.answers)} recorded answers, {sum(c.refused for c in clients)} refused; "
              f"thrown out: {thrown_out}")
        twelfth = max(1, len(memory) // 12)
        print("resident memory over time, MB: "
              + " ".join(f"{value:.0f}" for value in memory[::twelfth]))
        print(f"resident memory, MB: most of the middle {early:.0f}, last quarter {late:.0f}, "
              f"most {max(memory):.0f}")
        for error in wrong[:10]:
            print(f"  WRONG: {error}")
        checks = Checks(arguments.slack)
        checks.at_most("wrong answers", len(wrong), 0, "")
        checks.at_least("evictions of each cache, the least", min(thrown_out.values()), 1, "")
        checks.at_most("growth of memory", late - early, 0.05 * early + 4, "MB")
    sys.exit(1 if checks.failed else 0)


if __name__ == "__main__":
    main()
