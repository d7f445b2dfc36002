"""Ports for servers that a test starts, and may start again, at a port that others know."""

import os
import pathlib
import random
import socket

LOWEST = 12000
_given = set()


def free_port():
    """A port that nobody listens on now, and that no connection is given by chance.

    The system takes a connection's own port from a range that begins above these. A port out of that
    range can be gone before its server listens there, or while the server is started again.
    """
    above = int(pathlib.Path("/proc/sys/net/ipv4/ip_local_port_range").read_text().split()[0])
    drawn = random.Random(os.urandom(8))  # other than the next process's, whatever the test's seed
    for _ in range(1000):
        port = drawn.randrange(LOWEST, max(above, LOWEST + 4000))
        if port in _given:
            continue
        with socket.socket() as one:
            one.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                one.bind(("127.0.0.1", port))
            except OSError:
                continue
            _given.add(port)
            return port
    raise OSError("no port is free")
