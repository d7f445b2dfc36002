#!/usr/bin/env python3
"""A real process that may open no more files, and one whose listening socket dies: the first
says that it is not ready, serves whoever is connected, and recovers; the second ends with a
reason.

    accept_test.py GEODESICD
"""

import ctypes
import http.client
import os
import pathlib
import resource
import socket
import sys
import tempfile
import time

from ports import free_port
from service import Service

PIDFD_GETFD = 438  # of every architecture that has it
failures = 0


def expect(what, is_so, *details):
    """Prints a line about one thing that must be so."""
    global failures
    failures += not is_so
    print(("ok: " if is_so else "FAILED: ") + what, *(() if is_so else details))


def soon(holds, seconds=30):
    end = time.monotonic() + seconds
    while not (found := holds()) and time.monotonic() < end:
        time.sleep(0.02)
    return found


def get(connection, path):
    """Status and body, on a connection that stays open."""
    connection.request("GET", path)
    reply = connection.getresponse()
    return reply.status, reply.read().decode()


def accept_failures(connection):
    _, text = get(connection, "/metrics")
    for line in text.splitlines():
        if line.startswith("geodesicd_accept_failures_total "):
            return float(line.split()[1])
    return None


def without_files(program, folder):
    port = free_port()
    service = Service(program, ["--store", f"{folder}/a", "--admin-listen", f"127.0.0.1:{port}"],
                      f"{folder}/log")  # fmt: skip
    pid = service.process.pid
    admin = http.client.HTTPConnection("127.0.0.1", port, timeout=60)
    known = http.client.HTTPConnection("127.0.0.1", service.port, timeout=60)
    expect("it is ready", get(admin, "/readyz")[0] == 200)
    expect("no accept has failed", accept_failures(admin) == 0, accept_failures(admin))
    expect("a client is served", get(known, "/v1/methods")[0] == 200)
    before = resource.prlimit(pid, resource.RLIMIT_NOFILE)
    least = max(int(name) for name in os.listdir(f"/proc/{pid}/fd")) + 1
    resource.prlimit(pid, resource.RLIMIT_NOFILE, (least, before[1]))
    late = [http.client.HTTPConnection("127.0.0.1", service.port, timeout=60) for _ in range(8)]
    for connection in late:
        connection.request("GET", "/v1/methods")
    told = soon(lambda: "cannot be accepted" in get(admin, "/readyz")[1])
    expect("it says that it is not ready, and why", told, get(admin, "/readyz"))
    expect("so do the metrics", "geodesicd_ready 0" in get(admin, "/metrics")[1])
    failed = accept_failures(admin)
    expect("failures are counted", failed and failed > 0, failed)
    time.sleep(1)
    expect("it does not try all the time", accept_failures(admin) < failed + 100)
    expect("whoever is connected is served", get(known, "/v1/methods")[0] == 200)
    resource.prlimit(pid, resource.RLIMIT_NOFILE, before)
    for connection in late:
        expect("who waited is served", connection.getresponse().status == 200)
    expect("it is ready again", soon(lambda: get(admin, "/readyz")[0] == 200))
    service.process.terminate()
    expect("it can be stopped", service.process.wait(60) == 0)


def listening_file(pid, port):
    """The number of the open file of a process that listens on a port."""
    inodes = set()
    for line in pathlib.Path("/proc/net/tcp").read_text().splitlines()[1:]:
        words = line.split()
        if int(words[1].split(":")[1], 16) == port and words[3] == "0A":
            inodes.add(f"socket:[{words[9]}]")
    for name in os.listdir(f"/proc/{pid}/fd"):
        if os.readlink(f"/proc/{pid}/fd/{name}") in inodes:
            return int(name)
    raise RuntimeError("nobody listens there")


def without_socket(program, folder):
    service = Service(program, ["--store", f"{folder}/b"], f"{folder}/log_b")
    known = http.client.HTTPConnection("127.0.0.1", service.port, timeout=60)
    expect("a client is served", get(known, "/v1/methods")[0] == 200)
    known.close()
    number = listening_file(service.process.pid, service.port)
    libc = ctypes.CDLL(None, use_errno=True)
    process = os.pidfd_open(service.process.pid)
    copy = libc.syscall(PIDFD_GETFD, process, number, 0)
    if copy < 0:
        print(f"skipped: no file of another process here: {os.strerror(ctypes.get_errno())}")
        service.process.kill()
        return
    with socket.socket(fileno=copy) as listener:
        listener.shutdown(socket.SHUT_RDWR)  # accept fails with EINVAL from now on
    expect("the process ends, and not as if all were well", service.process.wait(60) == 1)
    log = service.process.stdout.read().decode()
    expect("with a reason", "the listening socket" in log and "Invalid argument" in log, log)


with tempfile.TemporaryDirectory() as folder:
    without_files(sys.argv[1], folder)
    without_socket(sys.argv[1], folder)
sys.exit(failures != 0)
