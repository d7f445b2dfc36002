#!/usr/bin/env python3
"""Everything at once, at random, on caches far too small for it.

    torture.py BUILD [--seconds N] [--clients N] [--seed N] [--most-mb N] [--back-mb N]
               [--swift] [OPTION...]

Two servers get the same thirty small meshes of awkward kinds. Several clients ask one of
them questions of every kind by every method, begin jobs and cancel them, upload, delete
and upload again, and hang up. The other, whose caches hold everything, is asked one
question at a time, and what it answers is what the first one must have answered: byte
for byte, or within the method's error where the entity tag is weak. An error must be a
problem whose code fits its status, and never 500. In the end every compute slot must be
free, memory must be back, the server ready, and every mesh there whose upload was
acknowledged and whose removal was not asked for. Exit status 1 if anything was not so.

The seed is printed; --seed or GEODESICD_SEED gives it again. It fixes meshes and
questions, not the order in which the clients' requests arrive. OPTIONs go to the first
server: `--store s3://...` for one. `--swift` keeps its store in a Swift server of its own,
in a folder below TORTURE_FOLDER if that is set: Swift needs user attributes there.
"""

import argparse
import collections
import contextlib
import json
import os
import pathlib
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time

from torture_clients import PATIENCE, Client, Connection, Mesh, Quiet
from torture_meshes import every_mesh
from torture_questions import question_about

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "crash"))

from service import Service  # noqa: E402

# So that next to nothing is kept from one question to the next.
SMALL = ["--mesh-cache-bytes", "60KiB", "--adjacency-cache-bytes", "150KiB",
         "--field-cache-bytes", "30KiB", "--reply-cache-bytes", "40KiB",
         "--max-jobs", "12", "--job-seconds", "5", "--queue", "64", "--drain-seconds", "2"]


class Torture:
    """The run."""

    def __init__(self, loud, quiet, seed):
        self.seed = seed
        self.loud = loud
        self.port = loud.port
        self.quiet = Quiet(quiet)
        self.over = threading.Event()
        self.faults = []
        self.differences = collections.Counter()
        self.clients = []
        self._lock = threading.Lock()
        chance = random.Random(seed)
        self._shapes = list(every_mesh(chance).items())
        self.meshes = [Mesh(kind, shape, f"{seed} kept") for kind, shape in self._shapes]
        self.meshes = [mesh for mesh in self.meshes if self._is_taken(mesh)]
        self.coming_and_going = []
        for i in range(4):
            kind, shape = chance.choice(self._shapes)
            mesh = Mesh(kind, shape, f"{seed} shared {i}", chance.choice(["", "?scale=0.5"]))
            if self._is_taken(mesh):
                mesh.may_be_gone = True
                self.coming_and_going.append(mesh)

    def _is_taken(self, mesh):
        """Uploads it; a mesh that is refused is no use."""
        reply = Connection(self.port).ask("POST", "/v1/meshes" + mesh.options, mesh.data)
        if reply.status in (200, 201):
            mesh.id = json.loads(reply.body)["id"]
            return True
        if reply.status != 422:
            self.fault(f"upload of {mesh.kind}: {reply}")
        return False

    def own_meshes(self, number):
        """Two for one client alone."""
        chance = random.Random(f"{self.seed}/own/{number}")
        own = []
        for i in range(2):
            kind, shape = chance.choice(self._shapes)
            options = chance.choice(["", "", "?up=z", "?scale=0.25&weld=off"])
            own.append(Mesh(kind, shape, f"{self.seed} own {number} {i}", options))
        return [mesh for mesh in own if self._is_taken(mesh)]

    def next_question(self, mesh, chance):
        """A new one, or one that was asked lately."""
        if mesh.questions and chance.random() < 0.5:
            return chance.choice(list(mesh.questions))
        question = question_about(chance, mesh)
        mesh.questions.append(question)
        return question

    def under_way(self, seconds=0):
        """What has been asked for so long and is not answered."""
        now = time.monotonic()
        asked = [client.now for client in self.clients]
        return "; ".join(f"{now - one[0]:.1f} s: {one[1]}" for one in asked if one and now - one[0] >= seconds)

    def fault(self, text):
        """Notes it, and says so if it is one of the first."""
        with self._lock:
            self.faults.append(text)
            if len(self.faults) <= 20:
                print(f"  FAULT: {text[:1500]}", flush=True)

    def differs(self, mesh, question, reply, expected):
        """An answer that is not the quiet server's: where they part."""
        at = len(os.path.commonprefix([reply.body, expected.body]))
        self.fault(f"another answer, {mesh.kind}: {question.method} {mesh.base}{question.target} "
                   f"{(question.body or b'')[:600]} tag {reply.headers.get('etag')}\n    "
                   + " quiet: ".join(str(body[max(0, at - 80):at + 80]) for body in
                                      (reply.body, expected.body)) + f" at byte {at}")


def resident_mb(service):
    """What a server holds of memory now."""
    with open(f"/proc/{service.process.pid}/status", encoding="utf-8") as status:
        return next(int(line.split()[1]) / 1024 for line in status if line.startswith("VmRSS"))


class Guard(threading.Thread):
    """Ends a server before it takes the machine's memory, as long as it lives."""

    def __init__(self, name, service, most_mb, torture):
        super().__init__(daemon=True)
        self._what, self._service, self._most_mb, self._torture = name, service, most_mb, torture
        self.most = 0.0

    def run(self):
        while self._service.process.poll() is None:
            with contextlib.suppress(OSError, StopIteration):
                self.most = max(self.most, resident_mb(self._service))
            if self.most > self._most_mb:
                self._service.process.kill()
                self._torture.fault(f"the {self._what} server was killed: it held {self.most:.0f} MB; under way: "
                                    + self._torture.under_way())
            time.sleep(0.1)


def watch(torture, seconds):
    """Sees to answers that do not come, while the clients are at work."""
    begin = time.monotonic()
    while time.monotonic() - begin < seconds:
        time.sleep(0.25)
        if torture.loud.process.poll() is not None:
            torture.fault(f"the server has ended with {torture.loud.process.returncode}")
            break
        if torture.under_way(PATIENCE - 5):
            torture.fault(f"no answer: {torture.under_way()}")
            break


def look_after(torture, clients, back_mb):
    """What must be so when all clients have gone."""
    connection = Connection(torture.port)
    until = time.monotonic() + 30
    while True:
        status = json.loads(connection.ask("GET", "/v1/status").body)
        busy = {name: status[part][name] for part, name in
                (("compute", "running"), ("compute", "queued"), ("jobs", "running"), ("jobs", "queued"))}
        if not any(busy.values()) or time.monotonic() > until:
            break
        time.sleep(0.2)
    if any(busy.values()):
        torture.fault(f"nobody asks, and yet: {status['compute']} {status['jobs']}")
    counted = status["compute"]["memory_bytes"] / 1e6
    if counted > back_mb:
        torture.fault(f"nobody computes, and {counted:.0f} MB are counted of {back_mb} MB")
    if connection.ask("GET", "/readyz").status != 200:
        torture.fault("not ready in the end")
    kept = torture.meshes + [mesh for client in clients for mesh in client.own if not mesh.may_be_gone]
    for mesh in kept:
        reply = connection.ask("GET", mesh.base + "/source")
        if (reply.status, reply.body) != (200, mesh.data):
            torture.fault(f"lost: {mesh.kind} {mesh.base}: {reply.status} {reply.body[:200]}")
    for mesh in torture.coming_and_going:
        put = connection.ask("POST", "/v1/meshes" + mesh.options, mesh.data).status
        got = connection.ask("GET", mesh.base + "/distance?from=v:0").status
        if put not in (200, 201) or got not in (200, 422):
            torture.fault(f"not to be had again: {mesh.kind} {put} {got}")
    while resident_mb(torture.loud) > back_mb and time.monotonic() < until:
        time.sleep(0.5)
    now = resident_mb(torture.loud)
    if now > back_mb:
        torture.fault(f"{now:.0f} MB are kept of {back_mb} MB")
    return now, status


@contextlib.contextmanager
def swift_store(folder):
    """A bucket in a Swift server: the store's URL, and the environment to reach it."""
    sys.path.insert(0, str(HERE.parent / "s3"))
    import s3_test  # pylint: disable=import-outside-toplevel
    swift = subprocess.Popen([s3_test.PYTHON, str(HERE.parent / "s3" / "swift_server.py"),
                              str(folder / "swift")], stdout=subprocess.PIPE, text=True)
    try:
        endpoint = swift.stdout.readline().split()[-1]
        s3_test.make_bucket(endpoint, folder)
        yield f"s3://{s3_test.BUCKET}/torture?endpoint={endpoint}", s3_test.KEYS
    finally:
        swift.terminate()
        swift.wait()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--seconds", type=float, default=600)
    parser.add_argument("--clients", type=int, default=16)
    parser.add_argument("--seed", type=int, default=os.environ.get("GEODESICD_SEED"))
    parser.add_argument("--most-mb", type=float, default=1200)
    parser.add_argument("--back-mb", type=float, default=250)
    parser.add_argument("--swift", action="store_true")
    arguments, options = parser.parse_known_args()
    # Ended from outside, it ends its servers.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    seed = int(arguments.seed) if arguments.seed is not None else random.SystemRandom().randrange(1 << 32)
    print(f"GEODESICD_SEED={seed}", flush=True)
    with contextlib.ExitStack() as stack:
        folder = pathlib.Path(stack.enter_context(tempfile.TemporaryDirectory(
            prefix="torture_", dir=os.environ.get("TORTURE_FOLDER"))))
        environment = {"ASAN_OPTIONS": f"hard_rss_limit_mb={int(arguments.most_mb) + 500}:"
                       + os.environ.get("ASAN_OPTIONS", "")}
        if "--store" not in options:
            store = str(folder / "store")
            if arguments.swift:
                store, keys = stack.enter_context(swift_store(folder))
                environment |= keys
            options += ["--store", store]
        program = arguments.build / "geodesicd"
        common = ["--log-level", "warn"]
        loud = Service(program, [*common, *SMALL, *options], folder / "loud.log", environment)
        stack.callback(loud.kill)
        quiet = Service(program, [*common, "--store", str(folder / "quiet"), "--queue-seconds", "0"],
                        folder / "quiet.log", environment)
        stack.callback(quiet.kill)
        torture = Torture(loud, quiet, seed)
        threading.excepthook = lambda thrown: torture.fault(f"{thrown.exc_type.__name__} of our own: {thrown.exc_value}")
        clients = torture.clients = [Client(torture, number) for number in range(arguments.clients)]
        guards = [Guard("tortured", loud, arguments.most_mb, torture),
                  Guard("quiet", quiet, arguments.most_mb, torture)]
        for thread in guards + clients:
            thread.start()
        watch(torture, arguments.seconds)
        torture.over.set()
        for client in clients:
            client.join(PATIENCE + 10)
        done = sum((client.done for client in clients), collections.Counter())
        after = "nothing is known"
        if loud.process.poll() is None and not any(client.is_alive() for client in clients):
            after, status = look_after(torture, clients, arguments.back_mb)
            if not all(cache["evictions"] for cache in status["caches"].values()):
                torture.fault(f"a cache has thrown out nothing: {status['caches']}")
            print("thrown out: " + ", ".join(f"{name} {cache['evictions']}"
                                             for name, cache in status["caches"].items()))
        for client in clients:
            if client.is_alive():
                torture.fault(f"never answered: {client.now}")
        print(f"{len(torture.meshes)} meshes, {len(clients)} clients, {arguments.seconds:g} s; "
              + ", ".join(f"{what}: {count}" for what, count in sorted(done.items(), key=str)))
        print(f"resident memory, MB: at most {guards[0].most:.0f}, afterwards {after if isinstance(after, str) else round(after)}")
        idle = {"query", "batch", "job", "own_mesh", "shared_mesh", "hang_up"} - set(done)
        if idle:
            torture.fault(f"nobody did: {', '.join(sorted(idle))}")
        log = (folder / "loud.log").read_text(errors="replace")
        if "Sanitizer" in log or "runtime error" in log:
            torture.fault("the sanitizer has something to say")
        if torture.faults:
            print("the end of the server's log:\n" + log[-3000:])
        elif loud.stop() != 0:
            torture.fault("the server did not end in order")
        print(f"{len(torture.faults)} faults; GEODESICD_SEED={seed}")
    return 1 if torture.faults else 0


if __name__ == "__main__":
    sys.exit(main())
