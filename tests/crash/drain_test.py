#!/usr/bin/env python3
"""A real process and a real SIGTERM with --drain-delay-seconds: only /readyz says that it is about
to stop, and new connections are served, until the delay is over or a second signal comes.

    drain_test.py GEODESICD
"""

import http.client
import os
import pathlib
import signal
import sys
import tempfile
import time

from service import Service, mesh

PATIENCE = 60.0
failures = 0


def expect(what, is_so, *details):
    """Prints a line about one thing that must be so."""
    global failures
    failures += not is_so
    print(("ok: " if is_so else "FAILED: ") + what, *(() if is_so else details))


def started(program, folder, seconds):
    """A server with that delay."""
    flags = ["--store", str(folder / "store"), "--drain-delay-seconds", str(seconds)]
    return Service(program, flags, folder / "errors")


def is_kept(connection, query):
    """Whether the reply to one more request on it leaves it open."""
    connection.request("GET", query)
    reply = connection.getresponse()
    reply.read()
    assert reply.status == 200
    return reply.getheader("Connection") != "close"


def ends_at_the_second_signal(program, folder):
    """Told to stop, it serves on; told once more, it stops."""
    service = started(program, folder, 86400)
    service.ask("POST", "/v1/meshes", mesh(10, 1))
    query = f"/v1/meshes/{service.ids()[0]}/distance?from=v:0"
    before = service.ask("GET", query)
    expect("it is ready", service.ask("GET", "/readyz")[0] == 200 and before[0] == 200)
    kept = http.client.HTTPConnection("127.0.0.1", service.port, timeout=PATIENCE)
    expect("a connection is kept", is_kept(kept, query))
    service.process.send_signal(signal.SIGTERM)
    end = time.monotonic() + PATIENCE
    while service.ask("GET", "/readyz")[0] == 200 and time.monotonic() < end:
        time.sleep(0.05)
    status, body = service.get_json("/readyz")
    expect("after SIGTERM it is not", status == 503 and body["code"] == "draining", status, body)
    service.process.send_signal(signal.SIGHUP)  # as who turns logs over does
    expect("but it is alive", service.ask("GET", "/livez")[0] == 200)
    expect("a connection that was kept has a last reply, which says so", not is_kept(kept, query))
    expect("and so has a new one", service.ask("GET", query)[1].get("connection") == "close")
    expect("queries on new connections are answered", service.ask("GET", query)[2] == before[2])
    expect("uploads are taken", service.ask("POST", "/v1/meshes", mesh(10, 2))[0] == 201)
    status, body = service.get_json("/v1/status")
    expect("the status says so", status == 200 and body["draining"] is True, body)
    service.process.send_signal(signal.SIGTERM)
    expect("it ends well at the second signal", service.process.wait(timeout=PATIENCE) == 0)


def ends_after_the_delay(program, folder):
    """Told to stop and left alone."""
    service = started(program, folder, 2)
    told = time.monotonic()
    service.process.send_signal(signal.SIGTERM)
    expect("it ends well by itself", service.process.wait(timeout=PATIENCE) == 0)
    expect("not before the delay is over", time.monotonic() - told >= 2)


def main():
    """Both; exits with 1 if something was not so."""
    program = os.path.abspath(sys.argv[1])
    for ends in (ends_at_the_second_signal, ends_after_the_delay):
        with tempfile.TemporaryDirectory() as name:
            ends(program, pathlib.Path(name))
    sys.exit(failures != 0)


if __name__ == "__main__":
    main()
