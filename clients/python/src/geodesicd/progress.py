"""A progress bar for what takes long."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn


@contextmanager
def progress_bar(what: str, console: Console | None = None) -> Iterator[Callable[[float], None]]:
    """A bar on a terminal or in a notebook, and nothing elsewhere, for any ``progress=``:

    with geodesicd.progress_bar("table") as progress:
        table = mesh.table(rows, columns, progress=progress)
    """
    shown = console or Console(stderr=True)
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f}%"),
    )
    with Progress(
        *columns,
        TimeElapsedColumn(),
        console=shown,
        transient=True,
        disable=not (shown.is_terminal or shown.is_jupyter),
    ) as progress:
        task = progress.add_task(what, total=1.0)
        yield lambda part: progress.update(task, completed=part)
