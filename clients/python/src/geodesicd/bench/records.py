"""What was measured: latencies by kind and by second, errors by code."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

from .histogram import Histogram


@dataclass
class Second:
    """What ended in one second."""

    latencies: Histogram = field(default_factory=Histogram)
    errors: int = 0


class Records:
    """Fills while the load runs; times in seconds."""

    def __init__(self) -> None:
        self.by_kind: dict[str, Histogram] = {}
        self.errors: Counter[str] = Counter()
        self.seconds: list[Second] = []
        self.elapsed = 0.0
        # By how much requests were sent later than they were due since this program was busy:
        # if that is much, it is the load generator that was measured.
        self.lag = Histogram()

    def add(self, kind: str, latency: float, error: str | None, at: float) -> None:
        """One request that ended ``at`` so many seconds after the start. The latency of one
        that failed is not counted: a refusal is quick."""
        while len(self.seconds) <= int(at):
            self.seconds.append(Second())
        self.elapsed = max(self.elapsed, at)
        second = self.seconds[int(at)]
        if error is not None:
            self.errors[f"{kind}: {error}"] += 1
            second.errors += 1
            return
        self.by_kind.setdefault(kind, Histogram()).add(latency)
        second.latencies.add(latency)

    @property
    def all(self) -> Histogram:
        """The latencies of all kinds."""
        together = Histogram()
        for histogram in self.by_kind.values():
            together.merge(histogram)
        return together

    @property
    def failed(self) -> int:
        """How many requests failed."""
        return sum(self.errors.values())

    @property
    def error_share(self) -> float:
        """Which part of all requests failed, 0 to 1."""
        total = self.failed + sum(h.count for h in self.by_kind.values())
        return self.failed / total if total else 0.0
