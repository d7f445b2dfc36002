"""Meshes that are asked about as Zipf's law has it, and how large they are, without tables."""

import numpy as np


class Zipf:
    """Numbers from 1 to `count`, k with a probability that falls as k ** -exponent.

    By rejection-inversion, which needs no table however many there are: W. Hörmann and G. Derflinger,
    Rejection-inversion to generate variates from monotone discrete distributions (1996).
    """

    def __init__(self, count, exponent):
        assert count >= 1 and exponent > 0
        self._count, self._exponent = count, exponent
        self._low, self._high = self._area(1.5) - 1, self._area(count + 0.5)
        self._sure = 2 - self._area_inverse(self._area(2.5) - 2.0 ** -exponent)

    def _area(self, x):
        """The integral of x ** -exponent."""
        rest = 1 - self._exponent
        return np.log(x) if abs(rest) < 1e-9 else (x ** rest - 1) / rest

    def _area_inverse(self, area):
        rest = 1 - self._exponent
        return np.exp(area) if abs(rest) < 1e-9 else (1 + area * rest) ** (1 / rest)

    def draw(self, random, size):
        """An array of `size` numbers."""
        drawn = np.empty(size, dtype=np.int64)
        missing = np.arange(size)
        while missing.size:
            area = self._high + random.random(missing.size) * (self._low - self._high)
            x = self._area_inverse(area)
            k = np.clip(np.floor(x + 0.5), 1, self._count)
            accepted = (k - x <= self._sure) | (area >= self._area(k + 0.5) - k ** -self._exponent)
            drawn[missing[accepted]] = k[accepted]
            missing = missing[~accepted]
        return drawn

    def probabilities(self):
        """Of all numbers; a table, so for few of them."""
        weights = np.arange(1, self._count + 1, dtype=float) ** -self._exponent
        return weights / weights.sum()


def mixed(numbers, salt):
    """64 bits of each number that look random: the finalizer of SplitMix64 (Steele, Lea, Flood 2014)."""
    with np.errstate(over="ignore"):
        x = np.asarray(numbers, dtype=np.uint64) * np.uint64(0x9E3779B97F4A7C15) + np.uint64(salt)
        x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        return x ^ (x >> np.uint64(31))


class Meshes:
    """The meshes 1 to `count`, those asked about most first. Their places and sizes are functions of
    their numbers and the seed: vertices have a log-normal distribution, cut off at both ends."""

    FEWEST, MOST = 100, 1_000_000

    def __init__(self, count, exponent, seed, median=10_000, sigma=1.0):
        self.count, self._zipf = count, Zipf(count, exponent)
        self._seed, self._median, self._sigma = seed, median, sigma

    def draw(self, random, size):
        """Whom queries are about."""
        return self._zipf.draw(random, size)

    def hashes(self, numbers):
        """Where on the ring they are."""
        return (mixed(numbers, self._seed * 3 + 1) >> np.uint64(32)).astype(np.uint32)

    def vertices(self, numbers):
        """How many vertices they have."""
        first, second = ((mixed(numbers, self._seed * 3 + at) >> np.uint64(11)) * 2.0 ** -53 for at in (2, 3))
        normal = np.sqrt(-2 * np.log1p(-first)) * np.cos(2 * np.pi * second)  # Box and Muller
        return np.clip(self._median * np.exp(self._sigma * normal), self.FEWEST, self.MOST).astype(np.int64)


class GivenMeshes:
    """Meshes that are really there: `hashes` and `vertices` of each, those asked about most first."""

    def __init__(self, hashes, vertices, exponent):
        self.count, self._zipf = len(vertices), Zipf(len(vertices), exponent)
        self._hashes, self._vertices = np.array(hashes, dtype=np.uint32), np.array(vertices, dtype=np.int64)

    def draw(self, random, size):
        """Whom queries are about."""
        return self._zipf.draw(random, size)

    def hashes(self, numbers):
        """Where on the ring they are."""
        return self._hashes[numbers - 1]

    def vertices(self, numbers):
        """How many vertices they have."""
        return self._vertices[numbers - 1]
