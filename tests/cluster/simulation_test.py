#!/usr/bin/env python3
"""The simulation of many servers against closed forms; no server is started.

    in_simpy.sh simulation_test.py

Bounds are five standard errors, or what is known of an approximation.

GEODESICD_SEED=NUMBER sets what is drawn; it is printed.
"""

import math
import os
import random
import sys

import numpy as np
import simpy

from costs import Costs, drawn_from, line_through, quantiles
from popularity import GivenMeshes, Meshes, Zipf
from replica import Cache, Refused, Replica, Settings
from ring import POINTS, Ring, hash_of, ring_of
from simulate import Fleet

failures = 0


def expect(what, is_so, *details):
    """Prints a line about one thing that must be so."""
    global failures
    failures += not is_so
    print(("ok: " if is_so else "FAILED: ") + what, *details, flush=True)


def is_near(amounts, expected):
    """Whether the mean of independent amounts is the expected one, as far as they can tell; and they can:
    half as much again would be seen."""
    amounts = np.asarray(amounts)
    error = amounts.std(ddof=1) / math.sqrt(len(amounts))
    return abs(amounts.mean() - expected) < 5 * error and error < 0.1 * expected


COSTS = Costs(seconds={"read": (1e-4, 0), "decode": (1e-3, 1e-6), "prepare": (0, 1e-6), "field": (0, 5e-7),
                       "encode": (0, 0)},
              cpu_seconds={"load": (1e-3, 2e-6), "field": (2e-4, 5e-7), "reply": (1e-4, 0)},
              bytes={"file": (0, 36), "mesh": (0, 70), "adjacency": (0, 370), "field": (0, 4), "reply": (2000, 4)},
              spread=[1.0, 1.0], around=[0.0, 0.0], around_kept=[0.0, 0.0])


def queued(random_, slots, places, load, count):
    """Mean wait and share of refusals where fields take exponential times with a mean of 1."""
    env = simpy.Environment()
    costs = Costs(seconds={"field": (1, 0), "encode": (0, 0)}, cpu_seconds=COSTS.cpu_seconds, bytes=COSTS.bytes,
                  spread=[], around=[], around_kept=[])
    replica = Replica(env, costs, Settings(compute_threads=slots, queue=places, queue_seconds=math.inf))
    replica.prepared.keep("mesh", 0)
    waits, first, refused = [], count // 10, []  # it begins empty

    def ask(number, takes):
        began = env.now
        try:
            yield from replica.compute((number, "mesh", 0), takes)
            waits.append((number, env.now - began - takes))
        except Refused:
            refused.append(number)

    def arrivals():
        for number in range(count):
            yield env.timeout(random_.expovariate(load * slots))
            env.process(ask(number, random_.expovariate(1)))

    env.process(arrivals())
    env.run()
    counted = [wait for number, wait in waits if number >= first]
    return sum(counted) / len(counted), sum(number >= first for number in refused) / (count - first)


def test_queue(random_):
    """Waits as Erlang's C has them, refusals as a queue M/M/c/K has them."""
    slots, load = random_.randint(1, 6), random_.uniform(0.5, 0.75)
    offered = slots * load
    full = offered ** slots / math.factorial(slots) / (1 - load)
    waits = full / (full + sum(offered ** k / math.factorial(k) for k in range(slots)))
    mean = waits / (slots * (1 - load))
    seen = [queued(random_, slots, 10 ** 9, load, 4000)[0] for _ in range(20)]
    expect(f"{slots} slots at {load:.0%}: waits as Erlang C has them", is_near(seen, mean),
           f"{np.mean(seen):.3g} {mean:.3g}")
    places, load = random_.randint(0, 4), random_.uniform(0.8, 1.6)
    offered = slots * load
    states = [offered ** k / math.factorial(min(k, slots)) / slots ** max(k - slots, 0)
              for k in range(slots + places + 1)]
    lost = states[-1] / sum(states)
    seen = [queued(random_, slots, places, load, 2000)[1] for _ in range(20)]
    expect(f"and with {places} places to wait at {load:.0%}: refusals as M/M/c/K has them", is_near(seen, lost),
           f"{np.mean(seen):.3g} {lost:.3g}")


def che(probabilities, room):
    """The hit rate of a least-recently-used cache with room for so many values of one size: H. Che, Y. Tung
    and Z. Wang, Hierarchical web caching systems (2002)."""
    low, high = 0.0, 1e12
    for _ in range(200):
        time = (low + high) / 2
        low, high = (time, high) if -np.expm1(-probabilities * time).sum() < room else (low, time)
    return float((probabilities * -np.expm1(-probabilities * low)).sum())


def test_cache(random_, numbers):
    """Hits as Che's approximation has them."""
    count, exponent = random_.randint(1000, 4000), random_.uniform(0.6, 1.2)
    room = random_.randint(count // 20, count // 3)
    zipf, cache, size = Zipf(count, exponent), Cache(simpy.Environment(), room * 8), 8
    draws = 160_000
    for at, key in enumerate(zipf.draw(numbers, draws + 40_000).tolist()):
        if at == 40_000:
            cache.hits = 0
        if not cache.find(key):
            cache.keep(key, size)
    seen, expected = cache.hits / draws, che(zipf.probabilities(), room)
    expect(f"{room} of {count} values, exponent {exponent:.2f}: hits as Che has them", abs(seen - expected) < 0.01,
           f"{seen:.3f} {expected:.3f}")
    expect("and no more bytes than the budget", cache.bytes == room * size, cache.bytes)


def test_popularity(random_, numbers):
    """Numbers as Zipf's law has them, and sizes with the distribution that was asked for."""
    count, exponent = random_.randint(100, 1_000_000), random_.choice([random_.uniform(0.5, 1.5), 1.0])
    zipf, draws = Zipf(count, exponent), 400_000
    head = np.bincount(np.minimum(zipf.draw(numbers, draws), 51), minlength=52)[1:]
    shares = zipf.probabilities()
    expected = draws * np.append(shares[:50], shares[50:].sum())
    chi = float(((head - expected) ** 2 / expected).sum())
    expect(f"{count} numbers, exponent {exponent:.2f}: drawn as Zipf's law says", chi < 50 + 5 * math.sqrt(100),
           f"{chi:.0f}")
    meshes = Meshes(10_000_000, 0.9, random_.randrange(1 << 30), median=10_000, sigma=0.5)
    drawn = np.log(meshes.vertices(numbers.integers(1, 10_000_001, size=40_000)))
    expect("sizes have their median and spread", abs(drawn.mean() - math.log(10_000)) < 5 * 0.5 / 200
           and abs(drawn.std() - 0.5) < 5 * 0.5 / math.sqrt(80_000), f"{drawn.mean():.3f} {drawn.std():.3f}")


def test_ring(random_, numbers):
    """Shares are as uneven as those of random points, and only those of a server that has gone move."""
    servers = random_.randint(300, 1000)
    hashes = np.linspace(0, 2 ** 32 - 1, 1_000_000).astype(np.uint32)
    ring = ring_of(servers)
    shares = np.bincount(ring.server(ring.points_of(hashes)), minlength=servers) / len(hashes) * servers
    expected = math.sqrt((1 - 1 / servers) / POINTS)
    expect(f"{servers} servers: shares differ by {expected:.1%}",
           abs(shares.std() / expected - 1) < 5 / math.sqrt(2 * servers), f"{shares.std():.1%}")
    names = [f"10.1.{numbers.integers(256)}.{at}:{numbers.integers(1, 65536)}" for at in range(20)]
    gone = random_.randrange(20)
    all_, rest = Ring(names), Ring(names[:gone] + names[gone + 1:])
    before = all_.server(all_.points_of(hashes))
    after = rest.server(rest.points_of(hashes))
    after = after + (after >= gone)
    expect("a server less: its meshes move and no others", ((before == gone) | (before == after)).all()
           and (before == gone).any())
    expect("a key has CRC-32's hash", hash_of("123456789") == 0xCBF43926)


def test_fits(random_):
    """A line is found again, and so is a distribution."""
    fixed, each = random_.uniform(0, 5), random_.uniform(0.1, 2)
    sizes = [2.0 ** k for k in range(8, 17)]
    found = line_through(sizes, [fixed + each * size for size in sizes])
    expect("a line is found again", np.allclose(found, (fixed, each), rtol=1e-6, atol=1e-6), found)
    found = line_through(sizes, [max(each * size - 1, 0) for size in sizes])
    expect("no amount is negative", min(found) >= 0, found)
    numbers = np.random.default_rng(random_.randrange(1 << 30))
    again = drawn_from(quantiles(numbers.random(10_000)), numbers, 10_000)
    expect("a distribution is drawn from", abs(again.mean() - 0.5) < 10 * math.sqrt(1 / 12 / 10_000), again.mean())


def test_fleet(random_):
    """The same seed gives the same, another one something else."""
    seed = random_.randrange(1 << 30)

    def outcome(seed_):
        settings = Settings(adjacency_cache_bytes=200 << 20, reply_cache_bytes=1 << 20, field_cache_bytes=1 << 20)
        fleet = Fleet(COSTS, settings, Meshes(2000, 0.9, seed_), ring_of(8), 8, 100, seed_)
        fleet.warm(10_000, settings.adjacency_cache_bytes)
        return fleet.run(8000, 500)

    one, same, other = outcome(seed), outcome(seed), outcome(seed + 1)
    expect("the same seed gives the same", (one.latencies == same.latencies).all() and one.hottest == same.hottest)
    expect("another one something else", one.seconds != other.seconds)
    expect("hits are shares", 0 < one.reply_hits < one.mesh_hits < 1, one.reply_hits, one.mesh_hits)


def test_hot_mesh(random_):
    """All ask about one mesh, and would keep half of all slots busy: nginx gives it three servers, and a
    balancer that shares all of them."""
    servers, settings = random_.randint(7, 12), Settings(field_cache_bytes=0, reply_cache_bytes=0)
    took = COSTS.of("seconds", "field", 10_000)

    def outcome(bounded):
        meshes = GivenMeshes([random_.randrange(1 << 32)], [10_000], 1)
        fleet = Fleet(COSTS, settings, meshes, ring_of(servers), servers, 1 << 40, random_.randrange(1 << 30), bounded)
        return fleet.run(20_000, 0.5 * servers * settings.compute_threads / took)

    alone, shared = outcome(False), outcome(True)
    done = 3 / (0.5 * servers)
    expect("one mesh for all: nginx refuses what is more than three servers can do",
           abs(1 - alone.refused / alone.queries - done) < 0.1, f"{1 - alone.refused / alone.queries:.2f} {done:.2f}")
    expect("a balancer that shares refuses nothing, and no server has twice the mean",
           shared.refused == 0 and shared.hottest < 2 < alone.hottest,
           shared.refused, f"{shared.hottest:.2f} {alone.hottest:.2f}")


def main():
    """Exits with 1 if something was not so."""
    seed = os.environ.get("GEODESICD_SEED") or str(random.randrange(1 << 32))
    print(f"GEODESICD_SEED={seed}", flush=True)
    random_ = random.Random(seed)
    numbers = np.random.default_rng(random_.randrange(1 << 32))
    test_queue(random_)
    test_cache(random_, numbers)
    test_popularity(random_, numbers)
    test_ring(random_, numbers)
    test_fits(random_)
    test_fleet(random_)
    test_hot_mesh(random_)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
