#!/usr/bin/env python3
"""Three servers on one bucket, behind nginx and behind HAProxy as deploy/ configures them.

    fleet_test.py GEODESICD [--seconds N]

The bucket is of a real S3 server, Swift; skipped where there is none. For each balancer:

- it finds its configuration in order;
- what is about one mesh goes to one server, and jobs are found where they run;
- each server gives the same bytes and tags, of a mesh that another one took, too;
- while clients ask, upload and start jobs for N seconds, one server is killed and started again and
  one is stopped in order and started again: no request fails after the retries that HTTP allows, no
  reply is wrong, no upload is lost;
- what is deleted is gone for all in time, and with no S3 what is warm goes on being answered.

No job is lost either: whoever is asked has what it came to, or begins it again.

GEODESICD_SEED=NUMBER sets what is drawn; it is printed.
"""

import argparse
import collections
import hashlib
import json
import os
import pathlib
import random
import signal
import sys
import threading
import time

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "crash"), str(HERE.parent / "s3")]

from balancers import HAProxy, Nginx  # noqa: E402
from ports import free_port  # noqa: E402
from service import Service, mesh  # noqa: E402
from swift_bucket import BUCKET, KEYS, bucket  # noqa: E402

SERVERS = 3
CLIENTS = 4
SHARED = 12  # meshes that all clients ask about
SIDE = 12  # vertices of a mesh along a side
SEEN_WITHIN = 45.0  # seconds until another server's removal is seen, and a moment

failures = 0


def expect(what, is_so, *details):
    """Prints a line about one thing that must be so."""
    global failures
    failures += not is_so
    print(("ok: " if is_so else "FAILED: ") + what, *(() if is_so else details), flush=True)


class Fleet:
    """The servers: each can be killed, stopped and started again on its port.

    `endpoints`: where each of them reaches the bucket, where that is not the same for all.
    """

    def __init__(self, program, there, prefix, endpoints=None):
        self._program, self._log = program, there.folder / "log"
        self._stores = [f"s3://{BUCKET}/{prefix}?endpoint={endpoint}&timeout=10"
                        for endpoint in endpoints or [there.endpoint] * SERVERS]
        self.ports = [free_port() for _ in self._stores]
        self.servers = [None] * SERVERS
        for at in range(SERVERS):
            self.begin_again(at)

    def begin_again(self, at):
        """Starts one that has ended, or has not been there yet."""
        flags = ["--store", self._stores[at], "--trusted-proxies", "127.0.0.1", "--drain-delay-seconds", "4",
                 # Nobody reads what they say, and a full pipe would stop them.
                 "--log-level", "warn"]
        self.servers[at:at + 1] = [Service(self._program, flags, self._log, KEYS, self.ports[at])]

    def end(self):
        """Kills all of them."""
        for server in self.servers:
            server.kill()


def question_of(random_, vertices):
    """A query below a mesh's path, cheap and with a reply that depends on nothing else."""
    source, target = random_.randrange(vertices), random_.randrange(vertices)
    return random_.choice([f"distance?from=v:{source}&at=v:{target}", f"distance?from=v:{source}&method=exact",
                           f"isolines?from=v:{source}&count=3", f"nearest?point=p:{source % 9},1,0.5",
                           f"table?from=v:{source}&to=v:{target}", "geometry"])


class Clients:
    """Threads that ask at random until they are told to stop, and note what went wrong."""

    def __init__(self, balancer, meshes, seed):
        self._balancer, self._meshes, self._seed = balancer, meshes, seed
        self._ending = threading.Event()
        self._lock = threading.Lock()
        self._first = {}  # the reply to each question, which all others are compared with
        self.uploads = {}  # that were acknowledged: bytes by id
        self.deeds = [self._ask, self._post, self._upload, self._job]
        self.may_be_told_later = False  # a job, by a server without its bucket
        self.phase = "load"
        self.seconds = collections.defaultdict(list)  # that replies took, by the phase
        self.counts = collections.Counter()
        self.faults = []
        self._threads = [threading.Thread(target=self._run, args=(at,)) for at in range(CLIENTS)]
        for thread in self._threads:
            thread.start()

    def stop(self):
        """Waits for all that was begun."""
        self._ending.set()
        for thread in self._threads:
            thread.join()

    def _run(self, at):
        random_ = random.Random(f"{self._seed} {at}")
        while not self._ending.is_set():
            deeds = self.deeds
            deed = random_.choices(deeds, [12, 4, 2, 2][:len(deeds)])[0]
            try:
                deed(random_)
            except (OSError, ValueError, KeyError) as error:
                self._fault(deed.__name__, repr(error))

    def _fault(self, *what):
        with self._lock:
            self.faults.append(what)

    def _count(self, what):
        with self._lock:
            self.counts[what] += 1

    def _reply(self, *request):
        """Of a request that is sent again as 503 with Retry-After allows, for as long as a balancer needs."""
        phase, began = self.phase, time.monotonic()
        for _ in range(10):
            reply = self._balancer.ask(*request)
            if reply[0] != 503 or "retry-after" not in reply[1]:
                break
            self._count("sent again")
            time.sleep(0.5)
        with self._lock:
            self.seconds[phase].append(time.monotonic() - began)
        return reply

    def only_ask(self):
        """From now on nothing is asked that needs the bucket."""
        self.deeds = self.deeds[:2]

    def _compared(self, question, reply):
        status, headers, body = reply
        if status != 200:
            return self._fault(question, status, body[:200])
        # A weak tag promises less than the bytes (openapi.yaml): such are counted, and not compared.
        tag = headers.get("etag", "")
        with self._lock:
            self.counts["compared" if not tag.startswith("W/") else "weak"] += 1
            before = self._first.setdefault(question, (tag, hashlib.sha256(body).digest()))
        if before[0] != tag or (not tag.startswith("W/") and before[1] != hashlib.sha256(body).digest()):
            self._fault(question, "another reply", tag, before[0])
        return None

    def _ask(self, random_):
        question = f"/v1/meshes/{random_.choice(self._meshes)}/{question_of(random_, SIDE * SIDE)}"
        self._compared(question, self._reply("GET", question))

    def _post(self, random_):
        path = f"/v1/meshes/{random_.choice(self._meshes)}/distance"
        body = json.dumps({"from": [f"v:{random_.randrange(SIDE * SIDE)}"]})
        self._compared(f"{path} {body}", self._reply("POST", path, body, {"Content-Type": "application/json"}))

    def _upload(self, random_):
        data = mesh(8, random_.random())
        name = hashlib.sha256(data).hexdigest()
        status, _, body = self._reply("POST", "/v1/meshes", data)
        if status not in (200, 201):  # sent twice, it may be known already
            return self._fault("upload", status, body[:200])
        with self._lock:
            self.uploads[name] = data
        self._count("uploaded")
        # Whoever may upload may ask at once.
        self._compared(f"/v1/meshes/{name}/distance?from=v:1", self._reply("GET", f"/v1/meshes/{name}/distance?from=v:1"))
        return None

    def _job(self, random_):
        data = mesh(9, random_.random()) if random_.random() < 0.3 else None
        path = "/v1/meshes" if data else f"/v1/meshes/{random_.choice(self._meshes)}/distance?from=v:{random_.randrange(SIDE)}&method=exact"
        status, headers, body = self._reply("POST" if data else "GET", path, data, {"Prefer": "respond-async"})
        if status != 202:
            return self._fault("job", path, status, body[:200])
        job, state, kept = headers["location"], "queued", json.loads(body)["kept"]
        self._count("jobs that were kept" if kept else "jobs that were not kept")
        while state in ("queued", "running"):
            status, _, body = self._reply("GET", job)
            if status == 404 and not kept:  # the bucket had not taken it, and its server was killed
                return self._count("jobs that were not kept and are lost")
            if status != 200:
                return self._fault("job", job, status, body[:200])
            told = json.loads(body)
            state = told["state"]
        if self.may_be_told_later and state == "failed" and told["status"] == 503:  # what its request would have been told: later
            return self._count("jobs that could not be run just then")
        if state != "done":
            return self._fault("job", self.phase, path, told)
        status, _, body = self._reply("GET", f"{job}/result")
        if status == 404 and not kept:
            return self._count("jobs that were not kept and are lost")
        self._count("jobs")
        if told["attempt"] > 1:
            self._count("jobs begun again by a server")
        if status not in ((200, 201) if data else (200,)):
            return self._fault("job's result", status, body[:200])
        if data:
            with self._lock:
                self.uploads[hashlib.sha256(data).hexdigest()] = data
        return None


def stays_with_one(balancer, meshes):
    """Whether a question that is asked again is answered out of the cache of whoever answered before."""
    questions = [f"/v1/meshes/{id_}/distance?from=v:7&at=v:{at}&method=wavefront" for id_ in meshes for at in (3, 4)]
    for question in questions:
        balancer.ask("GET", question)
    # nginx has a cache of its own, by which it is not to be judged.
    again = [balancer.ask("GET", question, headers={"Authorization": "Bearer none"})[1].get("geo-cache") for question in questions]
    hits = again.count("hit") / len(again)
    # HAProxy may give one away to a server that has less to do.
    expect(f"{balancer.name}: a mesh stays with one server", hits >= (0.8 if balancer.shares else 1), hits)


def same_everywhere(fleet, meshes, random_):
    """Every server, each of which has taken some of the meshes, gives the same."""
    differing = 0
    for _ in range(60):
        question = f"/v1/meshes/{random_.choice(meshes)}/{question_of(random_, SIDE * SIDE)}"
        replies = [server.ask("GET", question) for server in fleet.servers]
        tags = {reply[1].get("etag") for reply in replies}
        weak = all((tag or "").startswith("W/") for tag in tags)
        differing += len(tags) != 1 or {reply[0] for reply in replies} != {200}
        differing += not weak and len({reply[2] for reply in replies}) != 1
    expect("three servers give the same bytes and tags", differing == 0, differing)
    lists = [sorted(server.ids()) for server in fleet.servers]
    expect("and the same list", lists[0] == lists[1] == lists[2] and set(meshes) <= set(lists[0]))


def under_load(fleet, balancer, meshes, seconds, seed):
    """Servers go and come while clients go on."""
    clients = Clients(balancer, meshes, seed)
    time.sleep(seconds / 4)
    fleet.servers[1].kill()
    time.sleep(seconds / 4)
    fleet.begin_again(1)
    time.sleep(seconds / 4)
    ended = fleet.servers[2].stop()
    fleet.begin_again(2)
    time.sleep(seconds / 4)
    clients.stop()
    name = balancer.name
    print(f"{name}: " + ", ".join(f"{count} {what}" for what, count in sorted(clients.counts.items())))
    expect(f"{name}: while one server is killed and one is stopped no request fails, and no reply is another",
           not clients.faults, len(clients.faults), *clients.faults[:5])
    counts = clients.counts
    # A bucket on a busy machine may be slow for a while, and jobs are taken all the same.
    expect(f"{name}: jobs are kept in the bucket", counts["jobs that were kept"] > counts["jobs that were not kept"], counts)
    expect(f"{name}: the one that was stopped ended well", ended == 0, ended)
    lost = [id_ for id_, data in clients.uploads.items()
            for server in fleet.servers[:2] if server.ask("GET", f"/v1/meshes/{id_}/source")[2] != data]
    expect(f"{name}: none of {len(clients.uploads)} uploads is lost", clients.uploads and not lost, lost[:3])


def removal_is_seen(fleet, meshes):
    """What one server deletes the others do not answer for any more."""
    gone = meshes.pop()
    question = f"/v1/meshes/{gone}/distance?from=v:0"
    warm = [server.ask("GET", question)[0] for server in fleet.servers]
    status = fleet.servers[0].ask("DELETE", f"/v1/meshes/{gone}")[0]
    began = time.monotonic()
    at_once = fleet.servers[0].ask("GET", question)[0]
    others = fleet.servers[1:]
    while others and time.monotonic() < began + SEEN_WITHIN:
        others = [server for server in others if server.ask("GET", question)[0] != 404]
        time.sleep(0.2)
    expect("what one server deletes is gone there at once", (warm, status, at_once) == ([200] * SERVERS, 204, 404),
           warm, status, at_once)
    expect("and for the others within 40 seconds", not others)
    print(f"after {time.monotonic() - began:.0f} s")


def goes_on_without_s3(fleet, balancer, meshes, there):
    """What is warm is answered while nobody can reach the bucket."""
    questions = [f"/v1/meshes/{id_}/distance?from=v:{{}}" for id_ in meshes]
    for server in fleet.servers:  # those that have just come back are not given their meshes at once
        for question in questions:
            server.ask("GET", question.format(1))
    os.kill(there.proxy, signal.SIGSTOP)
    try:
        began = time.monotonic()
        answered = [balancer.ask("GET", question.format(at))[0] for at in (2, 3) for question in questions]
        expect(f"{balancer.name}: without S3 what is warm is answered", set(answered) == {200}, collections.Counter(answered))
        expect("and nobody waits for S3", time.monotonic() - began < 10, time.monotonic() - began)
    finally:
        os.kill(there.proxy, signal.SIGCONT)


def main():
    """Both balancers; exits with 1 if something was not so."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("--seconds", type=float, default=16, help="of load on each balancer")
    arguments = parser.parse_args()
    seed = os.environ.get("GEODESICD_SEED") or str(random.randrange(1 << 32))
    print(f"GEODESICD_SEED={seed}", flush=True)
    random_ = random.Random(seed)
    with bucket() as there:
        if there is None:
            return 77
        for kind in (Nginx, HAProxy):
            fleet = Fleet(os.path.abspath(arguments.program), there, kind.name)
            balancer = kind(there.folder / kind.name, fleet.ports)
            try:
                expect(f"{kind.name} finds its configuration in order", balancer.is_well, balancer.checked)
                files = [mesh(SIDE, random_.random()) for _ in range(SHARED)]
                taken = [balancer.ask("POST", "/v1/meshes", data)[0] for data in files]
                expect(f"{kind.name}: uploads are taken", set(taken) == {201}, taken)
                meshes = [hashlib.sha256(data).hexdigest() for data in files]
                stays_with_one(balancer, meshes)
                same_everywhere(fleet, meshes, random_)
                under_load(fleet, balancer, meshes, arguments.seconds, seed)
                goes_on_without_s3(fleet, balancer, meshes, there)
            finally:
                balancer.stop()
                if kind is HAProxy:
                    removal_is_seen(fleet, meshes)
                fleet.end()
        if failures:
            for line in (there.folder / "log").read_text(errors="replace").splitlines()[-30:]:
                print(f"  server: {line}")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
