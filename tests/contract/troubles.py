"""Servers in trouble: with damaged bytes in the store, with every place in the queue
taken, with no time left, about to stop."""

import contextlib
import http.client
import json
import pathlib
import shutil
import signal
import tempfile
import threading
import time

import bodies
from server import Server, wait_until
from walk import first_request, least_query


def walk_damage(walk, build, contract, store):
    """Stored bytes that have changed."""
    for operation in contract.operations:
        if "500" not in operation.responses or "{id}" not in operation.path:
            continue
        with tempfile.TemporaryDirectory(prefix="contract_") as folder:
            copy = pathlib.Path(folder) / "damaged"
            shutil.copytree(store, copy)
            for file in list(copy.rglob("*")):
                if file.is_file() and file.stat().st_size > 100000:
                    data = bytearray(file.read_bytes())
                    data[-100] ^= 1
                    file.write_bytes(data)
                elif file.suffix == ".json":
                    file.unlink()  # so that metadata has to be made anew
            with Server(build, store=copy) as server:
                walk.ask(server, operation, *first_request(operation))


class Busy:
    """Keeps the one compute slot of a server and the places before it taken."""

    def __init__(self, server, mesh):
        self._server, self._mesh = server, mesh
        self._over = threading.Event()
        self._threads = [
            threading.Thread(target=self._ask, args=(number, source), daemon=True)
            for number, source in enumerate(
                ["127.0.0.1"] * 2 + ["127.0.0.2"] * 2 + ["127.0.0.3"] * 2
            )
        ]

    def _ask(self, number, source):
        vertex = number
        while not self._over.is_set():
            vertex += 101
            target = f"/v1/meshes/{self._mesh}/distance?from=v:{vertex}&method=chen_han&at=v:0"
            try:
                self._server.ask("GET", target, source=source)
            except (OSError, http.client.HTTPException):
                return

    def is_full(self):
        """Whether one runs and others wait."""
        compute = json.loads(self._server.ask("GET", "/v1/status").body)["compute"]
        return compute["running"] == 1 and compute["queued"] >= 2

    def __enter__(self):
        for thread in self._threads:
            thread.start()
        wait_until(self.is_full, "no request waits")
        return self

    def __exit__(self, *_):
        self._over.set()


def walk_load(walk, build, contract, store, slow, unreached):
    """A server that is busy, with a queue that is full. `unreached`: what not to wait for."""
    flags = ["--compute-threads", 1, "--queue", 2, "--queue-per-client", 1, "--queue-seconds", 0]
    flags += ["--mesh-cache-bytes", 1, "--adjacency-cache-bytes", 1, "--field-cache-bytes", 1,
              "--reply-cache-bytes", 1]
    with Server(build, *flags, store=store) as server, Busy(server, slow):
        for operation in contract.operations:
            for status, source in (("503", "127.0.0.4"), ("429", "127.0.0.1")):
                if status not in operation.responses or (status, operation.id) in unreached:
                    continue
                if not operation.path.startswith("/v1/meshes"):
                    continue
                for attempt in range(300):  # it takes turns whose places are taken
                    request = first_request(operation, bodies.TRIANGLE + b" " * attempt)
                    if status == "429":
                        source = f"127.0.0.{attempt % 3 + 1}"
                    if walk.ask(server, operation, *request, source=source).status == int(status):
                        break
                    time.sleep(0.02)


def walk_deadlines(walk, build, contract, store):
    """A millisecond is over before a mesh is read and made ready, every time anew."""
    flags = ["--mesh-cache-bytes", 1, "--adjacency-cache-bytes", 1, "--field-cache-bytes", 1,
             "--reply-cache-bytes", 1]
    with Server(build, *flags, store=store) as server:
        for operation in contract.operations:
            if "504" not in operation.responses:
                continue
            body = next((value for _, value in operation.example_bodies()), None)
            request = operation.target(least_query(operation) + [("deadline_ms", "1")]), body
            if isinstance(body, dict):
                request = operation.target(), {**body, "deadline_ms": 1}
            walk.ask_for(504, server, operation, *request)


def walk_memory(walk, build, contract, store):
    """A server whose computations, all together, may take next to no memory."""
    flags = ["--compute-memory-bytes", 1, "--mesh-cache-bytes", 1, "--adjacency-cache-bytes", 1,
             "--field-cache-bytes", 1, "--reply-cache-bytes", 1]
    with Server(build, *flags, store=store) as server:
        for operation in contract.operations:
            if "422" in operation.responses and operation.path.startswith("/v1/meshes"):
                # A mesh that is kept already would be answered without any memory.
                walk.ask(server, operation, *first_request(operation, bodies.TRIANGLE + b" " * 1000))


def walk_drain(walk, build, contract, store, slow):
    """A server that is about to stop but has a request under way, asked on its admin
    listener."""
    ready = next(operation for operation in contract.operations if operation.path == "/readyz")
    target = f"/v1/meshes/{slow}/table"
    body = {"from": [{"vertex": 10 * row} for row in range(900)], "method": "chen_han"}  # minutes
    flags = ["--admin-listen", "127.0.0.1:0", "--compute-threads", 1, "--drain-seconds", 300]
    with Server(build, *flags, store=store) as server:
        before = json.loads(server.ask("GET", "/v1/status").body)["compute"]["finished"]

        def ask():
            with contextlib.suppress(OSError, http.client.HTTPException):  # killed in the end
                server.ask("POST", target, json.dumps(body))

        def computes():
            compute = json.loads(server.ask("GET", "/v1/status").body)["compute"]
            return compute["running"] == 1 or compute["finished"] > before + 3

        threading.Thread(target=ask, daemon=True).start()
        wait_until(computes, "nothing runs")
        server.process.send_signal(signal.SIGTERM)
        server.port = server.admin_port
        wait_until(lambda: walk.ask(server, ready, "/readyz").status == 503, "it is ready for ever")
        server.process.kill()
