#!/usr/bin/env python3
"""Many servers behind a balancer, simulated: hit rates, times and cost.

    in_simpy.sh simulate.py COSTS [--replicas N,…] [--meshes N,…] [--rate R | --rate-each R] [OPTION…]

COSTS is what measure_costs.py has written. Prints a row for each number of replicas and of meshes.
Queries come as a Poisson process, and ask for a whole field; what they are about has Zipf's distribution.
The balancer is nginx (deploy/nginx/fleet.conf: the mesh's server, and after a 503 the next two on the
ring), or with --balance bounded one that gives away what a server has half as much again of than the
others (deploy/haproxy/haproxy.cfg). Not simulated: the network, nginx's own cache, jobs, uploads.

SimPy runs the processes of queries that are computed; known replies need none, so that millions of
queries and 1,000 replicas are a matter of minutes.
"""

import argparse
import dataclasses
import math
import sys

import numpy as np
import simpy

from costs import drawn_from, read_costs
from popularity import Meshes
from replica import Refused, Replica, Settings
from ring import ring_of

TRIES = 3  # proxy_next_upstream_tries
CHUNK = 50_000  # queries drawn at a time
BALANCE_FACTOR = 1.5  # hash-balance-factor


@dataclasses.dataclass
class Outcome:
    """What a run came to."""

    queries: int
    refused: int  # after all tries
    seconds: float
    latencies: np.ndarray
    reply_hits: float  # of all queries, those answered by a kept reply
    mesh_hits: float  # of all queries, those by such a one or on a mesh that was prepared
    store_reads: float  # for a query
    store_bytes_a_second: float
    cpu_seconds: float  # for a query
    hottest: float  # CPU of the busiest replica, as a multiple of the mean
    busiest: float  # and as a share of its cores

    def quantile(self, at):
        """Of the seconds that answered queries took."""
        return float(np.quantile(self.latencies, at)) if self.latencies.size else math.inf


class Fleet:
    """Replicas and their balancer. `meshes` and `ring` say what there is and whose it is."""

    def __init__(self, costs, settings, meshes, ring, replicas, questions, seed, bounded=False):
        self._costs, self._meshes, self._ring, self._questions = costs, meshes, ring, questions
        self._cores, self._bounded = settings.compute_threads, bounded
        self._random = np.random.default_rng(seed)
        self._env = simpy.Environment()
        self.replicas = [Replica(self._env, costs, settings) for _ in range(replicas)]
        self._inside = 0  # of all replicas
        self._latencies, self._refused = [], 0

    def _drawn(self, count):
        """The next queries, each with its point on the ring: lists, which Python goes through faster."""
        numbers = self._meshes.draw(self._random, count)
        keys = numbers * self._questions + self._random.integers(self._questions, size=count)
        points = self._ring.points_of(self._meshes.hashes(numbers))
        return list(zip(zip(keys.tolist(), numbers.tolist(), self._meshes.vertices(numbers).tolist()),
                        points.tolist()))

    def _fill(self, budget):
        """The meshes asked about most, down from those that fill all caches twice."""
        mean = self._costs.of("bytes", "adjacency", float(np.mean(self._meshes.vertices(
            np.arange(1, min(self._meshes.count, 10_000) + 1)))))
        last = min(self._meshes.count, int(2 * budget * len(self.replicas) / mean) + 1)
        for begin in range(last, 0, -CHUNK):
            numbers = np.arange(begin, max(begin - CHUNK, 0), -1)
            owners = self._ring.server(self._ring.points_of(self._meshes.hashes(numbers)))
            sizes = self._costs.of("bytes", "adjacency", self._meshes.vertices(numbers))
            for number, size, owner in zip(numbers.tolist(), sizes.tolist(), owners.tolist()):
                self.replicas[owner].prepared.keep(number, size)

    def warm(self, queries, budget):
        """Brings the caches to where they are after long use: meshes by rank, then so many queries."""
        self._fill(budget)
        while queries > 0:
            for query, point in self._drawn(min(CHUNK, queries)):
                self.replicas[self._ring.server(point)].recall(query)
            queries -= CHUNK
        for replica in self.replicas:
            replica.begin()

    def _at(self, point, tries):
        """The server that a query is given to after so many refusals: of the mesh's, in the ring's order,
        the next one that is not full."""
        seen = []
        while True:
            server = int(self._ring.server(point))
            point += 1
            if server in seen:
                continue
            seen.append(server)
            if not self._is_full(server):
                if tries == 0:
                    return server
                tries -= 1
            if len(seen) == len(self.replicas):
                return server

    def _is_full(self, server):
        if not self._bounded:
            return False
        most = math.ceil(BALANCE_FACTOR * (self._inside + 1) / len(self.replicas))
        return self.replicas[server].inside >= most

    def _answer(self, query, point, around, slowness):
        """The process of a query that is not known where it first came."""
        began = self._env.now
        for tries in range(min(TRIES, len(self.replicas))):
            replica = self.replicas[self._at(point, tries)]
            if tries and replica.knows(query[0]):
                break
            self._inside += 1
            try:
                yield from replica.compute(query, slowness)
                break
            except Refused:
                continue
            finally:
                self._inside -= 1
        else:
            self._refused += 1
            return
        self._latencies.append(self._env.now - began + around)

    def _arrivals(self, queries, rate):
        left = queries
        while left > 0:
            count = min(CHUNK, left)
            gaps = self._random.exponential(1 / rate, count).tolist()
            around = drawn_from(self._costs.around, self._random, count).tolist()
            around_kept = drawn_from(self._costs.around_kept, self._random, count).tolist()
            slowness = drawn_from(self._costs.spread, self._random, count).tolist()
            for (query, point), gap, beside, beside_kept, slow in zip(self._drawn(count), gaps, around,
                                                                      around_kept, slowness):
                yield self._env.timeout(gap)
                if self.replicas[self._at(point, 0)].knows(query[0]):
                    self._latencies.append(beside_kept)
                else:
                    self._env.process(self._answer(query, point, beside, slow))
            left -= count

    def run(self, queries, rate):
        """So many queries at a rate a second; all that came are answered before it ends."""
        self._env.process(self._arrivals(queries, rate))
        self._env.run()
        total, cpu = queries, np.array([replica.cpu_seconds for replica in self.replicas])
        asked = sum(replica.queries for replica in self.replicas)  # with those that another one refused
        each = lambda what: sum(what(replica) for replica in self.replicas) / asked  # noqa: E731
        return Outcome(
            queries=total, refused=self._refused, seconds=self._env.now, latencies=np.array(self._latencies),
            reply_hits=each(lambda replica: replica.replies.hits),
            mesh_hits=each(lambda replica: replica.replies.hits + replica.prepared.hits),
            store_reads=each(lambda replica: replica.meshes.makes),
            store_bytes_a_second=sum(replica.store_bytes for replica in self.replicas) / self._env.now,
            cpu_seconds=float(cpu.sum()) / total, hottest=float(cpu.max() / max(cpu.mean(), 1e-12)),
            busiest=float(cpu.max() / (self._env.now * self._cores)))


def memory_of(settings):
    """GB that a replica is given: docs/operating/memory.md, without room for large replies and uploads."""
    budgets = (settings.mesh_cache_bytes + settings.adjacency_cache_bytes + settings.field_cache_bytes
               + settings.reply_cache_bytes)
    return budgets / 1e9 + settings.compute_threads + 1  # --query-memory-bytes for each slot, and the rest


def cost_of(outcome, replicas, settings, core_hour, gb_hour):
    """(core-hours, cost) of what is rented for a million answered queries. What they use of it is less."""
    hours = outcome.seconds / 3600 * 1e6 / max(outcome.queries - outcome.refused, 1) * replicas
    return (hours * settings.compute_threads,
            hours * (settings.compute_threads * core_hour + memory_of(settings) * gb_hour))


def simulated(costs, settings, replicas, meshes, rate, arguments):
    """One run, from cold to its outcome."""
    meshes = Meshes(meshes, arguments.exponent, arguments.seed, arguments.median)
    fleet = Fleet(costs, settings, meshes, ring_of(replicas), replicas, arguments.questions, arguments.seed,
                  arguments.balance == "bounded")
    fleet.warm(max(arguments.warm, arguments.warm_each * replicas), settings.adjacency_cache_bytes)
    return fleet.run(max(arguments.queries, arguments.queries_each * replicas), rate)


def parsed():
    """The command line, and the settings in it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    numbers = lambda text: [int(part) for part in text.split(",")]  # noqa: E731
    parser.add_argument("costs")
    parser.add_argument("--replicas", type=numbers, default=[10])
    parser.add_argument("--meshes", type=numbers, default=[100_000])
    parser.add_argument("--rate", type=float, help="queries a second, of all; instead of --rate-each")
    parser.add_argument("--rate-each", type=float, default=100.0, help="queries a second for each replica")
    parser.add_argument("--exponent", type=float, default=0.9, help="of Zipf's law")
    parser.add_argument("--median", type=int, default=10_000, help="vertices of a mesh")
    parser.add_argument("--questions", type=int, default=100, help="different ones about a mesh")
    parser.add_argument("--queries", type=int, default=100_000, help="simulated at least")
    parser.add_argument("--queries-each", type=int, default=1000, help="and for each replica")
    parser.add_argument("--warm", type=int, default=300_000, help="queries before, at least")
    parser.add_argument("--warm-each", type=int, default=2000, help="and for each replica")
    parser.add_argument("--balance", choices=["nginx", "bounded"], default="nginx")
    parser.add_argument("--quiet", action="store_true",
                        help="as where nothing else runs: steps take what the lines say")
    parser.add_argument("--core-hour", type=float, default=0.04, help="its price")
    parser.add_argument("--gb-hour", type=float, default=0.005, help="its price")
    parser.add_argument("--seed", type=int, default=1)
    for field in dataclasses.fields(Settings):
        parser.add_argument("--" + field.name.replace("_", "-"), type=field.type, default=field.default)
    arguments = parser.parse_args()
    names = [field.name for field in dataclasses.fields(Settings)]
    return arguments, Settings(**{name: getattr(arguments, name) for name in names})


def main():
    """A table in Markdown."""
    arguments, settings = parsed()
    costs = read_costs(arguments.costs)
    if arguments.quiet:
        costs.spread = [1, 1]
        costs.around = [float(np.median(costs.around))] * 2
        costs.around_kept = [float(np.median(costs.around_kept))] * 2
    print("| replicas | meshes | queries/s | replies kept | meshes kept | p50 | p99 | refused | busiest replica "
          "| of the store | core-hours used | rented | cost |")
    print("|--:" * 13 + "|")
    for replicas in arguments.replicas:
        for meshes in arguments.meshes:
            rate = arguments.rate or arguments.rate_each * replicas
            outcome = simulated(costs, settings, replicas, meshes, rate, arguments)
            core_hours, cost = cost_of(outcome, replicas, settings, arguments.core_hour, arguments.gb_hour)
            print(f"| {replicas:,} | {meshes:,} | {rate:,.0f} | {outcome.reply_hits:.1%} | {outcome.mesh_hits:.1%} "
                  f"| {outcome.quantile(0.5) * 1e3:.1f} ms | {outcome.quantile(0.99) * 1e3:.0f} ms "
                  f"| {outcome.refused / outcome.queries:.2%} | {outcome.hottest:.1f} × mean, {outcome.busiest:.0%} "
                  f"| {outcome.store_bytes_a_second / 1e6:,.0f} MB/s | {outcome.cpu_seconds * 1e6 / 3600:.2f} "
                  f"| {core_hours:.1f} | {cost:.2f} |", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
