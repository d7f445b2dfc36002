"""A histogram of times with buckets that widen with the time: any percentile is within 1.1 % of
the truth, from a microsecond to days, in little memory."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator

_PER_OCTAVE = 64  # 2 ** (1 / 64) is 1.011
_UNIT = 1e-6


class Histogram:
    """Times in seconds."""

    def __init__(self) -> None:
        self._buckets: Counter[int] = Counter()
        self.count = 0
        self.sum = 0.0
        self.max = 0.0

    def add(self, seconds: float) -> None:
        """Counts a time."""
        bucket = math.floor(math.log2(max(seconds, _UNIT) / _UNIT) * _PER_OCTAVE)
        self._buckets[bucket] += 1
        self.count += 1
        self.sum += seconds
        self.max = max(self.max, seconds)

    def merge(self, other: Histogram) -> None:
        """Counts all times of another."""
        self._buckets.update(other._buckets)
        self.count += other.count
        self.sum += other.sum
        self.max = max(self.max, other.max)

    @property
    def mean(self) -> float:
        """Seconds; NaN if nothing was counted."""
        return self.sum / self.count if self.count else math.nan

    def percentile(self, percent: float) -> float:
        """The seconds that so many percent of the times do not exceed (the bucket's upper end,
        but never more than the greatest); NaN if nothing was counted."""
        if not self.count:
            return math.nan
        wanted = math.ceil(self.count * percent / 100 - 1e-9)  # 99.9 % of 20000 is 19980
        passed = 0
        for _, upper, count in self.buckets():
            passed += count
            if passed >= wanted:
                return min(upper, self.max)
        return self.max

    def buckets(self, per_octave: int = _PER_OCTAVE) -> Iterator[tuple[float, float, int]]:
        """Those that are not empty, ascending: from, to (seconds) and count. ``per_octave`` a
        divisor of 64: wider ones."""
        wide: Counter[int] = Counter()
        for bucket, count in self._buckets.items():
            wide[bucket * per_octave // _PER_OCTAVE] += count
        for bucket in sorted(wide):
            low = _UNIT * 2 ** (bucket / per_octave)
            yield low, _UNIT * 2 ** ((bucket + 1) / per_octave), wide[bucket]
