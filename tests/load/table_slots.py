#!/usr/bin/env python3
"""How much sooner a table is done by two compute slots than by one.

    table_slots.py BUILD [--rounds N] [--rows N] [--slots N] [--slack X]

Two servers, of one slot and of several, are asked for the same table in turn, each round
for other rows; what counts is the quickest round of each, since others may use the
machine's cores meanwhile. The replies must be the same bytes. While a table is computed, a
single distance is asked for again and again: how long that takes is told. Exit status 1 if
the ratio is below 1.8, divided by the slack, or the bytes differ.
"""

import argparse
import statistics
import sys
import threading
import time

from service import Service


def table(first, rows, vertices, method):
    """A target whose rows nobody has asked for."""
    step = vertices // 1009
    points = [(first + i * 97) * step % vertices for i in range(rows)]
    query = "&".join(f"from=v:{v}" for v in points)
    return f"table?{query}&to=v:{vertices - 1}&to=v:{vertices // 2}&to=v:7&method={method}&format=f64"


def timed(service, target):
    """The seconds that a query takes, and its reply."""
    begin = time.perf_counter()
    reply = service.get(f"/v1/meshes/{service.mesh['id']}/{target}")
    return time.perf_counter() - begin, reply


def wait_of_others(service, target, vertices):
    """Milliseconds of single distances, their median and longest, while a table is computed."""
    over = threading.Event()

    def ask_table():
        timed(service, target)
        over.set()

    thread = threading.Thread(target=ask_table)
    thread.start()
    waits = []
    while not over.is_set():
        near = len(waits) % (vertices - 1)
        seconds, _ = timed(service, f"distance?from=v:{near}&at=v:{near + 1}&format=f64")
        waits.append(1000 * seconds)
        time.sleep(0.01)
    thread.join()
    return statistics.median(waits), max(waits)


def main():
    """Prints the ratio of each method."""
    parser = argparse.ArgumentParser()
    parser.add_argument("build")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--rows", type=int, default=24)
    parser.add_argument("--slots", type=int, default=2)
    parser.add_argument("--slack", type=float, default=1)
    options = parser.parse_args()
    missed = False
    slots = ("--compute-threads", str(options.slots))
    with Service(options.build, "--compute-threads", "1") as one, Service(
        options.build, *slots
    ) as several:
        vertices = one.mesh["vertices"]
        for method in ("wavefront", "auto", "exact"):
            rows = options.rows if method != "exact" else max(2, options.rows // 4)
            alone, together = [], []
            for i in range(options.rounds):
                target = table(1 + i * rows, rows, vertices, method)
                seconds, expected = timed(one, target)
                alone.append(seconds)
                seconds, reply = timed(several, target)
                together.append(seconds)
                if reply != expected:
                    print(f"{method}: the bytes depend on the number of slots")
                    missed = True
            ratio = min(alone) / min(together)
            reached = ratio >= 1.8 / options.slack
            missed |= not reached
            print(
                f"{method}: a table of {rows} rows on {vertices} vertices takes one slot "
                f"{ratio:.2f} times as long as {options.slots} ({1000 * min(alone):.0f} ms, "
                f"{1000 * min(together):.0f} ms): {'yes' if reached else 'no'}",
                flush=True,
            )
        busy = table(500, options.rows, vertices, "auto")
        middle, longest = wait_of_others(several, busy, vertices)
        print(f"beside a table, a distance takes {middle:.1f} ms, {longest:.1f} ms at most")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
