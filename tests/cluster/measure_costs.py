#!/usr/bin/env python3
"""What queries cost one server, measured and fitted (costs.py), for simulate.py.

    in_simpy.sh measure_costs.py GEODESICD OUT [--repeats N] [--pause SECONDS]

Uploads grids of several sizes to a server, and asks for whole fields: of meshes that are in no cache, of
meshes in memory, and again for the same. Steps' times and bytes in caches are differences of /metrics;
CPU is that of the server's process, and of those that decode for it, which /metrics leaves out.

GEODESICD_SEED=NUMBER sets what is drawn; it is printed.
"""

import argparse
import http.client
import os
import pathlib
import random
import re
import statistics
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "crash")]

from costs import Costs, line_through, quantiles  # noqa: E402
from service import Service, digest, mesh  # noqa: E402

SIDES = (16, 32, 64, 128, 256)  # vertices of a mesh along a side
COLD = [word for cache in ("mesh", "adjacency", "field", "reply") for word in (f"--{cache}-cache-bytes", "0")]
STEPS = {"read": 'geodesicd_mesh_duration_seconds_sum{step="read"}',
         "decode": 'geodesicd_mesh_duration_seconds_sum{step="decode"}'}
TICK = 1 / os.sysconf("SC_CLK_TCK")


def metrics_of(server):
    """All of /metrics, by name with labels."""
    text = server.ask("GET", "/metrics")[2].decode()
    return {name: float(value) for name, value in re.findall(r"^([a-z_]+(?:\{.*\})?) (\S+)$", text, re.M)}


def cpu_of(server):
    """CPU seconds of a server's process (/metrics) and of its decoders, those that have ended too."""
    seconds = metrics_of(server)["process_cpu_seconds_total"]
    for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rsplit(")", 1)[1].split()
        except OSError:  # it has ended
            continue
        if int(fields[1]) == server.process.pid:
            seconds += sum(map(int, fields[11:15])) * TICK
    return seconds


def question(name, source):
    """Asks for a whole field, whose bytes are floats."""
    return f"/v1/meshes/{name}/distance?from=v:{source}&format=f32"


class Line:
    """A connection that stays open, and waits for `pause` seconds before each question.

    Of the last reply: `stages`, seconds by Server-Timing; `took`, of all; `kept`, whether it was."""

    def __init__(self, port, pause=0.0, headers=None, make=http.client.HTTPConnection, **options):
        self._line, self._headers = make("127.0.0.1", port, timeout=60, **options), headers or {}
        self._pause = pause
        self.stages, self.took, self.kept = {}, 0.0, False

    def ask(self, path):
        """The reply's bytes; anything but 200 is an error."""
        time.sleep(self._pause)
        began = time.perf_counter()
        self._line.request("GET", path, headers=self._headers)
        reply = self._line.getresponse()
        body = reply.read()
        self.took = time.perf_counter() - began
        if reply.status != 200:
            raise RuntimeError(f"{path} is answered {reply.status}: {body[:200]}")
        timing = reply.getheader("Server-Timing", "")
        self.stages = {name: float(ms) / 1e3 for name, ms in re.findall(r"(\w+);dur=([\d.]+)", timing)}
        self.kept = reply.getheader("Geo-Cache") == "hit"
        return body


def lower_quartile(amounts):
    """A quarter of them are below it."""
    return statistics.quantiles(amounts, n=4, method="inclusive")[0] if len(amounts) > 1 else amounts[0]


class Samples:
    """What was measured: a step's or kind's amounts with their meshes' vertices."""

    def __init__(self):
        self._all = {}

    def add(self, what, vertices, amount):
        """One more."""
        self._all.setdefault(what, []).append((vertices, amount))

    def line(self, what, middle):
        """Through the `middle` of each mesh's amounts."""
        by_size = {}
        for vertices, amount in self._all[what]:
            by_size.setdefault(vertices, []).append(amount)
        sizes = sorted(by_size)
        return line_through(sizes, [middle(by_size[size]) for size in sizes])

    def quantiles(self, what):
        """Of amounts of time, whatever the mesh."""
        return quantiles([max(amount, 0) for _, amount in self._all[what]])

    def of(self, what):
        """All pairs."""
        return self._all[what]


def measure_cold(server, files, samples, scrape, repeats, pause, random_):
    """Queries that nothing is there for."""
    line = Line(server.port, pause)
    for name, vertices in files:
        # One span for all of them: what a decoder took is told in hundredths of a second.
        cpu = cpu_of(server)
        for _ in range(repeats):
            before = metrics_of(server)
            for _ in range(4):
                line.ask(question(name, random_.randrange(vertices)))
                samples.add("to load", vertices, sum(line.stages.values()) - line.stages.get("queue", 0))
            after = metrics_of(server)
            for step, metric in STEPS.items():
                samples.add(step, vertices, (after.get(metric, 0) - before.get(metric, 0)) / 4)
        samples.add("cpu cold", vertices, (cpu_of(server) - cpu - (2 * repeats + 1) * scrape) / (4 * repeats))


def measure_warm(server, files, samples, scrape, repeats, pause, random_):
    """Queries about meshes in memory, and those whose replies are kept."""
    line = Line(server.port, pause)
    for name, vertices in files:
        line.ask(question(name, 0))
        sources = random_.sample(range(1, vertices), 6 * repeats)
        for kind in ("cpu warm", "cpu kept"):
            cpu = cpu_of(server)
            for source in sources:
                line.ask(question(name, source))
                if line.kept != (kind == "cpu kept"):
                    raise RuntimeError(f"the reply cache has {name} from {source}: {line.kept}")
                if line.kept:
                    samples.add("around kept", vertices, line.took)
            samples.add(kind, vertices, (cpu_of(server) - cpu - scrape) / len(sources))


def measure_in_turn(server, files, samples, kind, repeats, pause, random_):
    """One mesh after another, as they are asked about: what a processor's caches have is of other meshes,
    and so each takes longer than when it is asked about several times in a row."""
    line = Line(server.port, pause)
    for _ in range(4 * repeats):
        for name, vertices in random_.sample(files, len(files)):
            line.ask(question(name, random_.randrange(vertices)))
            if line.kept:
                continue
            if kind == "to prepare":
                samples.add("prepare", vertices, line.stages["prepare"])
            else:
                samples.add("field", vertices, line.stages["solve"])
                samples.add("encode", vertices, line.stages["encode"])
            samples.add(kind, vertices, sum(line.stages.values()) - line.stages.get("queue", 0))
            samples.add("around", vertices, line.took - sum(line.stages.values()))


def measure_bytes(server, files, samples):
    """What a mesh, its field and its reply take in the caches."""
    for name, vertices in files:
        before = metrics_of(server)
        Line(server.port).ask(question(name, 0))
        after = metrics_of(server)
        for part, cache in (("mesh", "meshes"), ("adjacency", "adjacency"), ("field", "fields"), ("reply", "replies")):
            metric = f'geodesicd_cache_bytes{{cache="{cache}"}}'
            samples.add(f"bytes {part}", vertices, after[metric] - before[metric])


def scrape_of(server):
    """CPU seconds of asking for the metrics."""
    cpu_of(server)
    began, count = cpu_of(server), 20
    for _ in range(count):
        spent = cpu_of(server) - began
    return spent / count


def fitted(samples):
    """The costs."""
    # A machine that others use, too, is slow at times; but CPU is what was taken, whenever that was.
    steps = [*STEPS, "prepare", "field", "encode"]
    seconds = {step: samples.line(step, lower_quartile) for step in steps}
    cpu = {kind: samples.line(f"cpu {kind}", statistics.mean) for kind in ("cold", "warm", "kept")}
    spread = [took / sum(seconds[step][0] + seconds[step][1] * vertices for step in taken)
              for kind, taken in (("to load", steps), ("to prepare", steps[2:]), ("to solve", steps[3:]))
              for vertices, took in samples.of(kind)]
    difference = lambda a, b: tuple(max(x - y, 0.0) for x, y in zip(cpu[a], cpu[b]))  # noqa: E731
    return Costs(seconds=seconds, cpu_seconds={"load": difference("cold", "warm"), "field": cpu["warm"],
                                               "reply": cpu["kept"]},
                 bytes={part: samples.line(f"bytes {part}", max)
                        for part in ("file", "mesh", "adjacency", "field", "reply")},
                 spread=quantiles(spread), around=samples.quantiles("around"),
                 around_kept=samples.quantiles("around kept"))


def print_costs(costs):
    """As a table in Markdown."""
    print("| part | fixed | each 1,000 vertices |\n|---|--:|--:|")
    for kind, unit, scale in (("seconds", "ms", 1e3), ("cpu_seconds", "ms of CPU", 1e3), ("bytes", "KB", 1e-3)):
        for part, (fixed, each) in getattr(costs, kind).items():
            print(f"| {part}, {unit} | {fixed * scale:.3f} | {each * scale * 1e3:.3f} |")
    middle = len(costs.around) // 2
    print(f"\nA computed query takes {costs.spread[1]:.2f} to {costs.spread[-2]:.2f} times what the lines say "
          f"(2.5 % to 97.5 %), and {costs.around[middle] * 1e3:.2f} ms beside them; "
          f"one whose reply is kept, {costs.around_kept[middle] * 1e3:.2f} ms.")


def measured(program, folder, sides, repeats, pause, random_, flags=()):
    """The costs of a program, with a store in the folder. `pause`: between queries, for a processor that
    was at something else meanwhile takes longer."""
    folder.mkdir(exist_ok=True)
    log, store = folder / "log", ["--store", str(folder / "store"), "--log-level", "warn", *flags]
    samples = Samples()
    server = Service(program, store, log)
    files = []
    for side in sides:
        data = mesh(side, random_.random())
        if server.ask("POST", "/v1/meshes", data)[0] != 201:
            raise RuntimeError("an upload is not taken")
        files.append((digest(data), side * side))
        samples.add("bytes file", side * side, len(data))
    server.stop()
    server = Service(program, store + COLD, log)
    scrape = scrape_of(server)
    measure_cold(server, files, samples, scrape, repeats, pause, random_)
    server.stop()
    server = Service(program, store, log)
    scrape = scrape_of(server)
    measure_bytes(server, files, samples)
    measure_warm(server, files, samples, scrape, repeats, pause, random_)
    measure_in_turn(server, files, samples, "to solve", repeats, pause, random_)
    server.stop()
    server = Service(program, [*store, *COLD[2:]], log)  # but for meshes
    measure_in_turn(server, files, samples, "to prepare", repeats, pause, random_)
    server.stop()
    return fitted(samples)


def main():
    """Measures, writes and prints."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("out")
    parser.add_argument("--repeats", type=int, default=12, help="of four or six queries of each kind and mesh")
    parser.add_argument("--pause", type=float, default=0.02, help="seconds before each query")
    arguments = parser.parse_args()
    seed = os.environ.get("GEODESICD_SEED") or str(random.randrange(1 << 32))
    print(f"GEODESICD_SEED={seed}", flush=True)
    with tempfile.TemporaryDirectory(prefix="costs_") as folder:
        costs = measured(os.path.abspath(arguments.program), pathlib.Path(folder), SIDES, arguments.repeats,
                         arguments.pause, random.Random(seed))
    costs.write(arguments.out)
    print_costs(costs)
    return 0


if __name__ == "__main__":
    sys.exit(main())
