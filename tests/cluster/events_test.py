#!/usr/bin/env python3
"""What happens to a fleet, one thing after the other, under clients that never stop.

    events_test.py GEODESICD [--cut-off SECONDS]

Three servers on one bucket of a real S3 server, behind nginx as deploy/nginx/fleet.conf configures it.
While clients ask, upload and start jobs, each server is killed and started again, one is stopped in
order, one is cut off from the bucket for a minute, the bucket is slow (2 s a request), all are cut off,
a fourth server is added, and all are replaced one by one. No request may fail after the retries that
HTTP allows, no reply may be another, no acknowledged upload may be lost. Only the meshes that consistent
hashing reassigns may move (nginx's `hash … consistent`), so caches keep as much as it leaves them.

Three servers spend no more processor time on a query than one does. And behind HAProxy, a mesh that
everybody asks about is served by several of them.

GEODESICD_SEED=NUMBER sets what is drawn; it is printed. Skipped where there is no S3 server.
"""

import argparse
import collections
import concurrent.futures
import hashlib
import itertools
import os
import pathlib
import random
import re
import signal
import statistics
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "crash"), str(HERE.parent / "s3")]

import fleet_test  # noqa: E402
from balancers import HAProxy, Nginx  # noqa: E402
from fleet_test import SERVERS, SIDE, Clients, Fleet, expect, question_of  # noqa: E402
from measure_costs import cpu_of  # noqa: E402
from ring import Ring, hash_of  # noqa: E402
from service import mesh  # noqa: E402
from swift_bucket import bucket  # noqa: E402
from wire import Wire  # noqa: E402

MESHES = 24
KEYS_SHARED = 400  # random ids, of which it is checked to which server they are sent
SLOW = 2.0  # seconds
PAST_CACHE = {"Authorization": "Bearer none"}  # nginx has a cache of its own
# Who answered.
NGINX_TELLS = [(r"add_header X-Cache \$upstream_cache_status;", "add_header X-Served-By $upstream_addr always;")]
HAPROXY_TELLS = [(r"option httpchk GET", "http-response set-header X-Served-By %s\n  option httpchk GET")]


def servers_of(balancer, keys):
    """Which port answers for each mesh's id."""
    ports = []
    for key in keys:
        # Half an id, so that no server looks for it.
        headers = balancer.ask("GET", f"/v1/meshes/{key[:32]}/distance?from=v:0", headers=PAST_CACHE)[1]
        ports.append(int(headers["x-served-by"].rpartition(":")[2]))
    return ports


def by_ring(ports, keys):
    """The same as the ring has it."""
    ring = Ring([f"127.0.0.1:{port}" for port in ports])
    return [ports[ring.server(ring.points_of(hash_of(key[:16])))] for key in keys]


def hit_rate(balancer, meshes, offset):
    """The share of questions that are answered out of a cache. With an `offset` not used before, none can be."""
    questions = [f"/v1/meshes/{id_}/distance?from=v:{offset}&at=v:{at}&method=wavefront" for id_ in meshes for at in (3, 4)]
    return [balancer.ask("GET", question, headers=PAST_CACHE)[1].get("geo-cache") for question in questions].count(
        "hit") / len(questions)


def wait_until_ready(server):
    """A balancer may ask it."""
    end = time.monotonic() + 30
    while server.ask("GET", "/readyz?exclude=store")[0] != 200:
        if time.monotonic() > end:
            raise TimeoutError("a server is not ready")
        time.sleep(0.1)


def source_status(server, id_, data):
    """The status of a mesh's bytes, as soon as the bucket answers; 0: they are others."""
    end = time.monotonic() + 60
    while True:
        status, _, body = server.ask("GET", f"/v1/meshes/{id_}/source")
        if status != 503 or time.monotonic() > end:
            return 0 if status == 200 and body != data else status
        time.sleep(0.5)


class Events:
    """The events, each a phase of the clients' load."""

    def __init__(self, fleet, balancer, wires, clients, cut_off):
        self._fleet, self._balancer, self._wires, self._clients = fleet, balancer, wires, clients
        self._cut_off = cut_off

    def _begin(self, phase, seconds=0.0):
        self._clients.phase = phase
        time.sleep(seconds)

    def all(self, meshes, keys):
        """One after the other."""
        fleet, wires = self._fleet, self._wires
        self._begin("before", 6)
        for at in range(SERVERS):
            self._begin("one is killed", 0)
            fleet.servers[at].kill()
            time.sleep(3)
            fleet.begin_again(at)
            time.sleep(3)
        self._begin("one is stopped")
        ended = fleet.servers[0].stop()
        expect("the one that was stopped ended well", ended == 0, ended)
        fleet.begin_again(0)
        time.sleep(3)
        self._begin("one is cut off")
        wires[1].cut = True
        time.sleep(self._cut_off)
        wires[1].cut = False
        self._begin("the bucket is slow")
        for wire in wires:
            wire.seconds = SLOW
        time.sleep(15)
        for wire in wires:
            wire.seconds = 0.0
        self._begin("after", 6)
        self._add_fourth(meshes, keys)
        self._begin("all are replaced")
        for at in range(SERVERS + 1):
            ended = fleet.servers[at].stop()
            expect(f"server {at + 1} was replaced", ended == 0, ended)
            fleet.begin_again(at)
            wait_until_ready(fleet.servers[at])
        self._begin("after all", 6)
        self._clients.only_ask()
        time.sleep(SLOW + 5)  # what was begun has ended
        for server in fleet.servers:
            for id_ in meshes:
                server.ask("GET", f"/v1/meshes/{id_}/distance?from=v:1")
        self._begin("all are cut off")
        for wire in wires:
            wire.cut = True
        time.sleep(12)
        for wire in wires:
            wire.cut = False

    def _add_fourth(self, meshes, keys):
        fleet, balancer = self._fleet, self._balancer
        before = servers_of(balancer, keys)
        expect("each mesh goes where the ring says", before == by_ring(fleet.ports[:SERVERS], keys))
        hit_rate(balancer, meshes, 7)
        kept = hit_rate(balancer, meshes, 7)
        expect("with three servers each mesh stays with one", kept == 1, kept)
        self._begin("a fourth is added")
        fleet.begin_again(SERVERS)
        wait_until_ready(fleet.servers[SERVERS])
        file = balancer.folder / "fleet.conf"
        last = f"server 127.0.0.1:{fleet.ports[SERVERS - 1]} max_fails=3 fail_timeout=2s;"
        text = file.read_text(encoding="utf-8")
        assert last in text
        file.write_text(text.replace(last, f"{last}\n  {last.replace(str(fleet.ports[SERVERS - 1]), str(fleet.ports[SERVERS]))}"))
        balancer.process.send_signal(signal.SIGHUP)
        time.sleep(2)
        kept = hit_rate(balancer, meshes, 7)
        was, is_now = (by_ring(fleet.ports[:count], meshes) for count in (SERVERS, SERVERS + 1))
        ideal = sum(a == b for a, b in zip(was, is_now)) / len(meshes)
        after = servers_of(balancer, keys)
        moved = sum(a != b for a, b in zip(before, after)) / len(keys)
        print(f"of {len(keys)} meshes {moved:.3f} moved, 1 of {SERVERS + 1} being {1 / (SERVERS + 1):.3f}; "
              f"{kept:.3f} of what was kept is still found, by the ring {ideal:.3f}")
        expect("with a fourth server those meshes move that the ring says, and no others",
               after == by_ring(fleet.ports, keys) and all(b == fleet.ports[SERVERS] for a, b in zip(before, after) if a != b))
        expect("and caches keep what it leaves them, within 5 %", abs(kept - ideal) <= 0.05, kept, ideal)
        time.sleep(4)


def processor_per_query(program, there):
    """What processor time queries take of one server, and of three that have a third of the meshes each."""
    random_ = random.Random(5)
    files = [mesh(100, random_.random()) for _ in range(9)]
    ids = [hashlib.sha256(data).hexdigest() for data in files]
    spent = {}
    for count in (1, SERVERS):
        fleet = Fleet(program, there, f"busy{count}")
        for data in files:
            fleet.servers[0].ask("POST", "/v1/meshes", data)
        for sources in (range(1), range(1, 61)):  # first once, so that meshes are ready
            began = [cpu_of(server) for server in fleet.servers]
            for id_, source in itertools.product(ids, sources):
                status, _, _ = fleet.servers[int(id_, 16) % count].ask(
                    "GET", f"/v1/meshes/{id_}/distance?from=v:{source * 150}&format=f32")
                assert status == 200, status
        spent[count] = sum(cpu_of(server) - was for server, was in zip(fleet.servers, began))
        fleet.end()
    print(f"processor time of {60 * len(ids)} distance fields: {spent[1]:.2f} s by one server, {spent[SERVERS]:.2f} s by three")
    expect("three servers do at least 0.9 of what three single ones do", spent[1] / spent[SERVERS] >= 0.9, spent)


def hot_mesh(program, there):
    """A mesh that everybody asks about, behind HAProxy."""
    fleet = Fleet(program, there, "hot")
    balancer = HAProxy(there.folder / "hot", fleet.ports, HAPROXY_TELLS)
    try:
        data = mesh(60, 1)
        id_ = hashlib.sha256(data).hexdigest()
        expect("HAProxy: a mesh is taken", balancer.ask("POST", "/v1/meshes", data)[0] == 201)
        with concurrent.futures.ThreadPoolExecutor(12) as crowd:
            replies = list(crowd.map(lambda at: balancer.ask(
                "GET", f"/v1/meshes/{id_}/distance?from=v:{at}&method=exact&at=v:0"), range(240)))
        shares = collections.Counter(headers.get("x-served-by") for _, headers, _ in replies)
        print("a hot mesh: " + ", ".join(f"{share} by {name}" for name, share in shares.most_common()))
        expect("HAProxy: all queries about a hot mesh are answered", {status for status, _, _ in replies} == {200})
        # hash-balance-factor 150: at no moment has a server more than half as much again as the mean of three.
        expect("and several servers share them", max(shares.values()) <= 0.6 * len(replies), shares)
    finally:
        balancer.stop()
        fleet.end()


def main():
    """All of it; exits with 1 if something was not so."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("--cut-off", type=float, default=60, help="seconds for which one server is without its bucket")
    arguments = parser.parse_args()
    program = os.path.abspath(arguments.program)
    seed = os.environ.get("GEODESICD_SEED") or str(random.randrange(1 << 32))
    print(f"GEODESICD_SEED={seed}", flush=True)
    random_ = random.Random(seed)
    with bucket() as there:
        if there is None:
            return 77
        port = int(re.search(r":(\d+)$", there.endpoint)[1])
        wires = [Wire(port) for _ in range(SERVERS + 1)]
        fleet = Fleet(program, there, "events", [f"http://127.0.0.1:{wire.port}" for wire in wires])
        balancer = Nginx(there.folder / "nginx", fleet.ports[:SERVERS], NGINX_TELLS)
        try:
            files = [mesh(SIDE, random_.random()) for _ in range(MESHES)]
            expect("uploads are taken", {balancer.ask("POST", "/v1/meshes", data)[0] for data in files} == {201})
            meshes = [hashlib.sha256(data).hexdigest() for data in files]
            keys = [f"{random_.getrandbits(256):064x}" for _ in range(KEYS_SHARED)]
            clients = Clients(balancer, meshes, seed)
            clients.may_be_told_later = True
            try:
                Events(fleet, balancer, wires, clients, arguments.cut_off).all(meshes, keys)
            finally:
                clients.stop()
            print(", ".join(f"{count} {what}" for what, count in sorted(clients.counts.items())))
            print(f"{'':20} {'requests':>9} {'median':>9} {'99 %':>9}")
            for phase, seconds in clients.seconds.items():
                ninety_nine = sorted(seconds)[int(0.99 * len(seconds))]
                print(f"{phase:20} {len(seconds):9} {1e3 * statistics.median(seconds):6.0f} ms {1e3 * ninety_nine:6.0f} ms")
            expect("no request failed, and no reply was another", not clients.faults, len(clients.faults), *clients.faults[:5])
            lost = [(id_, status) for id_, data in clients.uploads.items()
                    if (status := source_status(fleet.servers[0], id_, data)) != 200]
            expect(f"none of {len(clients.uploads)} uploads is lost", clients.uploads and not lost, lost[:3])
        finally:
            balancer.stop()
            fleet.end()
            for wire in wires:
                wire.stop()
        processor_per_query(program, there)
        hot_mesh(program, there)
        if fleet_test.failures:
            for line in (there.folder / "log").read_text(errors="replace").splitlines()[-30:]:
                print(f"  server: {line}")
    return 1 if fleet_test.failures else 0


if __name__ == "__main__":
    sys.exit(main())
