"""Numbers in as few digits as say them. Distances by ``auto`` and the vertices of most files are
floats of 32 bits: 152.144 of those is 152.14399719238281 among doubles, whose digits are noise."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

# So long is a float of 9 digits with its point: shorter texts are left as they are.
_SHORT = 10


def number(value: float) -> str:
    """The shortest text that reads back to the same number: to the same float of 32 bits where it
    is one, else to the same double."""
    return numbers([value])[0]


def numbers(values: NDArray[Any] | list[float]) -> list[str]:
    """The same of each, in an array's order of rows."""
    doubles = np.asarray(values, dtype=np.float64).ravel()
    with np.errstate(over="ignore"):
        singles = doubles.astype(np.float32)
    texts = []
    for double, single, same in zip(doubles.tolist(), singles, singles == doubles, strict=True):
        said = single if same and len(repr(double)) > _SHORT else double
        texts.append(np.format_float_positional(said, trim="-"))
    return texts


def short(values: NDArray[Any]) -> NDArray[np.float64]:
    """Doubles of those texts, which JSON writes as shortly; of the same shape."""
    return np.array([float(text) for text in numbers(values)]).reshape(np.shape(values))
