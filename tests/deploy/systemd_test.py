#!/usr/bin/env python3
"""deploy/systemd/geodesicd.service: systemd finds it in order and well hardened, and the server works with
the system calls that it leaves.

    systemd_test.py GEODESICD

systemd-analyze reads the unit. No systemd runs here, so the unit is not started by one: the server is
started with its variables, in filters made of its settings (seccomp_filter.py), and as root by a user of its own.
What the unit does to files, devices, /proc and addresses is not tried.

GEODESICD_SEED=NUMBER sets the mesh; it is printed.
"""

import os
import pathlib
import re
import secrets
import shutil
import signal
import subprocess
import sys
import tempfile
import urllib.request

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(HERE.parent / "crash"))

from confined import Confined, filters_of, works  # noqa: E402
from ports import free_port  # noqa: E402
from service import Service  # noqa: E402

UNIT = ROOT / "deploy" / "systemd" / "geodesicd.service"
MOST_EXPOSED = 15  # tenths of what systemd-analyze security counts, from 0 to 10; its versions differ
# What the unit is to forbid, as Python that works without it.
FORBIDDEN = {
    "another kind of socket": "import socket; socket.socket(socket.AF_NETLINK, socket.SOCK_RAW)",
    "memory to write to and execute": "import mmap; mmap.mmap(-1, 4096, prot=mmap.PROT_WRITE | mmap.PROT_EXEC)",
    "another priority": "import os; os.nice(1)",
}
failures = 0


def expect(what, is_so, *details):
    """Prints a line about one thing that must be so."""
    global failures
    failures += not is_so
    print(("ok: " if is_so else "FAILED: ") + what, *(() if is_so else details), flush=True)


def analyze(program, folder):
    """What systemd itself says of the unit."""
    unit = folder / UNIT.name
    unit.write_text(UNIT.read_text(encoding="utf-8").replace("/usr/local/bin/geodesicd", program), encoding="utf-8")
    said = subprocess.run(["systemd-analyze", "verify", "--man=no", unit], capture_output=True, text=True, check=False,
                          env={**os.environ, "SYSTEMD_LOG_LEVEL": "warning"})
    words = said.stdout + said.stderr
    expect("systemd-analyze verify says nothing against the unit", said.returncode == 0 and not words, words)
    said = subprocess.run(["systemd-analyze", "security", "--offline=true", f"--threshold={MOST_EXPOSED}",
                           "--no-pager", unit], capture_output=True, text=True, check=False)
    print(said.stdout.strip().splitlines()[-1] if said.stdout else said.stderr)
    expect(f"its exposure is at most {MOST_EXPOSED / 10}", said.returncode == 0, said.stdout)
    seconds = re.search(r"^TimeoutStopSec=(\d+)$", UNIT.read_text(encoding="utf-8"), re.M)
    said = subprocess.run([program, "--print-config"], capture_output=True, text=True, check=True).stdout
    drain = [int(value) for value in re.findall(r'^drain-(?:delay-)?seconds +"(\d+)"', said, re.M)]
    expect("it waits for longer than the server drains",
           seconds and len(drain) == 2 and int(seconds[1]) > sum(drain) + 1, drain)


def variables_of_unit(program):
    """Its variables, by which alone it says what the server is to do."""
    unit = UNIT.read_text(encoding="utf-8")
    expect("the unit starts the program without flags, which would beat the operator's variables",
           re.search(r"^ExecStart=/usr/local/bin/geodesicd$", unit, re.M))
    variables = dict(word.split("=", 1) for word in re.search(r"^Environment=(.*)$", unit, re.M)[1].split())
    # One that the server does not know would change nothing, and nobody would see it.
    known = subprocess.run([program, "--print-config"], capture_output=True, text=True, check=True,
                           env={**os.environ, **variables}).stdout
    unknown = [name for name in variables if not re.search(rf"\s{name}$", known, re.M)]
    expect("the server reads each variable", variables and not unknown, unknown)
    return variables


def run(program, folder, seed):
    """The server, under the unit's filters."""
    confined = Confined("unit", UNIT, folder)
    for what, code in FORBIDDEN.items():
        expect(f"the unit forbids {what}", confined.refuses(code))
    admin = free_port()
    here = {"127.0.0.1:8081": f"127.0.0.1:{admin}", "/var/lib/geodesicd": str(confined.place("store"))}
    variables = variables_of_unit(program)
    expect("the unit says where the store and the admin's listener are", set(here) <= set(variables.values()), variables)
    service = Service(confined.program(program), [], folder / "log",
                      {name: here.get(value, value) for name, value in variables.items()})
    expect("the filters hold for the server", filters_of(service) >= 2)
    expect("the server decodes and computes", works(service, seed))
    with urllib.request.urlopen(f"http://127.0.0.1:{admin}/readyz", timeout=20) as reply:
        expect("it is ready", reply.status == 200)
    service.process.send_signal(signal.SIGHUP)  # ExecReload
    expect("told to read its settings again, it works as before", works(service, seed + 1))
    expect("it ends well", service.stop() == 0)


def main():
    """The whole test."""
    if shutil.which("systemd-analyze") is None:
        print("skipped: no systemd-analyze (Debian's package systemd)")
        return 77
    seed = int(os.environ.get("GEODESICD_SEED") or secrets.randbelow(2**31))
    print(f"GEODESICD_SEED={seed}")
    with tempfile.TemporaryDirectory(prefix="systemd_test_") as name:
        folder, program = pathlib.Path(name), os.path.abspath(sys.argv[1])
        analyze(program, folder)
        run(program, folder, seed)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
