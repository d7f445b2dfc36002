"""A geodesicd of one's own for a test: started, asked, killed; and meshes to upload."""

import atexit
import hashlib
import http.client
import json
import os
import pathlib
import random
import re
import signal
import struct
import subprocess
import time


def reply_on(connection, method, path, body=None, headers=None):
    """(status, headers in lower case, body) of one request on a connection that ends with it."""
    try:
        connection.request(method, path, body=body, headers=headers or {})
        reply = connection.getresponse()
        return reply.status, {name.lower(): value for name, value in reply.getheaders()}, reply.read()
    finally:
        connection.close()


class Service:
    """geodesicd with the given flags, listening on `port`, or on one of its own choice.

    `seconds_to_start` is the time from exec to the line that says where it listens, and
    `busy_to_start` how much of it the processor spent on it, which the rest of the
    machine's work does not add to. `log` is a file that its standard error is appended to.
    """

    def __init__(self, program, flags, log, environment=None, port=0):
        clean = {k: v for k, v in os.environ.items() if not k.startswith("GEODESICD_")}
        began = time.monotonic()
        with open(log, "ab") as errors:
            self.process = subprocess.Popen(
                [program, "--listen", f"127.0.0.1:{port}", *flags],
                stdout=subprocess.PIPE, stderr=errors, env={**clean, **(environment or {})},
            )
        atexit.register(self.process.kill)  # whatever happens, nothing is left running
        self.port = None
        for line in self.process.stdout:
            found = re.match(rb"listening on https?://127\.0\.0\.1:(\d+)", line)
            if found:
                self.port = int(found.group(1))
                break
        self.seconds_to_start = time.monotonic() - began
        if self.port is None:
            raise RuntimeError(f"geodesicd did not start: see {log}")
        fields = pathlib.Path(f"/proc/{self.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
        self.busy_to_start = (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def ask(self, method, path, body=None, timeout=60, headers=None):
        """(status, headers in lower case, body) of one request on a connection of its own."""
        return reply_on(http.client.HTTPConnection("127.0.0.1", self.port, timeout=timeout), method, path, body, headers)

    def get_json(self, path):
        """The status and the parsed body of a GET."""
        status, _, body = self.ask("GET", path)
        return status, json.loads(body)

    def ids(self):
        """Every mesh that is listed, page by page."""
        found = []
        cursor = ""
        while True:
            status, page = self.get_json(f"/v1/meshes?limit=1000{cursor}")
            if status != 200:
                raise RuntimeError(f"the list is answered {status}: {page}")
            found += [mesh["id"] for mesh in page["meshes"]]
            if page["next"] is None:
                return found
            cursor = f"&cursor={page['next']}"

    def kill(self):
        """kill -9, and the end of the process."""
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()
        self.process.stdout.close()

    def stop(self):
        """SIGTERM; the exit status."""
        self.process.terminate()
        status = self.process.wait(timeout=60)
        self.process.stdout.close()
        return status


def mesh(columns, seed):
    """A bumpy grid of columns x columns vertices as a .glb: its bytes depend on both."""
    numbers = random.Random(seed)
    positions = bytearray()
    for row in range(columns):
        for column in range(columns):
            positions += struct.pack("<3f", column, row, numbers.random())
    indices = bytearray()
    for row in range(columns - 1):
        for column in range(columns - 1):
            corner = row * columns + column
            indices += struct.pack("<6I", corner, corner + 1, corner + columns + 1,
                                   corner, corner + columns + 1, corner + columns)
    gltf = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": columns * columns, "type": "VEC3",
             "min": [0, 0, 0], "max": [columns - 1, columns - 1, 1]},
            {"bufferView": 1, "componentType": 5125, "count": len(indices) // 4, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": len(positions)},
            {"buffer": 0, "byteOffset": len(positions), "byteLength": len(indices)},
        ],
        "buffers": [{"byteLength": len(positions) + len(indices)}],
    }
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    binary = bytes(positions + indices)
    return (
        struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(binary))
        + struct.pack("<I4s", len(text), b"JSON") + text
        + struct.pack("<I4s", len(binary), b"BIN\0") + binary
    )


def digest(data):
    """The id of a mesh."""
    return hashlib.sha256(data).hexdigest()


def files_below(folder):
    """Every regular file below a folder."""
    return [path for path in pathlib.Path(folder).rglob("*") if path.is_file()]
