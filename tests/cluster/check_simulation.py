#!/usr/bin/env python3
"""The simulation against three real servers behind nginx.

    in_simpy.sh check_simulation.py GEODESICD [--seconds N] [--rate R] [--runs N]

Three servers, each with a folder that has all meshes and with small caches, are asked through nginx as
deploy/nginx/fleet.conf configures it, past its cache, while costs are measured with a fourth one
(measure_costs.py), for CPU takes longer on a machine that is busy: queries come as a Poisson process,
whatever comes back, about meshes that have Zipf's distribution. Each server has to get just the queries that the ring says. Hit rates, reads of the store
and CPU have to be within 15 % of what the simulation says. So have the median and the 99th percentile of
times, where nobody else uses the machine meanwhile; else they are only printed.

nginx also has to take its configuration with 1,000 servers.

GEODESICD_SEED=NUMBER sets what is drawn; it is printed. Skipped where there is no nginx.
"""

import argparse
import http.client
import os
import pathlib
import queue
import random
import shutil
import subprocess
import sys
import tempfile
import threading
import time

import numpy as np

sys.path[:0] = [str(pathlib.Path(__file__).resolve().parents[1] / "crash")]

import nginx  # noqa: E402
from balancers import Nginx, nginx_command  # noqa: E402
from costs import quantiles  # noqa: E402
from measure_costs import TICK, Line, cpu_of, measured, metrics_of, question  # noqa: E402
from popularity import GivenMeshes, Zipf  # noqa: E402
from ports import free_port  # noqa: E402
from replica import Settings  # noqa: E402
from ring import Ring, hash_of  # noqa: E402
from service import Service, digest, mesh  # noqa: E402
from simulate import Fleet  # noqa: E402

SERVERS, MESHES, QUESTIONS, EXPONENT = 3, 200, 10, 0.9
SETTINGS = Settings(compute_threads=1, mesh_cache_bytes=8 << 20, adjacency_cache_bytes=24 << 20,
                    field_cache_bytes=1 << 20, reply_cache_bytes=2 << 20)
FLAGS = ["--compute-threads", str(SETTINGS.compute_threads), *(
    word for cache in ("mesh", "adjacency", "field", "reply")
    for word in (f"--{cache}-cache-bytes", str(getattr(SETTINGS, f"{cache}_cache_bytes"))))]
SIDES = (24, 34, 48, 68, 90, 120)  # of the meshes that costs are measured with
CLIENTS = 24
PROBES = 1200
WITHIN = 0.15
QUIET = 0.15  # of the machine, taken by others

failures = 0


def expect(what, is_so, *details):
    """Prints a line about one thing that must be so."""
    global failures
    failures += not is_so
    print(("ok: " if is_so else "FAILED: ") + what, *(() if is_so else details), flush=True)


def machine_seconds():
    """CPU seconds that all processes have taken, and that were taken from this machine."""
    with open("/proc/stat", encoding="utf-8") as stat:
        times = list(map(int, stat.readline().split()[1:9]))
    return (sum(times) - times[3] - times[4]) * TICK


class Clients:
    """Threads with a connection each, which ask what they are given when it is due.

    Of the last `ask`: `latencies`; and each less the server's steps, `around` those of computed replies,
    `around_kept` those of kept ones."""

    def __init__(self, balancer, names):
        self._names, self._due = names, queue.Queue()
        self.latencies, self.around, self.around_kept, self.faults = [], [], [], []
        # Past nginx's cache.
        self._make = lambda: Line(balancer.port, 0, {"Authorization": "Bearer none"}, http.client.HTTPSConnection,
                                  context=balancer.trusting)
        self._threads = [threading.Thread(target=self._run) for _ in range(CLIENTS)]
        for thread in self._threads:
            thread.start()

    def path(self, query):
        """What is asked: (mesh, number of the question)."""
        number, which = query
        return question(self._names[number - 1], which * 7)

    def _run(self):
        line = self._make()
        while (given := self._due.get()) is not None:
            when, query = given
            try:
                line.ask(self.path(query))
                latency = time.perf_counter() - when
                self.latencies.append(latency)
                around = self.around_kept if line.kept else self.around
                around.append(max(latency - sum(line.stages.values()), 0))
            except (OSError, RuntimeError, http.client.HTTPException) as error:
                self.faults.append(repr(error))
                line = self._make()
            finally:
                self._due.task_done()

    def ask(self, queries, gaps):
        """Has each query asked so long after the one before, and waits for all replies."""
        self.latencies, self.around, self.around_kept = [], [], []
        when = time.perf_counter()
        for query, gap in zip(queries, gaps):
            when += gap
            time.sleep(max(when - time.perf_counter(), 0))
            self._due.put((when, query))
        self._due.join()

    def finish(self):
        """Ends the threads."""
        for _ in self._threads:
            self._due.put(None)
        for thread in self._threads:
            thread.join()


def drawn(zipf, random_, count):
    """Queries: pairs of a mesh, the one asked about most being 1, and a question about it."""
    return list(zip(zipf.draw(random_, count).tolist(), random_.integers(QUESTIONS, size=count).tolist()))


def difference(before, after, name):
    """By how much a metric has grown, over all servers."""
    return sum(late.get(name, 0) - early.get(name, 0) for early, late in zip(before, after))


class Measuring(threading.Thread):
    """Measures costs beside other things."""

    def __init__(self, measure):
        super().__init__()
        self._measure, self._costs = measure, None

    def run(self):
        self._costs = self._measure()

    def costs(self):
        """What it found, once it has."""
        self.join()
        if self._costs is None:
            raise RuntimeError("costs could not be measured")
        return self._costs


def observed(servers, balancer, ring, names, arguments, random_, measure):
    """What the servers do: the figures, what a query takes beside its steps, and how busy others were."""
    zipf = Zipf(len(names), EXPONENT)
    asked = drawn(zipf, random_, int(arguments.rate * arguments.seconds))
    clients = Clients(balancer, names)
    # Caches become as they are after long use, and connections are made.
    clients.ask(drawn(zipf, random_, len(asked)), [0] * len(asked))
    measure.start()
    # What nginx, connections and the clients themselves take, asked as below.
    clients.ask(drawn(zipf, random_, PROBES), random_.exponential(1 / arguments.rate, PROBES).tolist())
    around = quantiles(clients.around), quantiles(clients.around_kept)
    before, cpu = [metrics_of(server) for server in servers], sum(map(cpu_of, servers))
    machine, mine, began = machine_seconds(), time.process_time(), time.monotonic()
    clients.ask(asked, random_.exponential(1 / arguments.rate, len(asked)).tolist())
    lasted = time.monotonic() - began
    others, mine = machine_seconds() - machine, time.process_time() - mine
    after, cpu = [metrics_of(server) for server in servers], sum(map(cpu_of, servers)) - cpu
    clients.finish()
    if clients.faults:
        raise RuntimeError(f"queries failed: {clients.faults[:3]}")
    expected = [0] * SERVERS
    for number, _ in asked:
        expected[ring.server(ring.points_of(hash_of(names[number - 1][:16])))] += 1
    count = 'geodesicd_requests_total{method="GET",route="/v1/meshes/{id}/distance",status="200"}'
    expect("each server gets just the queries that the ring says",
           expected == [late[count] - early[count] for early, late in zip(before, after)], expected)
    share = lambda name: difference(before, after, name) / len(asked)  # noqa: E731
    hits = {cache: share(f'geodesicd_cache_lookups_total{{cache="{cache}",result="hit"}}')
            for cache in ("replies", "adjacency")}
    figures = {"kept replies": hits["replies"], "kept meshes": hits["replies"] + hits["adjacency"],
               "reads of the store": share('geodesicd_cache_makes_total{cache="meshes"}'),
               "CPU, ms": cpu / len(asked) * 1e3,
               "median, ms": float(np.quantile(clients.latencies, 0.5)) * 1e3,
               "99 %, ms": float(np.quantile(clients.latencies, 0.99)) * 1e3}
    # nginx and the fourth server are counted among the others: they take little.
    return figures, around, (others - cpu - mine) / (lasted * os.cpu_count())


def predicted(costs, ring, names, vertices, arguments, seed):
    """The same figures, of the simulation; of more queries, so that they are surer."""
    meshes = GivenMeshes([hash_of(name[:16]) for name in names], vertices, EXPONENT)
    fleet = Fleet(costs, SETTINGS, meshes, ring, SERVERS, QUESTIONS, seed)
    fleet.warm(20_000, SETTINGS.adjacency_cache_bytes)
    outcome = fleet.run(40_000, arguments.rate)
    return {"kept replies": outcome.reply_hits, "kept meshes": outcome.mesh_hits,
            "reads of the store": outcome.store_reads, "CPU, ms": outcome.cpu_seconds * 1e3,
            "median, ms": outcome.quantile(0.5) * 1e3, "99 %, ms": outcome.quantile(0.99) * 1e3}


def holds_many_servers(folder, count):
    """Whether nginx takes its configuration with so many servers, which share the memory of its `zone`."""
    folder.mkdir()
    lines = "".join(f"  server 10.1.{at >> 8}.{at & 255}:8080 max_fails=3 fail_timeout=2s;\n" for at in range(count))
    command = nginx_command(folder, free_port(), [(r"(?: *server 10\..*\n)+", lines)])
    checked = subprocess.run([*command, "-t"], capture_output=True, text=True, check=False)
    expect(f"nginx finds its configuration with {count} servers in order", checked.returncode == 0, checked.stderr)


def compare(said, seen, others):
    """A row for each figure."""
    print("| figure | simulated | measured | off |\n|---|--:|--:|--:|")
    for figure, amount in said.items():
        print(f"| {figure} | {amount:.3g} | {seen[figure]:.3g} | {amount / seen[figure] - 1:+.0%} |")
    print(f"others took {others:.0%} of the machine meanwhile")
    judged = ["kept replies", "kept meshes", "reads of the store", "CPU, ms"]
    if others < QUIET:
        judged += ["median, ms", "99 %, ms"]
    else:
        print("so times are not judged")
    for figure in judged:
        expect(f"{figure}: within {WITHIN:.0%}", abs(said[figure] / seen[figure] - 1) <= WITHIN)


def check(program, folder, arguments, seed):
    """One run, all anew."""
    random_, numbers = random.Random(seed), np.random.default_rng(seed)
    log = folder / "log"
    filler = Service(program, ["--store", str(folder / "0"), "--log-level", "warn"], log)
    names, vertices = [], []
    for _ in range(MESHES):
        side = int(np.clip(np.exp(numbers.normal(np.log(45), 0.35)), 16, 120))
        data = mesh(side, random_.random())
        if filler.ask("POST", "/v1/meshes", data)[0] != 201:
            raise RuntimeError("an upload is not taken")
        names.append(digest(data))
        vertices.append(side * side)
    filler.stop()
    for at in range(1, SERVERS):
        shutil.copytree(folder / "0", folder / str(at))
    ports = [free_port() for _ in range(SERVERS)]
    servers = [Service(program, ["--store", str(folder / str(at)), "--log-level", "warn", *FLAGS], log, port=port)
               for at, port in enumerate(ports)]
    ring = Ring([f"127.0.0.1:{port}" for port in ports])
    balancer = Nginx(folder / "nginx", ports)
    try:
        measure = Measuring(lambda: measured(program, folder / "costs", SIDES, 14, 0.03, random_, FLAGS[:2]))
        seen, around, others = observed(servers, balancer, ring, names, arguments, numbers, measure)
    finally:
        balancer.stop()
        for server in servers:
            server.stop()
    costs = measure.costs()
    costs.around, costs.around_kept = around
    compare(predicted(costs, ring, names, vertices, arguments, int(numbers.integers(1 << 32))), seen, others)


def main():
    """Exits with 1 if something was not so."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("--seconds", type=float, default=120, help="of queries")
    parser.add_argument("--rate", type=float, default=60, help="queries a second")
    parser.add_argument("--runs", type=int, default=1)
    arguments = parser.parse_args()
    if nginx.program() is None:
        print("skipped: there is no nginx")
        return 77
    seed = int(os.environ.get("GEODESICD_SEED") or random.randrange(1 << 32))
    print(f"GEODESICD_SEED={seed}", flush=True)
    with tempfile.TemporaryDirectory(prefix="check_") as name:
        holds_many_servers(pathlib.Path(name, "many"), 1000)
    for run in range(arguments.runs):
        with tempfile.TemporaryDirectory(prefix="check_") as name:
            check(os.path.abspath(arguments.program), pathlib.Path(name), arguments, seed + run)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
