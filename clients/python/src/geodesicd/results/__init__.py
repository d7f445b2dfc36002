"""What queries return: plain records of NumPy arrays. Lengths are in mesh units, indices are
those of the uploaded file, and what cannot be reached is infinitely far away."""

from .array_types import Float64, FloatArray, Index
from .distances import LabelledDistances, Logmap, SparseTable
from .lines import Bisector, Isoline, Loop, Path, Trace
from .replies import Answer, BatchReply
from .spreads import Extent, Measure, Samples, Voronoi
from .surface import Geometry, SurfacePoint

__all__ = [
    "Answer",
    "BatchReply",
    "Bisector",
    "Extent",
    "Float64",
    "FloatArray",
    "Geometry",
    "Index",
    "Isoline",
    "LabelledDistances",
    "Logmap",
    "Loop",
    "Measure",
    "Path",
    "Samples",
    "SparseTable",
    "SurfacePoint",
    "Trace",
    "Voronoi",
]
