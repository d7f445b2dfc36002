#!/usr/bin/env python3
"""Kills the server with kill -9 at random moments of uploads, deletes and evictions.

    crash_test.py GEODESICD [ROUNDS [SEED]]      15 rounds unless told otherwise

After every restart: each mesh whose upload was acknowledged is there and whole, unless
its removal was acknowledged too; each that was not acknowledged is there whole or not at
all; nothing is left of files half written. Every other round has a budget and evicts:
then the last acknowledged upload must be there, and the budget must hold on the disk.
At the end, a store of 10,000 meshes must be ready within a second of computing.
"""

import http.client
import json
import pathlib
import random
import sys
import tempfile
import threading
import time

from service import Service, digest, files_below, mesh

WORKERS = 3
BUDGET = 600_000  # bytes; a mesh takes 2,000 to 70,000
FEWEST, MOST = 8, 48  # columns of a mesh


class Ledger:
    """What the clients know of each mesh: the store's side must agree with it."""

    def __init__(self):
        self.lock = threading.Lock()
        self.bytes = {}  # of every mesh ever sent, by id
        self.state = {}  # id -> "there", "gone" or "unknown" (a change was not answered)
        self.last = None  # the upload acknowledged last
        self.answered = 0

    def begin(self, data):
        with self.lock:
            self.bytes[digest(data)] = data
            self.state[digest(data)] = "unknown"

    def settle(self, mesh_id, state):
        with self.lock:
            self.state[mesh_id] = state
            self.answered += 1
            if state == "there":
                self.last = mesh_id
            elif self.last == mesh_id:
                self.last = None

    def one_to_remove(self, numbers):
        """Some mesh that is there, marked as unknown; no two workers get the same."""
        with self.lock:
            there = [mesh_id for mesh_id, state in self.state.items() if state == "there"]
            if len(there) < 5:
                return None
            mesh_id = numbers.choice(sorted(there))
            self.state[mesh_id] = "unknown"
            if self.last == mesh_id:
                self.last = None
            return mesh_id


def work(service, ledger, seed, stop, faults):
    """Uploads new meshes and removes old ones until the server is gone."""
    numbers = random.Random(seed)
    while not stop.is_set():
        try:
            mesh_id = ledger.one_to_remove(numbers) if numbers.random() < 0.4 else None
            if mesh_id is not None:
                status, _, body = service.ask("DELETE", f"/v1/meshes/{mesh_id}")
                if status not in (204, 404):
                    faults.append(f"DELETE is answered {status}: {body[:200]}")
                ledger.settle(mesh_id, "gone")
            else:
                data = mesh(numbers.randint(FEWEST, MOST), numbers.random())
                ledger.begin(data)
                status, _, body = service.ask("POST", "/v1/meshes", data)
                if status != 201:
                    faults.append(f"POST is answered {status}: {body[:200]}")
                    return
                ledger.settle(digest(data), "there")
        except (OSError, http.client.HTTPException):
            return  # killed: what was not answered stays unknown


def check(service, store, ledger, evicts):
    """The faults found after a restart; the ledger then takes over what is there."""
    faults = []
    if files_below(store / "tmp"):
        faults.append("something half written is left in tmp/")
    if files_below(store / "quarantine"):
        faults.append("something is in quarantine")
    listed = set(service.ids())
    for mesh_id in listed:
        status, _, body = service.ask("GET", f"/v1/meshes/{mesh_id}/source")
        if status != 200 or digest(body) != mesh_id or body != ledger.bytes.get(mesh_id):
            faults.append(f"{mesh_id} is listed but not whole: {status}")
        status, about = service.get_json(f"/v1/meshes/{mesh_id}")
        if status != 200 or about["bytes"] != len(body):
            faults.append(f"{mesh_id} is not described: {status}")
    for mesh_id, state in ledger.state.items():
        if state == "gone" and mesh_id in listed:
            faults.append(f"{mesh_id} was removed and is there again")
        if state == "there" and mesh_id not in listed and not evicts:
            faults.append(f"{mesh_id} was acknowledged and is lost")
        if state != "there" and mesh_id not in listed:
            status, _ = service.get_json(f"/v1/meshes/{mesh_id}")
            if status != 404:
                faults.append(f"{mesh_id} is not listed but answered {status}")
    if evicts:
        if ledger.last is not None and ledger.last not in listed:
            faults.append(f"{ledger.last} was acknowledged last and is lost")
        held = sum(p.stat().st_size for p in files_below(store / "objects"))
        held += sum(p.stat().st_size for p in files_below(store / "meta"))
        if held > BUDGET:
            faults.append(f"{held} bytes are over the budget of {BUDGET}")
    ledger.state = {mesh_id: "there" for mesh_id in listed}
    ledger.last = None
    return faults


def kill_at_random_moments(program, folder, rounds, seed):
    """Runs the rounds; the number of those in which something was wrong."""
    numbers = random.Random(seed)
    stores = {False: folder / "store", True: folder / "evicting"}
    ledgers = {False: Ledger(), True: Ledger()}
    bad = answered = 0
    for number in range(rounds):
        evicts = number % 2 == 1
        ledger, store = ledgers[evicts], stores[evicts]
        flags = ["--store", str(store), "--log-level", "warn"]
        if evicts:
            flags += ["--store-max-bytes", str(BUDGET), "--store-when-full", "evict"]
        service = Service(program, flags, folder / "log")
        stop, faults = threading.Event(), []
        workers = [
            threading.Thread(target=work, args=(service, ledger, numbers.random(), stop, faults))
            for _ in range(WORKERS)
        ]
        for worker in workers:
            worker.start()
        time.sleep(numbers.uniform(0.02, 0.6))
        service.kill()
        stop.set()
        for worker in workers:
            worker.join()
        answered += ledger.answered
        ledger.answered = 0
        unknown = sum(state == "unknown" for state in ledger.state.values())
        service = Service(program, flags, folder / "log")
        faults += check(service, store, ledger, evicts)
        if number % 4 < 2:
            if service.stop() != 0:
                faults.append("the server did not stop in order")
        else:
            service.kill()
        for fault in faults:
            print(f"FAILED: round {number}: {fault}")
        bad += bool(faults)
        if number % 20 == 0:
            print(f"round {number}: {len(ledger.state)} meshes there, {unknown} were not answered")
    print(f"{rounds} kills, {answered} changes acknowledged, {bad} rounds with faults")
    if answered < rounds:
        print("FAILED: fewer changes than kills: this has tested nothing")
        bad += 1
    return bad


def start_with_ten_thousand(program, folder):
    """Whether a store of 10,000 meshes is ready within a second of the processor's time."""
    store = folder / "large"
    described = json.dumps({"id": "x" * 64, "parts": []}).encode()
    for number in range(10_000):
        data = str(number).encode()
        mesh_id = digest(data)
        for path, content in (
            (store / "objects" / mesh_id[:2] / mesh_id, data),
            (store / "meta" / mesh_id[:2] / f"{mesh_id}.json", described),
        ):
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
    service = Service(program, ["--store", str(store)], folder / "log")
    _, status = service.get_json("/v1/status")
    service.kill()
    print(f"start with 10,000 meshes: {service.busy_to_start:.2f} s of the processor's time, "
          f"{service.seconds_to_start:.2f} s on this machine as busy as it is")
    if status["meshes"] != 10_000:
        print(f"FAILED: {status['meshes']} of 10,000 meshes are known")
    if service.busy_to_start > 1:
        print("FAILED: that takes longer than a second")
    return status["meshes"] == 10_000 and service.busy_to_start <= 1


def main():
    program = sys.argv[1]
    rounds = int(sys.argv[2]) if len(sys.argv) > 2 else 15
    seed = int(sys.argv[3]) if len(sys.argv) > 3 else random.randrange(1 << 32)
    print(f"seed {seed}", flush=True)
    with tempfile.TemporaryDirectory(prefix="crash_test_") as name:
        folder = pathlib.Path(name)
        bad = kill_at_random_moments(program, folder, rounds, seed)
        fast = start_with_ten_thousand(program, folder)
        if bad or not fast:
            for line in (folder / "log").read_text(errors="replace").splitlines()[-20:]:
                print(f"  server: {line}")
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
