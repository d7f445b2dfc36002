"""What most queries take by keyword: how distances are computed, which part of the surface the
answer is about, what ways cost, and how long to wait for it.

A query has them as ``**options: Unpack[Options]``. :func:`spelled_out` makes keywords of them like
its others, and :func:`asked_by` is what they say to the server.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from typing import Any, ParamSpec, TypedDict, TypeVar, Unpack

from .costs import Costs, costing
from .encoding import milliseconds
from .flows import Progress
from .surface_regions import RegionsLike, WallsLike, regions_of, walls_of

P = ParamSpec("P")
T = TypeVar("T")


class _Computing(TypedDict, total=False):
    # How distances are computed; client.methods() lists the ways. Without it, the server's default.
    method: str | None
    points_per_edge: int | None  # for method="steiner" only
    bound: str | None  # for method="auto" only; "upper": no distance is below the true one
    tolerance: float | None  # for method="auto": the largest relative error of a vertex's distance


class _Keeping(TypedDict, total=False):  # geodesicd.surface_regions says how they are given
    within: RegionsLike | None  # what is outside is as if it were cut away
    forbid: RegionsLike | None  # what is inside is as if it were cut away
    walls: WallsLike | None  # lines that no path crosses


class _Costing(TypedDict, total=False):
    costs: Costs | None  # of ways that are to be cheap instead of short: geodesicd.costs


class _Waiting(TypedDict, total=False):
    deadline: float | None  # seconds, after which DeadlineExceeded is raised
    # Called with the part that is done, from 0 to 1. The query is a job of the server's then,
    # cancelled if the caller is interrupted.
    progress: Progress | None


class SurfaceOptions(_Keeping, _Waiting):
    """Those of queries that compute no distances."""


class Options(_Computing, _Keeping, _Waiting):
    """Those of queries about lengths."""


class CostOptions(_Computing, _Keeping, _Costing, _Waiting):
    """Those of queries about lengths that may be costs instead: all there are."""


_KINDS = {f"Unpack[{kind.__name__}]": kind for kind in (SurfaceOptions, Options, CostOptions)}


def asked_by(**options: Unpack[CostOptions]) -> dict[str, Any]:
    """What they ask of the server, in the contract's words; ``progress`` asks nothing."""
    return {
        "method": options.get("method"),
        "points_per_edge": options.get("points_per_edge"),
        "bound": options.get("bound"),
        "tolerance": options.get("tolerance"),
        "deadline_ms": milliseconds(options.get("deadline")),
        "within": regions_of(options.get("within")),
        "forbid": regions_of(options.get("forbid")),
        "walls": walls_of(options.get("walls")),
        **costing(options.get("costs")),
    }


def spelled_out(query: Callable[P, T]) -> Callable[P, T]:
    """A query whose ``**options`` are keywords like its others: ``help()`` and ``inspect`` tell
    each of them, and it takes no other.

    Raises:
        TypeError: when it is called with another, in Python's own words.
    """
    signature = inspect.signature(query)
    *own, options = signature.parameters.values()
    keywords = [
        inspect.Parameter(
            name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=kind.__forward_arg__
        )
        for name, kind in _KINDS[options.annotation].__annotations__.items()
    ]
    signature = signature.replace(parameters=[*own, *keywords])

    @functools.wraps(query)
    def call(*arguments: P.args, **named: P.kwargs) -> T:
        for name in named:
            if name not in signature.parameters:
                raise TypeError(f"{query.__name__}() got an unexpected keyword argument {name!r}")
        return query(*arguments, **named)

    call.__signature__ = signature  # type: ignore[attr-defined]
    return call
