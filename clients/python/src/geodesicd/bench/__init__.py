"""A load test: mixes of uploads, fields, paths and tables, in closed or open loop, with a
latency histogram, a live view, a report and a picture. ``geodesic bench`` runs it; the mixes are
also Locust's (locustfile.py)."""

from .drive import Settings, drive
from .histogram import Histogram
from .mixes import KINDS, Workload, parse_mix
from .records import Records
from .report import failures, report

__all__ = [
    "KINDS",
    "Histogram",
    "Records",
    "Settings",
    "Workload",
    "drive",
    "failures",
    "parse_mix",
    "report",
]
