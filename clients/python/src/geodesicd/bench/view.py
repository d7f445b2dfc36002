"""The load test while it runs, in the terminal."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping

from rich.console import Group, RenderableType
from rich.panel import Panel
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from .drive import Settings
from .histogram import Histogram
from .records import Records

_BARS = " ▁▂▃▄▅▆▇█"


class View:
    """Renders the records anew each time it is drawn."""

    def __init__(self, records: Records, settings: Settings, mix: Mapping[str, float]) -> None:
        self._records = records
        self._settings = settings
        self._mix = mix
        self._start = time.perf_counter()

    def __rich__(self) -> RenderableType:
        records, settings = self._records, self._settings
        elapsed = time.perf_counter() - self._start
        load = (
            f"open loop, {settings.rate:g} a second"
            if settings.clients is None
            else f"closed loop, {settings.clients} clients"
        )
        ramp = f", ramp {settings.ramp:g} s" if settings.ramp else ""
        rates = [second.latencies.count for second in records.seconds]
        head = Text.assemble(
            (f"{load}{ramp}", "bold"),
            f"   {min(elapsed, settings.seconds):.0f} of {settings.seconds:g} s   ",
            (f"{records.all.count / max(records.elapsed, 1e-9):.1f} replies a second", "cyan"),
        )
        if records.failed:
            head.append(f"   {records.failed} errors ({records.error_share:.2%})", "bold red")
        errors = [Text(f"{what}: {n}", "red") for what, n in records.errors.most_common(3)]
        return Panel(
            Group(
                head,
                ProgressBar(total=settings.seconds, completed=min(elapsed, settings.seconds)),
                Text("replies a second  " + spark(rates[-60:]), "cyan"),
                _table(records),
                *_bars(records.all),
                *errors,
            ),
            title="geodesic bench",
        )


def spark(values: list[int]) -> str:
    """Numbers as a line of blocks."""
    top = max(values, default=0) or 1
    return "".join(_BARS[math.ceil(value / top * (len(_BARS) - 1))] for value in values)


def _table(records: Records) -> Table:
    table = Table(box=None, pad_edge=False)
    for name in ("latency, ms", "count", "mean", "p50", "p90", "p99", "p99.9", "max"):
        table.add_column(name, justify="left" if name == "latency, ms" else "right")
    rows = sorted(records.by_kind.items())
    for kind, histogram in [*rows, ("all", records.all)] if len(rows) > 1 else rows:
        numbers = [histogram.mean, *(histogram.percentile(p) for p in (50, 90, 99, 99.9))]
        cells = (f"{seconds * 1000:.2f}" for seconds in [*numbers, histogram.max])
        table.add_row(kind, f"{histogram.count:,}", *cells)
    return table


def _bars(histogram: Histogram) -> list[Text]:
    """The histogram, a line an octave."""
    buckets = list(histogram.buckets(1))
    top = max((count for *_, count in buckets), default=1)
    return [
        Text.assemble(
            f"{low * 1000:9.2f} to {high * 1000:9.2f} ms ",
            ("█" * max(1, round(40 * count / top)), "green"),
            f" {count:,}",
        )
        for low, high, count in buckets[-14:]
    ]
