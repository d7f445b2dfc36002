"""The way from a server to its bucket, which can be slow or cut."""

import selectors
import socket
import threading
import time


class Wire:
    """Passes on what comes to `port` to another port. `seconds` is how long each request is held
    back; while it is `cut`, all connections are closed, and none stays open."""

    def __init__(self, target):
        self._target = target
        self._lock = threading.Lock()
        self._open = set()
        self.seconds = 0.0
        self._cut = False
        self._listening = socket.create_server(("127.0.0.1", 0), backlog=128)
        self.port = self._listening.getsockname()[1]
        threading.Thread(target=self._listen, daemon=True).start()

    @property
    def cut(self):
        """Whether nothing passes."""
        return self._cut

    @cut.setter
    def cut(self, value):
        self._cut = value
        with self._lock:
            for line in self._open if value else ():
                line.shutdown(socket.SHUT_RDWR)

    def _listen(self):
        while True:
            try:
                line, _ = self._listening.accept()
            except OSError:  # stopped
                return
            threading.Thread(target=self._pass_on, args=(line,), daemon=True).start()

    def _pass_on(self, line):
        with line:
            with self._lock:
                self._open.add(line)
            if self._cut:
                with self._lock:
                    self._open.discard(line)
                return
            try:
                with socket.create_connection(("127.0.0.1", self._target)) as other, \
                        selectors.DefaultSelector() as ready:
                    self._between(line, other, ready)
            except OSError:
                pass  # either of them has closed it
            finally:
                with self._lock:
                    self._open.discard(line)

    def _between(self, line, other, ready):
        ends = {line: other, other: line}
        for each in ends:
            ready.register(each, selectors.EVENT_READ)
        asking = False
        while True:
            for key, _ in ready.select():
                data = key.fileobj.recv(65536)
                if not data:
                    return
                if key.fileobj is line and not asking:  # a request begins
                    time.sleep(self.seconds)
                asking = key.fileobj is line
                ends[key.fileobj].sendall(data)

    def stop(self):
        """Takes no more."""
        self.cut = True
        self._listening.shutdown(socket.SHUT_RDWR)
        self._listening.close()
