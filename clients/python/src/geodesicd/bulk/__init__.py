"""One question about many meshes, or a distance matrix over many sources, by the workers of a Dask
cluster. A run that was stopped goes on from what is there.

    from geodesicd import bulk

    bulk.map_meshes("distance", files, "distances.zarr", sources=0)
    bulk.distance_matrix("bunny.glb", range(0, 30000, 10), "matrix.zarr")

Needs ``pip install 'geodesicd[bulk]'``. Scripts that let it start a cluster of its own do so under
``if __name__ == "__main__":``, as all that start processes by :mod:`multiprocessing`.
"""

try:
    import distributed as _distributed
except ImportError as error:
    raise ImportError(
        f"work in bulk needs Dask: pip install 'geodesicd[bulk]' ({error})"
    ) from error

from .mapping import map_meshes
from .matrix import distance_matrix
from .report import Report

del _distributed

__all__ = ["Report", "distance_matrix", "map_meshes"]
