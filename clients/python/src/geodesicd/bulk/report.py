"""What became of a run."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass
class Report:
    """What a run has done.

    Attributes:
        computed: how many answers it has computed and written.
        there: how many were there already.
        failures: what could not be answered, by the file (of a matrix, by the rows), and why. The
            next run on the same output tries again.
        remarks: what the server remarked on answers, such as a point far from the surface.
    """

    computed: int = 0
    there: int = 0
    failures: dict[str, str] = field(default_factory=dict)
    remarks: dict[str, list[str]] = field(default_factory=dict)


@dataclass(frozen=True)
class Answered:
    """What a worker tells of an answer that it has written, or found written."""

    file: str
    computed: bool
    remarks: list[str]
