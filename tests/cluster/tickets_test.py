#!/usr/bin/env python3
"""TLS sessions of one server that go on at another, by a file of ticket keys that they share.

    tickets_test.py GEODESICD

Real processes and Python's ssl, in TLS 1.2 and 1.3: a session goes on at a server with the same
keys, and not at one with others; keys are turned over one server at a time, and no session whose
key is still in the file is lost; a file that is wrong ends the start, and changes nothing later.

GEODESICD_SEED=NUMBER sets the keys; it is printed.
"""

import base64
import os
import pathlib
import random
import re
import signal
import socket
import ssl
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "crash"))

from nginx import certificate  # noqa: E402
from service import Service  # noqa: E402

VERSIONS = (ssl.TLSVersion.TLSv1_2, ssl.TLSVersion.TLSv1_3)
LIFETIME = 7200  # seconds, as docs/operating/fleet.md says

failures = 0


def expect(what, is_so, *details):
    """Prints a line about one thing that must be so."""
    global failures
    failures += not is_so
    print(("ok: " if is_so else "FAILED: ") + what, *(() if is_so else details), flush=True)


class Server:
    """geodesicd with TLS and, unless `keys` is None, a file of those keys."""

    def __init__(self, program, folder, name, keys):
        self.folder, self.file, self.log = folder, folder / f"{name}.keys", folder / f"{name}.log"
        flags = ["--tls-cert", folder / "cert", "--tls-key", folder / "key", "--store", folder / f"{name}.store"]
        if keys is not None:
            self.write(keys)
            flags += ["--tls-ticket-keys", self.file]
        self.service = Service(program, [*flags, "--log-level", "info"], self.log)

    def write(self, keys, mode=0o640):
        """Puts other keys into the file."""
        self.file.write_text("".join(key + "\n" for key in keys))
        self.file.chmod(mode)

    def hang_up(self):
        """SIGHUP; what the log says of it."""
        self.service.process.send_signal(signal.SIGHUP)
        said = ""
        for line in self.service.process.stdout:
            said += line.decode()
            if re.search("reload: (done|nothing was changed)", said):
                return said
        raise RuntimeError("the server has ended")


class Client:
    """One version of TLS, which all of its sessions are of."""

    def __init__(self, folder, version):
        self._context = ssl.create_default_context(cafile=folder / "cert")
        self._context.check_hostname = False
        self._context.minimum_version = self._context.maximum_version = version
        self.name = version.name

    def visit(self, server, session=None):
        """(whether the session was gone on with, the session to come with next time) of one request."""
        with socket.create_connection(("127.0.0.1", server.service.port), timeout=60) as tcp, \
                self._context.wrap_socket(tcp, session=session) as tls:
            tls.sendall(b"GET /livez HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n")
            reply = b""
            while more := tls.recv(4096):
                reply += more
            assert reply.startswith(b"HTTP/1.1 200"), reply
            return tls.session_reused, tls.session


def shared(clients, one, other, stranger):
    """Between servers with the same keys, and one with others."""
    for client in clients:
        reused, session = client.visit(one)
        expect(f"{client.name}: the first session is a new one", not reused)
        expect("its ticket is good for two hours", session.ticket_lifetime_hint == LIFETIME,
               session.ticket_lifetime_hint)
        expect("it goes on at the other server", client.visit(other, session)[0])
        expect("and where it began", client.visit(one, session)[0])
        expect("but not at one with other keys", not client.visit(stranger, session)[0])


def turned_over(clients, one, other, keys):
    """Keys that move up one place, at first at one server and then at both."""
    before = [client.visit(other)[1] for client in clients]  # under keys[1]
    one.write(keys[1:4])
    expect("the log says that they were read again", "the files of TLS were read again" in one.hang_up())
    fresh = [client.visit(one)[1] for client in clients]  # under keys[2]
    renewed = []
    for client, old, new in zip(clients, before, fresh):
        expect(f"{client.name}: where the new key is known, but not in use, its tickets are taken",
               client.visit(other, new)[0])
        reused, session = client.visit(one, old)
        expect("where the old key is out of use, its tickets are taken", reused)
        renewed.append(session)
    for server in (one, other):
        server.write(keys[2:5])
        server.hang_up()
    for client, old, new in zip(clients, before, renewed):
        expect(f"{client.name}: tickets of a key that is gone are not taken", not client.visit(other, old)[0])
        expect("what they were replaced by is", client.visit(other, new)[0])


def refused(program, clients, server, keys):
    """Files that are wrong, while the server runs and at its start."""
    sessions = [client.visit(server)[1] for client in clients]
    short = base64.b64encode(bytes(48)).decode()
    many = [base64.b64encode(bytes([at]) * 80).decode() for at in range(100)]
    faults = (("too few keys", keys[:2], 0o600, "2 keys, and at least 3 are needed"),
              ("a key of 48 bytes", [*keys[:2], short], 0o600, ":3: a key is 80 random bytes"),
              ("no base64", [*keys[:2], "*" * 107 + "="], 0o600, ":3: a key is 80 random bytes"),
              ("a key twice", [keys[0], *keys[:2]], 0o600, ":2: the key stands in the file twice"),
              ("too many keys", many[:17], 0o600, ":17: more than 16 keys"),
              ("a file too long", many, 0o600, "more than 8192 bytes"),
              ("open to everybody", keys[:3], 0o644, "chmod o-rw"))
    for what, lines, mode, says in faults:
        server.write(lines, mode)
        said = server.hang_up()
        expect(f"{what}: nothing is changed", "nothing was changed" in said and says in said, said)
        expect("no key is in the log", not any(key[:20] in said for key in keys), said)
        begun = subprocess.run([program, "--listen", "127.0.0.1:0", "--store", server.folder / "none", "--tls-cert",
                                server.folder / "cert", "--tls-key", server.folder / "key", "--tls-ticket-keys",
                                server.file], capture_output=True, text=True, timeout=60, check=False)
        expect("a server does not start", begun.returncode == 1 and says in begun.stdout + begun.stderr, begun)
    for client, session in zip(clients, sessions):
        expect(f"{client.name}: the keys are still the old ones", client.visit(server, session)[0])
    server.file.unlink()
    expect("no file: nothing is changed", "nothing was changed" in server.hang_up())
    alone = subprocess.run([program, "--tls-ticket-keys", server.file], capture_output=True, text=True, timeout=60,
                           check=False)
    expect("keys without a certificate are refused", alone.returncode == 2 and "--tls-cert" in alone.stderr, alone)


def main():
    """All of it; exits with 1 if something was not so."""
    program = os.path.abspath(sys.argv[1])
    seed = int(os.environ.get("GEODESICD_SEED") or time.time_ns() % (1 << 31))
    print(f"GEODESICD_SEED={seed}")
    draw = random.Random(seed)
    keys = [base64.b64encode(draw.randbytes(80)).decode() for _ in range(8)]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        certificate(folder)
        one, other = (Server(program, folder, name, keys[:3]) for name in ("one", "other"))
        stranger = Server(program, folder, "stranger", keys[5:])
        alone = Server(program, folder, "alone", None)
        clients = [Client(folder, version) for version in VERSIONS]
        shared(clients, one, other, stranger)
        for client in clients:
            session = client.visit(alone)[1]
            expect(f"{client.name}: without a file, a session goes on where it began", client.visit(alone, session)[0])
            expect("and nowhere else", not client.visit(one, session)[0])
        turned_over(clients, one, other, keys)
        refused(program, clients, one, keys)
        for server in (one, other, stranger, alone):
            expect("a server ends well", server.service.stop() == 0)
    sys.exit(failures != 0)


if __name__ == "__main__":
    main()
