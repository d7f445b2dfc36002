#!/usr/bin/env python3
"""More queries than the server can compute.

    overload.py BUILD [--seconds N] [--times X] [--slack X] [OPTION...]

Measures one query at a time (unloaded), then the capacity, then sends X times the
capacity, evenly paced whatever comes back, and says how long the accepted and the
refused took, whether fields were computed for nobody, whether probes were answered throughout, and
how soon a query takes as long as before once the load has ended. The queries differ, so that no cache
answers them. OPTIONs go to the server. Exit status 1 if a bound is missed by more
than the slack.
"""

import argparse
import asyncio
import itertools
import random
import sys
import time

from http_client import Connection, timed_ask
from service import Checks, Service, describe, quantile


class Queries:
    """Questions that were not asked before."""

    def __init__(self, mesh):
        self._base = f"/v1/meshes/{mesh['id']}/distance?format=f32&from="
        self._faces = mesh["faces"]
        self._random = random.Random(1)

    def __next__(self):
        a, b = self._random.random() / 2, self._random.random() / 2
        return f"{self._base}f:{self._random.randrange(self._faces)},{a:.6f},{b:.6f}"


class Crowd:
    """Clients of an open loop: each request has one, and there is always another."""

    def __init__(self, port):
        self._port = port
        self._free = []
        self.tasks = set()
        self.accepted, self.refused, self.other = [], [], {}

    async def _ask(self, target):
        connection = self._free.pop() if self._free else Connection(self._port)
        begin = time.perf_counter()
        try:
            await connection.connect()
            status, _ = await connection.ask(target)
        except (OSError, asyncio.IncompleteReadError):
            status = 0
        taken = time.perf_counter() - begin
        if status == 200:
            self.accepted.append(taken)
        elif status in (429, 503):
            self.refused.append(taken)
        else:
            self.other[status] = self.other.get(status, 0) + 1
        if status:
            self._free.append(connection)

    def ask(self, target):
        """Sends a request without waiting for what was sent before."""
        task = asyncio.create_task(self._ask(target))
        self.tasks.add(task)
        task.add_done_callback(self.tasks.discard)

    def hang_up(self):
        """Everybody leaves."""
        for task in list(self.tasks):
            task.cancel()
        for connection in self._free:
            connection.close()


async def one_by_one(port, queries, seconds):
    """The times of queries that follow each other."""
    connection, times = Connection(port), []
    end = time.perf_counter() + seconds
    while time.perf_counter() < end:
        begin = time.perf_counter()
        status, _ = await connection.ask(next(queries))
        assert status == 200, status
        times.append(time.perf_counter() - begin)
    connection.close()
    return times


async def capacity(port, queries, seconds):
    """Queries a second, with a few always waiting."""
    times = await asyncio.gather(*(one_by_one(port, queries, seconds) for _ in range(8)))
    return sum(len(part) for part in times) / seconds


async def probe(service, stop):
    """The times of both probes, and how often they were not answered."""
    times, wrong = [], 0
    for path in itertools.cycle(("/livez", "/readyz")):
        if stop.is_set():
            return times, wrong
        status, taken = await timed_ask(service.admin_port, path)
        wrong += status != 200
        times.append(taken)
        await asyncio.sleep(0.05)


async def overload(service, rate, queries, seconds):
    """An evenly paced load; returns the crowd, and what the probes said."""
    crowd, stop = Crowd(service.port), asyncio.Event()
    probes = asyncio.create_task(probe(service, stop))
    begin = time.perf_counter()
    for number in itertools.count():
        due = begin + number / rate
        if due - begin > seconds:
            break
        delay = due - time.perf_counter()
        if delay > 0:
            await asyncio.sleep(delay)
        crowd.ask(next(queries))
    stop.set()
    return crowd, await probes


async def recovery(port, queries, usual):
    """Seconds until three queries in a row take no longer than they did before."""
    begin = time.perf_counter()
    connection, good, since = Connection(port), 0, 0.0
    while good < 3 and time.perf_counter() - begin < 30:
        asked = time.perf_counter()
        status, _ = await connection.ask(next(queries))
        now = time.perf_counter()
        if status == 200 and now - asked <= usual:
            since = since if good else asked - begin
            good += 1
        else:
            good = 0
    connection.close()
    return since if good == 3 else 30.0


async def measure(service, arguments, checks):
    """All of it; prints as it goes."""
    queries = Queries(service.mesh)
    await one_by_one(service.port, queries, 0.5)
    unloaded = await one_by_one(service.port, queries, min(5, arguments.seconds))
    print(f"{service.mesh['vertices']} vertices, one query at a time: {describe(unloaded)}")
    most = await capacity(service.port, queries, min(5, arguments.seconds))
    rate = arguments.times * most
    print(f"capacity {most:.0f}/s; now {rate:.0f}/s for {arguments.seconds} s", flush=True)
    before = service.solves()
    crowd, (probes, dead) = await overload(service, rate, queries, arguments.seconds)
    in_vain = service.solves() - before - len(crowd.accepted)
    threads, memory = service.stat("Threads"), service.stat("VmRSS") // 1024
    crowd.hang_up()
    back = await recovery(service.port, queries, 2 * quantile(unloaded, 0.99))
    print(f"accepted: {describe(crowd.accepted)}")
    print(f"refused: {describe(crowd.refused)}; others: {crowd.other or 'none'}")
    print(f"probes: {describe(probes)}; {threads} threads, {memory} MB")

    goodput = 100 * len(crowd.accepted) / (most * arguments.seconds)
    checks.at_least("answered, of the capacity", goodput, 80)
    # A queue is bounded by its places and by the time one may stand in it.
    bound = 2 * quantile(unloaded, 0.99) + min(arguments.queue / most, arguments.queue_seconds)
    checks.at_most("accepted, p99", 1000 * quantile(crowd.accepted, 0.99), 1000 * bound)
    checks.at_most("refused, p99", 1000 * quantile(crowd.refused, 0.99), 50)
    # What the slots are busy with is neither.
    busy = 100 * service.slots() / max(1, len(crowd.accepted))
    lost = 100 * in_vain / max(1, len(crowd.accepted))
    checks.at_most("fields computed for nobody", lost, 5 + 2 * busy, "%")
    checks.at_most("neither answered nor refused", sum(crowd.other.values()), 0, "")
    checks.at_most("probes not answered", dead, 0, "")
    checks.at_most("recovery", 1000 * back, 2000)


def main():
    """Runs it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("build")
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--times", type=float, default=5)
    parser.add_argument("--queue", type=int, default=256, help="the server's --queue")
    parser.add_argument("--queue-seconds", type=int, default=1, help="the server's")
    parser.add_argument("--slack", type=float, default=1.0)
    arguments, options = parser.parse_known_args()
    checks = Checks(arguments.slack)
    queue = ["--queue", str(arguments.queue), "--queue-seconds", str(arguments.queue_seconds)]
    with Service(arguments.build, *queue, *options) as service:
        asyncio.run(measure(service, arguments, checks))
    sys.exit(checks.failed != 0)


if __name__ == "__main__":
    main()
