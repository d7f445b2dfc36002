"""One server of the simulation: caches, compute slots and a queue, as docs/architecture.md has them.

A query is (key of its reply, mesh, vertices). Steps follow one another as in the server: a kept reply;
else the prepared mesh, which is made of the decoded one, which is made of the store's file; then the
field, and the reply. Each step waits for a compute slot by itself; a kept reply needs none.
"""

import collections
import dataclasses

import simpy


class Refused(Exception):
    """The server answers 503."""


@dataclasses.dataclass(frozen=True)
class Settings:
    """As the server's flags are called, with their defaults, and what is assumed of the store."""

    compute_threads: int = 4
    queue: int = 256
    queue_seconds: float = 10.0
    mesh_cache_bytes: int = 512 << 20
    adjacency_cache_bytes: int = 1536 << 20
    field_cache_bytes: int = 768 << 20
    reply_cache_bytes: int = 256 << 20
    store_seconds: float = 0.0  # until the first byte, beyond what reading a directory takes
    store_bytes_a_second: float = 0.0  # of one request; 0: as a directory's
    store_requests: int = 32  # at once, and as many wait (server/s3/s3_client.h)


class Cache:
    """Least recently used goes first, once there are more bytes than the budget. Who asks for what
    another one is making waits for that."""

    def __init__(self, env, budget):
        self._env, self._budget = env, budget
        self._entries = collections.OrderedDict()
        self._flights = {}
        self.bytes = self.hits = self.makes = 0

    def find(self, key):
        """Whether it is there; then it is the most recently used one."""
        if key not in self._entries:
            return False
        self._entries.move_to_end(key)
        self.hits += 1
        return True

    def keep(self, key, size):
        """Adds what was made."""
        self.makes += 1
        if size > self._budget or key in self._entries:
            return
        self._entries[key] = size
        self.bytes += size
        while self.bytes > self._budget:
            self.bytes -= self._entries.popitem(last=False)[1]

    def get(self, key, size, make):
        """A process that ends once it is there; `make` is one that makes it."""
        if self.find(key):
            return
        flight = self._flights.get(key)
        if flight is not None:
            if not (yield flight):
                raise Refused
            return
        flight = self._flights[key] = self._env.event()
        done = False
        try:
            yield from make()
            self.keep(key, size)
            done = True
        finally:
            del self._flights[key]
            flight.succeed(done)


def refuse_if_full(resource, places):
    """Raises Refused if one more would have to wait beyond these places."""
    if resource.count == resource.capacity and len(resource.queue) >= places:
        raise Refused


class Replica:
    """Answers queries; counts what it did."""

    def __init__(self, env, costs, settings):
        self._env, self._costs, self._settings = env, costs, settings
        self._slots = simpy.Resource(env, settings.compute_threads)
        self._store = simpy.Resource(env, settings.store_requests)
        self.meshes, self.prepared, self.fields, self.replies = (
            Cache(env, budget) for budget in (settings.mesh_cache_bytes, settings.adjacency_cache_bytes,
                                              settings.field_cache_bytes, settings.reply_cache_bytes))
        self.begin()

    def begin(self):
        """Sets all counts to 0; caches keep what they have."""
        self.queries = self.refused = self.inside = 0
        self.cpu_seconds = self.store_bytes = 0.0
        for cache in (self.meshes, self.prepared, self.fields, self.replies):
            cache.hits = cache.makes = 0

    def _bytes(self, part, vertices):
        return self._costs.of("bytes", part, vertices)

    def recall(self, query):
        """What a query does to the caches, in no time: so they are warm when time begins."""
        key, mesh, vertices = query
        if self.replies.find(key):
            return
        if not self.prepared.find(mesh):
            if not self.meshes.find(mesh):
                self.meshes.keep(mesh, self._bytes("mesh", vertices))
            self.prepared.keep(mesh, self._bytes("adjacency", vertices))
        if not self.fields.find(key):
            self.fields.keep(key, self._bytes("field", vertices))
        self._keep_reply(key, vertices)

    def knows(self, key):
        """Whether it has the reply; counts a query that it has."""
        if not self.replies.find(key):
            return False
        self.queries += 1
        self.cpu_seconds += self._costs.of("cpu_seconds", "reply", 0)
        return True

    def compute(self, query, slowness):
        """A process that ends with the reply to a query that is not known; `slowness`: by how much all
        its steps take longer than usual. Raises Refused."""
        key, mesh, vertices = query
        self.queries += 1
        self.inside += 1
        try:
            yield from self.prepared.get(mesh, self._bytes("adjacency", vertices),
                                         lambda: self._prepare(mesh, vertices, slowness))
            yield from self.fields.get(key, self._bytes("field", vertices),
                                       lambda: self._in_slot(self._took("field", vertices, slowness)))
            yield self._env.timeout(self._took("encode", vertices, slowness))
            self.cpu_seconds += self._costs.of("cpu_seconds", "field", vertices)
            self._keep_reply(key, vertices)
        except Refused:
            self.refused += 1
            raise
        finally:
            self.inside -= 1

    def _took(self, part, vertices, slowness):
        return self._costs.of("seconds", part, vertices) * slowness

    def _keep_reply(self, key, vertices):
        size = self._bytes("reply", vertices)
        if size <= self._settings.reply_cache_bytes / 16:  # Routes::keep_reply
            self.replies.keep(key, size)

    def _prepare(self, mesh, vertices, slowness):
        yield from self.meshes.get(mesh, self._bytes("mesh", vertices), lambda: self._load(vertices, slowness))
        yield from self._in_slot(self._took("prepare", vertices, slowness))
        self.cpu_seconds += self._costs.of("cpu_seconds", "load", vertices)

    def _load(self, vertices, slowness):
        refuse_if_full(self._store, self._settings.store_requests)
        size = self._bytes("file", vertices)
        with self._store.request() as turn:
            yield turn
            rate = self._settings.store_bytes_a_second
            yield self._env.timeout(self._took("read", vertices, slowness) + self._settings.store_seconds
                                    + (size / rate if rate else 0))
        self.store_bytes += size
        yield from self._in_slot(self._took("decode", vertices, slowness))

    def _in_slot(self, seconds):
        refuse_if_full(self._slots, self._settings.queue)
        came = self._env.now
        with self._slots.request() as turn:
            yield turn
            # The server sends it away when its time is over; here it leaves when its turn comes. Both are
            # the same for others, for it has taken nobody's time.
            if self._env.now - came > self._settings.queue_seconds:
                raise Refused
            yield self._env.timeout(seconds)
