#!/usr/bin/env python3
"""mutation_test.py GEODESICD MAKE_FUZZ_SEEDS [COUNT [FOLDER...]]: damaged files through a
running server.

Takes good files (those that make_fuzz_seeds writes, and those below 200 kB in the FOLDERs),
damages each of them COUNT times (bits flipped, runs lost or repeated, ends cut off, parts exchanged,
pieces of other files), uploads what comes out, and asks for a path where that is a mesh. The
server must answer each within the deadline and never by 5xx, go on, and end with as much
memory as it began with."""

import http.client
import json
import pathlib
import random
import subprocess
import sys
import tempfile
import threading
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "crash"))

from service import Service  # noqa: E402

DEADLINE = 5.0  # seconds
SMALL = 200_000
CLIENTS = 2
# Budgets so small that they are used up before memory is measured for the first time.
FLAGS = ["--store-max-bytes", "2MiB", "--store-when-full", "evict", "--mesh-cache-bytes", "256KiB"]
FLAGS += ["--adjacency-cache-bytes", "512KiB", "--field-cache-bytes", "256KiB"]
FLAGS += ["--reply-cache-bytes", "256KiB", "--log-level", "error"]


def damaged(file, others, chance):
    """The file after one to four accidents."""
    data = bytearray(file)
    for _ in range(chance.randint(1, 4)):
        if not data:
            break
        at = chance.randrange(len(data))
        run = min(len(data) - at, chance.choice([1, 4, 16, 64, len(data) // 4 + 1]))
        match chance.randrange(8):
            case 0 | 1:
                data[at] ^= 1 << chance.randrange(8)
            case 2:
                del data[at : at + run]
            case 3:
                data[at:at] = data[at : at + run]
            case 4:
                del data[at:]
            case 5:
                end = chance.randrange(len(data) - run + 1)
                data[at : at + run], data[end : end + run] = (
                    data[end : end + run], data[at : at + run],
                )  # fmt: skip
            case 6:
                other = chance.choice(others)
                data[at:] = other[chance.randrange(len(other)) :]
            case _:
                data[at : at + run] = bytes([chance.choice([0, 0xFF, 0x7F, 0x80])]) * run
    return bytes(data)


class Client:
    """Uploads on one connection, and notes what is not as it must be."""

    def __init__(self, port):
        self.port = port
        self.connection = http.client.HTTPConnection("127.0.0.1", port, timeout=60)
        self.faults = []
        self.by_status = {}
        self.slowest = 0.0

    def ask(self, method, path, body=None):
        """(status, body), timed."""
        begun = time.monotonic()
        self.connection.request(method, path, body)
        reply = self.connection.getresponse()
        text = reply.read()
        self.slowest = max(self.slowest, time.monotonic() - begun)
        return reply.status, text

    def upload(self, data, name):
        """One file, and one query if it is a mesh."""
        try:
            status, text = self.ask("POST", "/v1/meshes", data)
            self.by_status[status] = self.by_status.get(status, 0) + 1
            if status in (200, 201):
                mesh = json.loads(text)["id"]
                status, text = self.ask("GET", f"/v1/meshes/{mesh}/path?from=v:0&to=v:1")
            elif not json.loads(text)["detail"]:
                self.faults.append(f"{name}: {status} without a reason")
            if status >= 500:
                self.faults.append(f"{name}: {status} {text[:200]!r}: {data[:64].hex()}")
        except (OSError, http.client.HTTPException, ValueError) as error:
            self.faults.append(f"{name}: {error!r}: {data[:64].hex()}")
            self.connection.close()


def resident(service):
    """Resident memory of the server in MB."""
    status = pathlib.Path(f"/proc/{service.process.pid}/status").read_text(encoding="utf-8")
    return int(next(line for line in status.splitlines() if line.startswith("VmRSS")).split()[1]) / 1024


def storm(service, files, count, seed):
    """`count` accidents of each file; the clients, who know what came of them."""
    names = sorted(files)
    others = list(files.values())
    clients = [Client(service.port) for _ in range(CLIENTS)]

    def work(client, number):
        chance = random.Random(f"{seed} {number}")
        for _ in range(number, count, CLIENTS):
            for name in names:
                client.upload(damaged(files[name], others, chance), name)

    threads = [threading.Thread(target=work, args=pair) for pair in zip(clients, range(CLIENTS))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return clients


def main():
    """Prints what came of it; exit status 1 if anything is not as it must be."""
    program, make_seeds = sys.argv[1:3]
    count = int(sys.argv[3]) if len(sys.argv) > 3 else 30
    with tempfile.TemporaryDirectory(prefix="mutation_") as folder:
        folder = pathlib.Path(folder)
        subprocess.run([make_seeds, folder / "seeds"], check=True)
        paths = []
        for kind in ("gltf", "draco", "polygons"):
            paths += sorted((folder / "seeds" / kind).iterdir())
        for more in sys.argv[4:]:
            paths += sorted(path for path in pathlib.Path(more).rglob("*") if path.is_file())
        files = {
            f"{path.parent.name}/{path.name}": path.read_bytes()
            for path in paths
            if path.stat().st_size <= SMALL
        }
        service = Service(program, ["--store", str(folder / "store"), *FLAGS], folder / "log")
        sound = Client(service.port)
        for name, data in files.items():
            sound.upload(data, name)
        good = sound.by_status.get(201, 0) + sound.by_status.get(200, 0)
        storm(service, files, max(count // 10, 30), "warming up")
        before = resident(service)
        begun = time.monotonic()
        clients = storm(service, files, count, "in earnest")
        took = time.monotonic() - begun
        time.sleep(1)
        after = resident(service)
        faults = [fault for client in clients for fault in client.faults]
        by_status = {}
        for client in clients:
            for status, times in client.by_status.items():
                by_status[status] = by_status.get(status, 0) + times
        slowest = max(client.slowest for client in clients)
        metrics = service.ask("GET", "/metrics")[2].decode()
        decodes = dict(
            line.removeprefix('geodesicd_decodes_total{outcome="').split('"} ')
            for line in metrics.splitlines()
            if line.startswith("geodesicd_decodes_total{")
        )
        ready = service.ask("GET", "/readyz")[0]
        if service.process.poll() is not None or ready != 200:
            faults.append(f"the server is not there any more, or not ready: {ready}")
        log = (folder / "log").read_text(encoding="utf-8", errors="replace")
        service.kill()
    print(f"{len(files)} files, {good} of them meshes, {count} accidents each: "
          f"{sum(by_status.values())} uploads in {took:.0f} s, by status {by_status}, decodes "
          f"{decodes}")  # fmt: skip
    print(f"slowest reply {1000 * slowest:.0f} ms; memory {before:.1f} MB before, {after:.1f} after")
    if good < 20:
        faults.append(f"only {good} good files")
    if slowest > DEADLINE:
        faults.append(f"a reply took {slowest:.1f} s")
    # Ten per cent, and what a page or two of freed memory that is kept comes to.
    if after > 1.1 * before + 4:
        faults.append(f"memory grew from {before:.1f} to {after:.1f} MB")
    for fault in faults[:20]:
        print("FAILED:", fault)
    if faults and log:
        print(log[-3000:])
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
