"""The load test's outcome as JSON, as a picture, and as a verdict for CI."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from .drive import Settings
from .histogram import Histogram
from .records import Records


def latencies(histogram: Histogram) -> dict[str, Any]:
    """A histogram's numbers, in milliseconds."""

    def in_ms(seconds: float) -> float | None:
        return None if math.isnan(seconds) else round(seconds * 1000, 4)

    return {
        "count": histogram.count,
        "mean_ms": in_ms(histogram.mean),
        **{
            f"p{percent:g}_ms": in_ms(histogram.percentile(percent))
            for percent in (50, 75, 90, 95, 99, 99.9)
        },
        "max_ms": in_ms(histogram.max) if histogram.count else None,
    }


def report(records: Records, settings: Settings, mix: Mapping[str, float]) -> dict[str, Any]:
    """All of it as JSON. Latencies are milliseconds, those of an open loop from when requests
    were due."""
    together = records.all
    elapsed = max(records.elapsed, 1e-9)
    return {
        "loop": "open" if settings.clients is None else "closed",
        "settings": asdict(settings),
        "mix": dict(mix),
        "elapsed_seconds": round(records.elapsed, 3),
        "requests": together.count + records.failed,
        "throughput_per_second": round(together.count / elapsed, 3),
        "errors": {
            "count": records.failed,
            "share": records.error_share,
            "by_kind_and_code": dict(records.errors),
        },
        "latency": latencies(together),
        "latency_by_kind": {kind: latencies(h) for kind, h in sorted(records.by_kind.items())},
        "generator_lag": latencies(records.lag) if settings.clients is None else None,
        "histogram": [
            {"from_ms": low * 1000, "to_ms": high * 1000, "count": count}
            for low, high, count in together.buckets(8)
        ],
        "seconds": [
            {
                "second": number,
                "completed": second.latencies.count,
                "errors": second.errors,
                "p50_ms": latencies(second.latencies)["p50_ms"],
                "p99_ms": latencies(second.latencies)["p99_ms"],
            }
            for number, second in enumerate(records.seconds)
        ],
    }


def parse_limits(text: str) -> dict[str, float]:
    """Limits in milliseconds: ``"50"`` for all kinds together, ``"path=50,field=200"`` by kind.

    Raises:
        ValueError: one is no number.
    """
    limits = {}
    for part in text.split(","):
        kind, equals, limit = part.rpartition("=")
        limits[kind if equals else "all"] = float(limit)
    return limits


def failures(
    outcome: Mapping[str, Any], p99: Mapping[str, float] | None, error_share: float | None
) -> list[str]:
    """What is worse than the limits, a sentence each; none: passed. A kind of which nothing
    succeeded has no p99, and so does not keep its limit."""
    found = []
    for kind, limit in (p99 or {}).items():
        numbers = outcome["latency"] if kind == "all" else outcome["latency_by_kind"].get(kind)
        actual = numbers["p99_ms"] if numbers else None
        if actual is None:
            found.append(f"p99 of {kind}: nothing succeeded, so that {limit:g} ms are not kept")
        elif actual > limit:
            found.append(f"p99 of {kind}: {actual:g} ms, more than {limit:g} ms")
    share = outcome["errors"]["share"]
    if error_share is not None and share > error_share:
        found.append(f"errors: a share of {share:.4g}, more than {error_share:g}")
    return found


def _steps(histogram: Histogram) -> tuple[list[float], list[float]]:
    """Shares and edges (ms) of a histogram's buckets, with the empty ones between."""
    shares: list[float] = []
    edges: list[float] = []
    for low, high, count in histogram.buckets(8):
        if edges and low * 1000 > edges[-1] * 1.001:
            shares.append(0.0)
            edges.append(low * 1000)
        edges = edges or [low * 1000]
        shares.append(count / histogram.count)
        edges.append(high * 1000)
    return shares, edges


def draw(records: Records, outcome: Mapping[str, Any], file: Path) -> None:
    """The picture: throughput and latency over time, and the distribution of latencies.

    Raises:
        ImportError: matplotlib is not installed.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 8), dpi=120, layout="constrained", facecolor="white")
    rate, over_time, distribution = figure.subplots(3, 1)
    figure.suptitle(
        f"{outcome['loop']} loop · {outcome['requests']:,} requests · "
        f"{outcome['throughput_per_second']:.1f} a second · p99 {outcome['latency']['p99_ms']} ms"
        f" · {outcome['errors']['count']} errors",
        fontsize=11,
    )
    # What ended in the last, shorter second would look like a slump.
    seconds = outcome["seconds"][: max(1, int(records.elapsed + 0.1))]
    at = [second["second"] + 0.5 for second in seconds]
    done = [second["completed"] for second in seconds]
    wrong = [second["errors"] for second in seconds]
    rate.bar(at, done, width=0.95, color="#3b7ea1", label="completed")
    rate.bar(at, wrong, width=0.95, bottom=done, color="#d81e5b", label="errors")
    rate.set_ylabel("replies a second")
    rate.set_xlabel("seconds")
    rate.legend(loc="lower right", fontsize=8)

    for name, colour in (("p99_ms", "#d81e5b"), ("p50_ms", "#3b7ea1")):
        there = [(t, s[name]) for t, s in zip(at, seconds, strict=True) if s[name] is not None]
        if there:
            over_time.plot(*zip(*there, strict=True), color=colour, marker=".", label=name[:3])
    over_time.set_yscale("log")
    over_time.set_ylabel("latency (ms)")
    over_time.set_xlabel("seconds")
    if over_time.get_legend_handles_labels()[0]:
        over_time.legend(loc="upper right", fontsize=8)

    for kind, histogram in sorted(records.by_kind.items()):
        shares, edges = _steps(histogram)
        distribution.stairs(
            shares,
            edges,
            label=f"{kind} (p99 {histogram.percentile(99) * 1000:.3g} ms)",
            fill=True,
            alpha=0.45,
        )
    distribution.set_xscale("log")
    distribution.set_xlabel("latency (ms)")
    distribution.set_ylabel("share of its kind")
    if records.by_kind:
        distribution.legend(loc="upper right", fontsize=8)
    for axes in (rate, over_time, distribution):
        axes.grid(alpha=0.3)
        axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(file)
