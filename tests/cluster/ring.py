"""Which server a mesh belongs to: nginx's `hash … consistent`, point for point."""

import zlib

import numpy as np

POINTS = 160  # of a server of weight 1


class Ring:
    """Servers on a ring of 32-bit hashes, by their names, HOST:PORT."""

    def __init__(self, names):
        points = {}
        for server, name in enumerate(names):
            host, _, port = name.rpartition(":")
            base = zlib.crc32(host.encode() + b"\0" + port.encode())
            last = 0
            for _ in range(POINTS):
                last = zlib.crc32(last.to_bytes(4, "little"), base)
                points.setdefault(last, server)
        self._hashes = np.array(sorted(points), dtype=np.uint32)
        self._servers = np.array([points[hash_] for hash_ in sorted(points)], dtype=np.int32)

    def points_of(self, hashes):
        """For each hash of a key the first point that is not below it, round the ring."""
        return np.searchsorted(self._hashes, hashes) % len(self._hashes)

    def server(self, point):
        """The server of a point; an array of them for an array."""
        return self._servers[point % len(self._servers)]


def hash_of(key):
    """The hash of a key: of a mesh, the first 16 digits of its id (deploy/nginx/fleet.conf)."""
    return zlib.crc32(key.encode())


def ring_of(count):
    """A ring of so many servers, with addresses in 10.0.0.0/8."""
    return Ring([f"10.{at >> 16}.{at >> 8 & 255}.{at & 255}:8080" for at in range(1, count + 1)])
