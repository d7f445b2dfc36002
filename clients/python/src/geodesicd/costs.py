"""What ways are to cost instead of their length: weights of faces, and slopes.

``mesh.path(a, b, costs=Costs(weights=[(3, "part:2")]))`` finds the cheapest way, where a unit of
length on part 2 costs 3 times what it does elsewhere; ``Costs(slope="tobler")`` the quickest on
foot, in seconds, where lengths are metres. Distances are costs then, and so are ``max``, levels and
offsets. They are those of walking from the sources to the points: with a slope, the way back costs
something else. The method is ``"steiner"``, which needs not be named.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .points import Triple, triple
from .surface_regions import Region, RegionLike, region_of


@dataclass(frozen=True)
class _Weighted:
    """A weight and a region, as a URL has them and as JSON has them."""

    weight: float
    region: Region

    @property
    def mask(self) -> int | None:
        return self.region.mask

    def text(self) -> str | None:
        region = self.region.text()
        return None if region is None else f"{self.weight!r}*{region}"

    def json(self) -> Any:
        return {"weight": self.weight, "region": self.region.json()}


@dataclass(frozen=True)
class Costs:
    """What a segment of a way costs: its length, times the weight of its face, times the rate of
    its slope.

    Attributes:
        weights: pairs of a weight and a region (:mod:`geodesicd.surface_regions`). Where they
            overlap, the last counts; elsewhere it is 1.
        face_weights: (faces,) one for each source face; ``weights`` go over them.
        weight_attribute: instead of ``face_weights`` the name of an attribute of the .glb's or
            .gltf's vertices, such as ``"_MUD"``; a face's weight is the mean at its corners.
        slope: ``"tobler"``, seconds a metre by Tobler's hiking function, ``"energy"``, joules a
            kilogram and metre of walking, or pairs of a slope and what a unit of length costs
            there, ascending. A slope is the rise for each unit of
            length on the map, negative downhill.
        steepest: what is steeper, uphill or downhill, is not walked.
        up: (3,) where up is; +Y without it, as in glTF.
    """

    weights: Sequence[tuple[float, RegionLike]] = ()
    face_weights: ArrayLike | None = None
    slope: str | Sequence[tuple[float, float]] | None = None
    steepest: float | None = None
    up: Triple | None = None
    weight_attribute: str | None = None


def costing(costs: Costs | None) -> dict[str, Any]:
    """In the contract's words."""
    if costs is None:
        return {}
    slope = costs.slope
    if slope is not None and not isinstance(slope, str):
        slope = ",".join(f"{float(steep)!r}:{float(cost)!r}" for steep, cost in slope)
    faces = costs.face_weights
    return {
        "weights": weights_of(costs.weights),
        "face_weights": None if faces is None else np.asarray(faces, np.float64).tolist(),
        "weight_attribute": costs.weight_attribute,
        "slope": slope,
        "steepest": costs.steepest,
        "up": None if costs.up is None else triple(costs.up, "up"),
    }


def weights_of(weights: Sequence[tuple[float, RegionLike]]) -> list[_Weighted]:
    """Weighted regions, as requests take them."""
    return [_Weighted(float(weight), region_of(region)) for weight, region in weights]
