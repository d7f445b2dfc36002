#!/usr/bin/env python3
"""Whose requests they are behind a real HAProxy and a real nginx, by what either of them sends.

    announced_test.py GEODESICD

HAProxy announces connections by the PROXY protocol, with and without TLS to the server, and adds
`Forwarded` headers; nginx appends to them. Clients come from addresses of their own on this
machine, forge what they like, and are told apart by the server's log. Skipped where there is
neither HAProxy nor nginx.

GEODESICD_SEED=NUMBER sets what clients forge; it is printed.
"""

import http.client
import os
import pathlib
import random
import socket
import ssl
import subprocess
import sys
import tempfile
import threading
import time

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "crash"))

import nginx  # noqa: E402
from ports import free_port  # noqa: E402
from service import Service  # noqa: E402

PATIENCE = 30.0  # seconds
FORGERIES = 60

CONFIGURATION = """
global
  log stderr local0
defaults
  timeout connect 2s
  timeout client 60s
  timeout server 60s

listen announces
  mode http
  bind 127.0.0.1:{announces}
  option httpchk GET /readyz?exclude=store
  server one 127.0.0.1:{plain} check inter 200ms send-proxy-v2 proxy-v2-options crc32c,unique-id

listen passes_tls_on
  mode tcp
  bind 127.0.0.1:{passes_tls_on}
  server one 127.0.0.1:{tls} send-proxy-v2

listen is_of_version_1
  mode http
  bind 127.0.0.1:{is_of_version_1}
  server one 127.0.0.1:{plain} send-proxy

listen adds_forwarded
  mode http
  bind 127.0.0.1:{adds_forwarded}
  http-request add-header Forwarded "for=\\"%[src]:%[src_port]\\";proto=http"
  server one 127.0.0.1:{standard}
"""

# As many write it: whatever the client sent, and the address behind it.
APPENDING = """
  server {{
    listen 127.0.0.1:{appends_forwarded};
    location / {{
      proxy_pass http://127.0.0.1:{standard};
      proxy_set_header Forwarded "$http_forwarded, for=$remote_addr";
    }}
  }}
"""

failures = 0


def expect(what, is_so, *details):
    """Prints a line about one thing that must be so."""
    global failures
    failures += not is_so
    print(("ok: " if is_so else "FAILED: ") + what, *(() if is_so else details), flush=True)


class Server:
    """A geodesicd, and who asked it, by its log."""

    def __init__(self, program, folder, name, *flags):
        self.service = Service(program, ["--store", folder / f"{name}.store", *flags], folder / f"{name}.log")
        self.port, self.lines = self.service.port, []
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self):
        for line in self.service.process.stdout:
            self.lines.append(line.decode())

    def said(self, text, after=0):
        """The first line with that text, from that one on; waits for it."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            for line in self.lines[after:]:
                if text in line:
                    return line
            time.sleep(0.01)
        raise TimeoutError(f"the log does not say {text!r}: {self.lines[-20:]}")

    def who_sent(self, name):
        """The client of the request with that id."""
        words = self.said(f" {name} ").split()
        return words[words.index(name) + 1]


class Asking:
    """Requests from addresses of this machine, each with an id of its own."""

    def __init__(self):
        self._count = 0

    def ask(self, port, source="127.0.0.1", headers=(), tls=None):
        """(status, id) of a GET."""
        self._count += 1
        name = f"asked-{self._count}"
        line = http.client.HTTPConnection("127.0.0.1", port, timeout=PATIENCE, source_address=(source, 0))
        line.connect()
        if tls:
            line.sock = tls.wrap_socket(line.sock)
        line.putrequest("GET", "/v1/methods")
        line.putheader("X-Request-Id", name)
        for header in headers:
            line.putheader(*header)
        line.endheaders()
        reply = line.getresponse()
        reply.read()
        line.close()
        return reply.status, name


def answers(port, sends=b""):
    """Whether a connection that says that, and asks, gets any byte back."""
    with socket.create_connection(("127.0.0.1", port), timeout=PATIENCE) as line:
        try:
            line.sendall(sends + b"GET /livez HTTP/1.1\r\nHost: x\r\n\r\n")
            return bool(line.recv(1))
        except ConnectionError:
            return False


def announced(asking, ports, plain, tls, trusting):
    """By the PROXY protocol."""
    end = time.monotonic() + PATIENCE
    while asking.ask(ports["announces"])[0] != 200 and time.monotonic() < end:
        time.sleep(0.1)
    for source in ("127.0.0.7", "127.0.0.8", "127.0.0.7"):
        status, name = asking.ask(ports["announces"], source, [("X-Forwarded-For", "6.6.6.6")])
        expect(f"a client that HAProxy announces is {source}", (status, plain.who_sent(name)) == (200, source))
        status, name = asking.ask(ports["passes_tls_on"], source, tls=trusting)
        expect("and so it is where TLS follows the header", (status, tls.who_sent(name)) == (200, source))
    expect("HAProxy's checks are the proxy's own", " 127.0.0.1 GET /readyz " in plain.said(" GET /readyz "))
    before = len(plain.lines)
    expect("version 1 is refused", asking.ask(ports["is_of_version_1"])[0] in (502, 503))
    expect("and the log says why", "send-proxy-v2" in plain.said("version 1", before))
    expect("so is a request without a header", not answers(plain.port))
    expect("the listener of probes has none", answers(ports["admin"]))


def forwarded(asking, ports, standard, draw):
    """By Forwarded, with what clients make up before it."""
    pieces = ["for=6.6.6.6", "for=\"6.6.6.6:1\"", "for=127.0.0.1", ",", ";", "\"", "\\", "x=\"", "by=_a", " ",
              "for=", "unknown", "host=\"a,b\"", "for=\"[2001:db8::6]\""]
    found = {"adds_forwarded": set(), "appends_forwarded": set()}
    for _ in range(FORGERIES):
        source = f"127.0.0.{draw.randrange(2, 250)}"
        forged = "".join(draw.choice(pieces) for _ in range(draw.randrange(1, 8))).strip()
        headers = [("Forwarded", forged), ("X-Forwarded-For", "6.6.6.6")]
        for proxy, seen in found.items():
            status, name = asking.ask(ports[proxy], source, headers)
            client = standard.who_sent(name)
            seen.add(client == source)
            allowed = (source,) if proxy == "adds_forwarded" else (source, "127.0.0.1")
            if status != 200 or client not in allowed:
                expect(f"{proxy}: {forged!r} from {source}", False, status, client)
    expect("a line of HAProxy's own is believed, whatever stands before it", found["adds_forwarded"] == {True})
    expect("what nginx appends is believed, unless a client has spoilt it", found["appends_forwarded"] == {True, False})


def main():
    """All of it; exits with 1 if something was not so."""
    program = os.path.abspath(sys.argv[1])
    haproxy = subprocess.run([nginx.ROOT / "scripts/fetch_haproxy", "--known"], capture_output=True, text=True,
                             check=False).stdout.strip()
    appending = nginx.program("--known")
    if not haproxy or not appending:
        print("skipped: needs HAProxy and nginx (scripts/setup gets them)")
        return 77
    seed = int(os.environ.get("GEODESICD_SEED") or random.SystemRandom().randrange(1 << 31))
    print(f"GEODESICD_SEED={seed}", flush=True)
    with tempfile.TemporaryDirectory(prefix="announced_") as name:
        folder = pathlib.Path(name)
        key, cert = nginx.certificate(folder)
        trusts = ["--trusted-proxies", "127.0.0.1"]
        ports = {name: free_port() for name in ("announces", "passes_tls_on", "is_of_version_1", "adds_forwarded",
                                                "appends_forwarded", "admin")}
        plain = Server(program, folder, "plain", *trusts, "--proxy-protocol", "v2")
        tls = Server(program, folder, "tls", *trusts, "--proxy-protocol", "v2", "--tls-cert", cert, "--tls-key", key,
                     "--admin-listen", f"127.0.0.1:{ports['admin']}")
        standard = Server(program, folder, "standard", *trusts, "--forwarded-header", "forwarded")
        trusting = ssl.create_default_context(cafile=cert)
        trusting.check_hostname = False
        ports.update(plain=plain.port, tls=tls.port, standard=standard.port)
        (folder / "haproxy.cfg").write_text(CONFIGURATION.format(**ports))
        processes = []
        try:
            with open(folder / "said", "wb") as said:
                for command in ([haproxy, "-f", folder / "haproxy.cfg"],
                                nginx.command(appending, folder, APPENDING.format(**ports))):
                    processes.append(subprocess.Popen(command, stdout=said, stderr=said))
            for proxy in ("announces", "appends_forwarded"):
                wait_for(ports[proxy], folder / "said")
            asking = Asking()
            announced(asking, ports, plain, tls, trusting)
            forwarded(asking, ports, standard, random.Random(seed))
        finally:
            for process in processes:
                process.terminate()
                process.wait(30)
        for server in (plain, tls, standard):
            expect("a server ends well", server.service.stop() == 0)
    return failures != 0


def wait_for(port, said):
    """Until somebody accepts connections there."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        try:
            socket.create_connection(("127.0.0.1", port), timeout=1).close()
            return
        except OSError:
            time.sleep(0.05)
    raise TimeoutError(f"no proxy on {port}: {said.read_text()}")


if __name__ == "__main__":
    sys.exit(main())
