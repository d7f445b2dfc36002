"""An HTTP/1.1 client for asyncio that shows when things happened: no pool, no
redirects, no surprises."""

import asyncio
import time


class Connection:
    """One connection; requests on it follow each other."""

    def __init__(self, port):
        self._port = port
        self._reader = self._writer = None

    async def connect(self):
        """Opens it, unless it is open."""
        if self._writer is None:
            self._reader, self._writer = await asyncio.open_connection("127.0.0.1", self._port)
        return self

    async def ask(self, target, method="GET"):
        """The reply's status and body; opens the connection again if need be."""
        await self.connect()
        self._writer.write(f"{method} {target} HTTP/1.1\r\nHost: x\r\n\r\n".encode())
        head = await self._reader.readuntil(b"\r\n\r\n")
        status = int(head[9:12])
        size, closes = 0, False
        for line in head.lower().split(b"\r\n"):
            if line.startswith(b"content-length:"):
                size = int(line[15:])
            closes |= line == b"connection: close"
        body = await self._reader.readexactly(size)
        if closes:
            self.close()
        return status, body

    def send(self, data):
        """Bytes that need not be a request."""
        self._writer.write(data)

    @property
    def ended(self):
        """Whether the server has closed it (and everything was read)."""
        return self._reader is None or self._reader.at_eof()

    def close(self):
        """Hangs up."""
        if self._writer is not None:
            self._writer.close()
        self._reader = self._writer = None


async def timed_ask(port, target):
    """A new client's status and seconds, connecting included."""
    begin = time.perf_counter()
    connection = Connection(port)
    try:
        status, _ = await connection.ask(target)
    except (OSError, asyncio.IncompleteReadError):
        status = 0
    finally:
        connection.close()
    return status, time.perf_counter() - begin
