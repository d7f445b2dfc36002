"""A geodesicd of one's own to load: started with a store in a temporary folder and
one mesh uploaded, and ended afterwards."""

import contextlib
import json
import os
import pathlib
import re
import resource
import shutil
import signal
import statistics
import subprocess
import tempfile
import urllib.request

# A server, its clients and a thousand idle connections are all this machine's.
_soft, _hard = resource.getrlimit(resource.RLIMIT_NOFILE)
resource.setrlimit(resource.RLIMIT_NOFILE, (_hard, _hard))


class Service:
    """Where it listens, and what there is to ask."""

    def __init__(self, build, *options, prefix=()):
        self._build = pathlib.Path(build)
        self._options = options
        self._prefix = prefix  # of the command
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="load_"))
        self.port = self.admin_port = 0
        self.mesh = {}
        self._run_ns = {}  # by process and thread, of those that have ended too

    def __enter__(self):
        command = [*self._prefix, self._build / "geodesicd", "--listen", "127.0.0.1:0"]
        command += ["--admin-listen", "127.0.0.1:0", "--store", self.folder / "store"]
        command += ["--log-level", os.environ.get("LOAD_LOG_LEVEL", "warn"), *self._options]
        self._log = open(self.folder / "log", "w+", encoding="utf-8")
        self._process = subprocess.Popen(
            [str(part) for part in command], stdout=subprocess.PIPE, stderr=self._log, text=True
        )
        for line in self._process.stdout:
            port = int(line.rsplit(":", 1)[1]) if " on http" in line else 0
            if line.startswith("admin"):
                self.admin_port = port
            elif line.startswith("listening"):
                self.port = port
                break
        if not self.port:
            raise RuntimeError(f"geodesicd did not start: {self.log()}")
        self.mesh = self._upload()
        return self

    def __exit__(self, *_):
        self._process.send_signal(signal.SIGTERM)
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(30)
        self._process.kill()
        self._process.stdout.close()
        self._log.close()
        shutil.rmtree(self.folder, ignore_errors=True)

    @property
    def pid(self):
        """Of the server's process."""
        return self._process.pid

    def log(self):
        """The end of what the server wrote."""
        return (self.folder / "log").read_text(encoding="utf-8")[-2000:]

    def _upload(self):
        subprocess.run(
            [self._build / "make_samples", self.folder / "samples"],
            check=True,
            stdout=subprocess.DEVNULL,
        )
        # The one that is nearest to 36,000 vertices.
        known = []
        for file in sorted((self.folder / "samples").glob("*.glb")):
            request = urllib.request.Request(self.url("/v1/meshes"), file.read_bytes())
            with urllib.request.urlopen(request) as reply:
                known.append(json.load(reply))
        mesh = min(known, key=lambda mesh: abs(mesh["vertices"] - 36000))
        self.get(f"/v1/meshes/{mesh['id']}/distance?from=v:0&at=v:1")  # prepares it
        return mesh

    def url(self, target):
        """The full URL of a target."""
        return f"http://127.0.0.1:{self.port}{target}"

    def get(self, target):
        """The body of a reply."""
        with urllib.request.urlopen(self.url(target)) as reply:
            return reply.read()

    def metric(self, name):
        """The sum of a metric over its labels."""
        url = f"http://127.0.0.1:{self.admin_port}/metrics"
        with urllib.request.urlopen(url) as reply:
            lines = reply.read().decode().splitlines()
        return sum(float(line.split()[-1]) for line in lines if re.match(name + r"[ {]", line))

    def solves(self):
        """How many fields it has computed."""
        return int(self.metric("geodesicd_solve_duration_seconds_count"))

    def slots(self):
        """How many it computes at once."""
        return int(self.metric("geodesicd_compute_slots"))

    def stat(self, name):
        """A number of /proc, such as Threads or VmRSS (in kB)."""
        status = pathlib.Path(f"/proc/{self._process.pid}/status").read_text(encoding="utf-8")
        return int(next(line for line in status.splitlines() if line.startswith(name)).split()[1])

    def processor_seconds(self):
        """What its threads and those of its decoders have taken since this was first asked."""
        for process in self._processes():
            for task in pathlib.Path(f"/proc/{process}/task").glob("*/schedstat"):
                with contextlib.suppress(OSError, ValueError):  # it may end meanwhile
                    self._run_ns[process, task.parent.name] = int(task.read_text().split()[0])
        return sum(self._run_ns.values()) / 1e9

    def _processes(self):
        """It and all below it."""
        found = [str(self._process.pid)]
        for process in found:
            for children in pathlib.Path(f"/proc/{process}/task").glob("*/children"):
                with contextlib.suppress(OSError):
                    found += children.read_text().split()
        return found


def quantile(values, share):
    """The value below which that share of the values is; 0 of none."""
    return sorted(values)[min(len(values) - 1, int(share * len(values)))] if values else 0.0


def describe(times):
    """Times in seconds as a line of milliseconds."""
    if not times:
        return "none"
    return "{} times, ms: mean {:.1f}, p50 {:.1f}, p99 {:.1f}, max {:.1f}".format(
        len(times),
        1000 * statistics.fmean(times),
        1000 * quantile(times, 0.5),
        1000 * quantile(times, 0.99),
        1000 * max(times),
    )


class Checks:
    """Bounds that were asked for, each printed with what was measured."""

    def __init__(self, slack=1.0):
        self._slack = slack  # how much worse than asked is still no failure
        self.failed = 0

    def at_most(self, what, value, bound, unit="ms"):
        """Says whether a value keeps its bound."""
        self._say(what, value, "<=", bound, unit, value <= bound, value <= bound * self._slack)

    def at_least(self, what, value, bound, unit="%"):
        """The same, for a bound from below."""
        self._say(what, value, ">=", bound, unit, value >= bound, value >= bound / self._slack)

    def _say(self, what, value, sign, bound, unit, kept, accepted):
        verdict = "kept" if kept else "MISSED" if not accepted else "missed, but not by far"
        print(f"  {what}: {value:.1f} {unit} (asked: {sign} {bound:.1f}): {verdict}", flush=True)
        self.failed += not accepted
