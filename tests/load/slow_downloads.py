#!/usr/bin/env python3
"""slow_downloads.py BUILD [--clients N] [--megabytes M] [--most-megabytes M]

What a server's memory grows by while many clients have asked for a large mesh's source, its
geometry and a field, and take nothing of it. Fails if it grows by more than --most-megabytes
beyond what one of each takes and the memory for replies that the server is given; or if what
is taken afterwards is not whole.
"""

import argparse
import hashlib
import json
import socket
import struct
import sys
import time
import urllib.request

from service import Service


def wavy_stl(megabytes):
    """A binary STL of about that size: a grid, each face with its own corners."""
    side = int((megabytes * 1e6 / 100) ** 0.5)
    out = bytearray(80) + struct.pack("<I", 2 * side * side)

    def corner(x, y):
        return struct.pack("<3f", x, y, (x * x + 3 * y) % 7 * 0.1)

    for y in range(side):
        row = [(corner(x, y), corner(x, y + 1)) for x in range(side + 1)]
        for x in range(side):
            (a, b), (c, d) = row[x], row[x + 1]
            out += bytes(12) + a + c + d + b"\0\0" + bytes(12) + a + d + b + b"\0\0"
    return bytes(out)


def ask_and_take_nothing(port, target):
    """A client that sends a request and reads nothing."""
    client = socket.socket()
    client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    client.connect(("127.0.0.1", port))
    client.sendall(f"GET {target} HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n".encode())
    return client


def status_of(client):
    """The reply's status, by its head; nothing of the body is read."""
    client.settimeout(60)
    head = b""
    while b"\r\n\r\n" not in head:
        piece = client.recv(1)
        if not piece:
            break
        head += piece
    return int(head[9:12] or 0)


def resident(server):
    """Megabytes of its own, without files that it maps."""
    return server.stat("RssAnon") / 1024


def main():
    """Loads a server with each kind of large reply in turn."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("build")
    parser.add_argument("--clients", type=int, default=60)
    parser.add_argument("--megabytes", type=float, default=32)
    parser.add_argument("--most-megabytes", type=float, default=150)
    parser.add_argument("--reply-memory", default="256MiB")
    asked = parser.parse_args()
    options = ["--reply-cache-bytes", "0"]
    if asked.reply_memory != "none":  # a server that has no such option
        options += ["--reply-memory-bytes", asked.reply_memory]
    with Service(asked.build, *options) as server:
        stl = wavy_stl(asked.megabytes)
        request = urllib.request.Request(server.url("/v1/meshes"), stl)
        with urllib.request.urlopen(request) as reply:
            mesh = json.load(reply)["id"]
        base = f"/v1/meshes/{mesh}"
        targets = ["/source", "/geometry?format=frame", "/distance?from=v:0"]
        for target in targets:
            with urllib.request.urlopen(server.url(base + target)) as reply:
                reply.read()
        before = resident(server)
        failed = False
        for target in targets:
            clients = [ask_and_take_nothing(server.port, base + target) for _ in range(asked.clients)]
            statuses = [status_of(client) for client in clients]
            grown = resident(server) - before
            good = statuses.count(200)
            # All come from one address, which has its share of the memory.
            refused = statuses.count(429) + statuses.count(503)
            print(
                f"{target}: {good} of {asked.clients} at once are being sent, "
                f"{refused} refused; memory grew by {grown:.0f} MB"
            )
            failed |= grown > asked.most_megabytes + (256 if target.startswith("/dist") else 0)
            failed |= good == 0 or good + refused != asked.clients
            if target == "/source":
                failed |= good != asked.clients
                digest = hashlib.sha256()
                while piece := clients[0].recv(1 << 16):
                    digest.update(piece)
                failed |= digest.hexdigest() != mesh
            for client in clients:
                client.close()
            time.sleep(0.5)
        return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
