"""A geodesicd of one's own for a test of the contract, and requests to it as a client
of any kind would send them."""

import atexit
import contextlib
import hashlib
import http.client
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import tempfile
import time


class Reply:
    """Status, headers (lower case) and body."""

    def __init__(self, reply):
        self.status = reply.status
        self.headers = {name.lower(): value for name, value in reply.getheaders()}
        self.body = reply.read()


class Server:
    """geodesicd with the given flags and a store in a temporary folder."""

    def __init__(self, build, *flags, store=None):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="contract_"))
        atexit.register(shutil.rmtree, self.folder, True)
        self.store = store or self.folder / "store"
        command = [str(pathlib.Path(build) / "geodesicd"), "--listen", "127.0.0.1:0"]
        command += ["--store", str(self.store), "--log-level", "warn", *map(str, flags)]
        clean = {k: v for k, v in os.environ.items() if not k.startswith("GEODESICD_")}
        with open(self.folder / "log", "wb") as log:
            self.process = subprocess.Popen(
                command, stdout=subprocess.PIPE, stderr=log, text=True, env=clean
            )
        atexit.register(self.process.kill)
        self.port = self.admin_port = 0
        for line in self.process.stdout:
            port = int(line.rsplit(":", 1)[1]) if " on http://" in line else 0
            if line.startswith("admin"):
                self.admin_port = port
            if line.startswith("listening"):
                self.port = port
                break
        if not self.port:
            raise RuntimeError(f"geodesicd did not start: {self.log()}")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.send_signal(signal.SIGTERM)
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.process.wait(60)
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()

    def log(self):
        """The end of what it wrote."""
        return (self.folder / "log").read_text(encoding="utf-8", errors="replace")[-3000:]

    def ask(self, method, target, body=None, headers=None, source="127.0.0.1", timeout=120):
        """One request on a connection of its own."""
        connection = http.client.HTTPConnection(
            "127.0.0.1", self.port, timeout=timeout, source_address=(source, 0)
        )
        try:
            connection.request(method, target, body=body, headers=headers or {})
            return Reply(connection.getresponse())
        finally:
            connection.close()

    def ask_without_sending(self, method, target, length, headers=None):
        """A request whose body is announced and never comes."""
        lines = [f"{method} {target} HTTP/1.1", "Host: localhost", f"Content-Length: {length}"]
        lines += [f"{name}: {value}" for name, value in (headers or {}).items()]
        with socket.create_connection(("127.0.0.1", self.port), timeout=120) as connection:
            connection.sendall(("\r\n".join(lines) + "\r\n\r\n").encode())
            reply = http.client.HTTPResponse(connection, method=method)
            reply.begin()
            return Reply(reply)

    def upload(self, data):
        """Uploads a mesh; its id."""
        reply = self.ask("POST", "/v1/meshes", data)
        assert reply.status in (200, 201), reply.body
        return hashlib.sha256(data).hexdigest()


def wait_until(condition, what, seconds=120):
    """Polls; generous, since machines are loaded."""
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            raise TimeoutError(what)
        time.sleep(0.02)
