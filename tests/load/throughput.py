#!/usr/bin/env python3
"""Requests a second beside a bare cpp-httplib handler that returns as many bytes.

    throughput.py BUILD [--seconds N] [--rounds N] [--slack X]

Each question is asked of both servers in turn, round after round, by wrk (where it
is installed) and by a client of our own; the ratio is that of the medians. Then each
server is asked at 70 % of the rate that our own client saw of it, in many short
windows, and the spread of the answers' times is looked at: the median over the
windows, since one pause of a shared machine is more than 1 % of a second. What the
machine itself does is said by the bare handler's spread, and by how often programs
that do nothing but read the clock, one a core, are kept from it for longer than such
an answer may take. Exit status 1 if a bound is missed by more than the slack.
"""

import argparse
import json
import multiprocessing
import os
import pathlib
import re
import shutil
import statistics
import subprocess
import sys
import time

from service import Checks, Service


class Bare:
    """The bare handler, with the same bytes."""

    def __init__(self, build, files):
        self._process = subprocess.Popen(
            [str(part) for part in (build / "bare_server", *files)],
            stdout=subprocess.PIPE,
            text=True,
        )
        self.port = int(self._process.stdout.readline())

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._process.kill()
        self._process.wait()
        self._process.stdout.close()


def ask_wrk(port, target, seconds):
    """Requests a second."""
    command = ["wrk", "-t1", "-c16", f"-d{max(1, round(seconds))}s"]
    output = subprocess.run(
        [*command, f"http://127.0.0.1:{port}{target}"], check=True, capture_output=True, text=True
    ).stdout
    assert "Non-2xx" not in output and "Socket errors" not in output, output
    return float(re.search(r"Requests/sec: +([0-9.]+)", output).group(1))


class OwnClient:
    """paced_client, as fast as it is answered or at a rate."""

    def __init__(self, build):
        self._program = build / "paced_client"

    def ask(self, port, target, rate, seconds):
        """What it printed."""
        output = subprocess.run(
            [str(part) for part in (self._program, port, target, rate, seconds)],
            check=True,
            capture_output=True,
            text=True,
        ).stdout
        return json.loads(output)

    def __call__(self, port, target, seconds):
        return self.ask(port, target, 0, seconds)["rate"]


def compare(client, questions, seconds, rounds):
    """The medians of the rates of several (port, target), asked in turn."""
    rates = [[] for _ in questions]
    for _ in range(rounds):
        for place, (port, target) in zip(rates, questions):
            place.append(client(port, target, seconds))
    return [statistics.median(rate) for rate in rates]


def pauses(seconds, longer_ms):
    """How long each of them was, ms, in so many seconds of reading the clock."""
    found = []
    last = begun = time.perf_counter()
    while last - begun < seconds:
        now = time.perf_counter()
        if now - last > longer_ms / 1000:
            found.append(1000 * (now - last))
        last = now
    return found


def describe_machine(seconds, longer_ms=1.0):
    """What programs are kept from that nobody else has any part in."""
    cores = len(os.sched_getaffinity(0))
    with multiprocessing.Pool(cores) as pool:
        found = pool.starmap(pauses, [(seconds, longer_ms)] * cores)
    every = [pause for core in found for pause in core]
    times = len(every) / cores / seconds
    share = sum(every) / cores / seconds / 10
    print(
        f"the machine: {cores} programs that read the clock were kept from it for longer than "
        f"{longer_ms:g} ms {times:.1f} times a second, {share:.1f} % of the time, "
        f"at most {max(every, default=0):.1f} ms"
    )


def spread(client, port, target, rate, windows):
    """p99 over p50 at 70 % of that rate: the median over the windows, and the window
    that has it."""
    found = []
    for _ in range(windows):
        window = client.ask(port, target, 0.7 * rate, 0.7)
        found.append((window["p99_ms"] / window["p50_ms"], window["p50_ms"], window["p99_ms"]))
    return sorted(found)[windows // 2]


def main():
    """Runs it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--seconds", type=float, default=5)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--slack", type=float, default=1.0)
    arguments = parser.parse_args()
    checks = Checks(arguments.slack)
    own = OwnClient(arguments.build)
    clients = {"our client": own}
    if shutil.which("wrk"):
        clients["wrk"] = ask_wrk
    else:
        print("skipped: wrk is not installed")

    describe_machine(min(4, arguments.seconds))
    with Service(arguments.build) as service:
        mesh = service.mesh
        base = f"/v1/meshes/{mesh['id']}"
        questions = {
            "cached path": (f"{base}/path?from=v:0&to=v:{mesh['vertices'] // 2}", 60),
            f"cached f32 field of {mesh['vertices']} vertices": (
                f"{base}/distance?from=v:0&format=f32",
                50,
            ),
        }
        files = []
        for number, (target, _) in enumerate(questions.values()):
            files.append(service.folder / f"reply{number}")
            files[-1].write_bytes(service.get(target))
        with Bare(arguments.build, files) as bare:
            for number, (what, (target, bound)) in enumerate(questions.items()):
                size = files[number].stat().st_size
                pair = [(service.port, target), (bare.port, f"/{number}")]
                for name, client in clients.items():
                    ours, theirs = compare(client, pair, arguments.seconds, arguments.rounds)
                    print(f"{what}, {size} bytes, {name}: {ours:.0f}/s, bare {theirs:.0f}/s")
                    checks.at_least("of the bare handler's", 100 * ours / theirs, bound)
                for name, (port, path) in zip(("bare", "ours"), reversed(pair)):
                    rate = own(port, path, arguments.seconds)
                    share, p50, p99 = spread(own, port, path, rate, 5 * arguments.rounds)
                    print(f"{what} at 70 %, {name}: {0.7 * rate:.0f}/s, p50 {p50} ms, p99 {p99} ms")
                    if name == "bare":
                        print(f"  p99 over p50: {share:.1f}")
                checks.at_most("p99 over p50", share, 5, "")
    sys.exit(checks.failed != 0)


if __name__ == "__main__":
    main()
