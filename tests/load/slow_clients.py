#!/usr/bin/env python3
"""New clients while others idle or are slow.

    slow_clients.py BUILD [--seconds N] [--idle N] [--slow N] [--only MODE] [--slack X]

Measures how long new clients wait (connecting included) beside idle keep-alive
connections, beside senders of a byte a second (half of them in their heads, half
in their bodies), and under slowhttptest in its three modes. Exit status 1 if any
waits longer than asked, by more than the slack.
"""

import argparse
import asyncio
import contextlib
import itertools
import shutil
import sys
import time

from http_client import Connection, timed_ask
from service import Checks, Service, describe

ASKED_MS = 100.0


async def new_clients(service, seconds, every=0.05):
    """The times of new clients that come one after the other."""
    loop = asyncio.get_running_loop()
    end = loop.time() + seconds
    times, wrong = [], 0
    while loop.time() < end:
        status, taken = await timed_ask(service.port, "/v1/status")
        wrong += status != 200
        times.append(taken)
        await asyncio.sleep(every)
    return times, wrong


async def idle_connections(port, count):
    """Connections that have asked once and stay open."""
    connections = [Connection(port) for _ in range(count)]
    for begin in range(0, count, 100):
        batch = connections[begin : begin + 100]
        await asyncio.gather(*(connection.ask("/v1/methods") for connection in batch))
    return connections


async def trickle(port, number, cut):
    """A byte a second, until the server has had enough."""
    if number % 2:
        start, rest = "GET / HTTP/1.1\r\nHost: x\r\n", "A: b\r\n" * 10000
    else:
        start, rest = "POST /v1/meshes HTTP/1.1\r\nHost: x\r\nContent-Length: 100000\r\n\r\n", "x"
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    answered = asyncio.create_task(reader.read())
    writer.write(start.encode())
    for byte in itertools.cycle(rest):
        done, _ = await asyncio.wait([answered], timeout=1)
        if done:
            break
        writer.write(byte.encode())
    with contextlib.suppress(OSError):
        cut.append(await answered)
    writer.close()


async def under_slowhttptest(service, mode, count, seconds):
    """The times of new clients during one of its attacks."""
    target = {
        "-H": "/v1/status",
        "-B": "/v1/meshes",
        "-X": f"/v1/meshes/{service.mesh['id']}/source",
    }[mode]
    command = ["slowhttptest", mode, "-c", str(count), "-r", str(count // 2), "-l", str(seconds + 2)]
    command += ["-i", "1", "-p", "3", "-u", service.url(target)]
    if mode == "-X":
        command += ["-w", "1", "-y", "64", "-n", "1", "-z", "16", "-k", "3"]
    attack = await asyncio.create_subprocess_exec(
        *command, stdout=asyncio.subprocess.DEVNULL, stderr=asyncio.subprocess.DEVNULL
    )
    await asyncio.sleep(1)
    result = await new_clients(service, seconds)
    with contextlib.suppress(ProcessLookupError):
        attack.terminate()
    await attack.wait()
    return result


async def measure(service, arguments, checks):
    """All of it; prints as it goes."""

    def report(what, result):
        times, wrong = result
        print(f"{what}: {describe(times)}; {wrong} not served")
        print(f"  {service.stat('Threads')} threads, {service.stat('VmRSS') // 1024} MB")
        checks.at_most("longest wait of a new client", 1000 * max(times), ASKED_MS)
        checks.at_most("new clients not served", wrong, 0, "")

    seconds = arguments.seconds
    if arguments.only:
        result = await under_slowhttptest(service, arguments.only, arguments.idle, seconds)
        report(f"slowhttptest {arguments.only}", result)
        return
    report("nobody else", await new_clients(service, seconds))
    idle = await idle_connections(service.port, arguments.idle)
    report(f"{len(idle)} idle", await new_clients(service, seconds))
    cut = []
    slow = [
        asyncio.create_task(trickle(service.port, number, cut)) for number in range(arguments.slow)
    ]
    report(f"and {len(slow)} slow senders", await new_clients(service, seconds))
    print(f"  {sum(c.ended for c in idle)} of the idle ended, {len(cut)} of the slow cut so far")
    if arguments.patience:
        begin = time.monotonic()
        await asyncio.wait(slow, timeout=arguments.patience)
        told = sum(reply.startswith(b"HTTP/1.1 408") for reply in cut)
        print(f"  after {time.monotonic() - begin:.1f} s more, {told} of them were told 408")
        checks.at_least("slow senders cut", 100 * len(cut) / max(1, len(slow)), 100)
    for task in slow:
        task.cancel()
    await asyncio.gather(*slow, return_exceptions=True)
    for connection in idle:
        connection.close()
    if not shutil.which("slowhttptest"):
        print("skipped: slowhttptest is not installed")
        return
    for mode, what in (("-H", "slow heads"), ("-B", "slow bodies"), ("-X", "slow readers")):
        result = await under_slowhttptest(service, mode, arguments.idle, seconds)
        report(f"slowhttptest {mode}, {arguments.idle} {what}", result)


def main():
    """Runs it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("build")
    parser.add_argument("--seconds", type=float, default=10)
    parser.add_argument("--idle", type=int, default=1000)
    parser.add_argument("--slow", type=int, default=200)
    parser.add_argument("--patience", type=float, default=20, help="for slow senders to be cut")
    parser.add_argument("--only", choices=("-H", "-B", "-X"), help="one mode of slowhttptest")
    parser.add_argument("--slack", type=float, default=1.0)
    arguments = parser.parse_args()
    checks = Checks(arguments.slack)
    with Service(arguments.build) as service:
        asyncio.run(measure(service, arguments, checks))
    sys.exit(checks.failed != 0)


if __name__ == "__main__":
    main()
