"""A relay between a balancer and a server that notes which of them closes a connection first."""

import collections
import selectors
import socket
import threading


class Relay:
    """Listens on `port` and passes on to the server's port. `closed`: how often which side was first."""

    def __init__(self, server):
        self._server = server
        self._lock = threading.Lock()
        self._open = set()
        self.closed = collections.Counter()
        self.taken = 0
        self._listening = socket.create_server(("127.0.0.1", 0), backlog=128)
        self.port = self._listening.getsockname()[1]
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self):
        while True:
            try:
                balancer, _ = self._listening.accept()
            except OSError:  # stopped
                return
            threading.Thread(target=self._pass_on, args=(balancer,), daemon=True).start()

    def _pass_on(self, balancer):
        with balancer, socket.create_connection(("127.0.0.1", self._server)) as server, \
                selectors.DefaultSelector() as ready:
            with self._lock:
                self._open.add(balancer)
                self.taken += 1
            others = {balancer: ("balancer", server), server: ("server", balancer)}
            for line in others:
                ready.register(line, selectors.EVENT_READ)
            first = None
            while first is None:
                for key, _ in ready.select():
                    name, other = others[key.fileobj]
                    try:
                        data = key.fileobj.recv(65536)
                        if data:
                            other.sendall(data)
                    except OSError:
                        data = b""
                    if not data:
                        first = first or name
            with self._lock:
                self._open.discard(balancer)
                self.closed[first] += 1

    @property
    def open(self):
        """How many connections there are now."""
        with self._lock:
            return len(self._open)

    def stop(self):
        """Takes no more."""
        self._listening.shutdown(socket.SHUT_RDWR)
        self._listening.close()
