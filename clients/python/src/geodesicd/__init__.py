"""Geodesic distances and shortest paths on triangle meshes, by a geodesicd server.

    import geodesicd

    with geodesicd.Client("http://localhost:8080") as client:
        mesh = client.upload("bunny.glb")          # or (vertices, faces), trimesh, PyVista, meshio
        field = mesh.distance(0)                   # (vertices,) float64, mesh units
        path = mesh.path(0, (0.1, 0.2, 0.3))       # path.points (n, 3), path.length

    geodesicd.local(vertices, faces).distance(0)   # by a server of this process's own

:class:`AsyncClient` is the same with ``await``. :func:`serve` starts a server for a block.
"""

from .arrays import ply_bytes
from .async_client import AsyncClient, AsyncMesh
from .client import Client, Mesh
from .costs import Costs
from .errors import (
    ConnectionFailed,
    DeadlineExceeded,
    GeodesicError,
    GeodesicWarning,
    JobCancelled,
    NotAllowed,
    NotFound,
    Overloaded,
    PrecisionWarning,
)
from .flows import Retries
from .glb import glb_bytes
from .local_server import LocalServer, connect, local, serve
from .metadata import BoundaryLoop, Finding, Material, Metadata, Part
from .points import OnFace, Point, PointLike, PointsLike, Ray, Vertex, Xyz
from .progress import progress_bar
from .results import (
    Answer,
    BatchReply,
    Bisector,
    Extent,
    Geometry,
    Isoline,
    LabelledDistances,
    Logmap,
    Loop,
    Measure,
    Path,
    Samples,
    SparseTable,
    SurfacePoint,
    Trace,
    Voronoi,
)
from .source_lines import Boundary, Curve, Faces
from .surface_regions import RegionLike, RegionsLike, WallLike, WallsLike

__version__ = "0.1.0"

__all__ = [
    "Answer",
    "AsyncClient",
    "AsyncMesh",
    "BatchReply",
    "Bisector",
    "Boundary",
    "BoundaryLoop",
    "Client",
    "ConnectionFailed",
    "Costs",
    "Curve",
    "DeadlineExceeded",
    "Extent",
    "Faces",
    "Finding",
    "GeodesicError",
    "GeodesicWarning",
    "Geometry",
    "Isoline",
    "JobCancelled",
    "LabelledDistances",
    "LocalServer",
    "Logmap",
    "Loop",
    "Material",
    "Measure",
    "Mesh",
    "Metadata",
    "NotAllowed",
    "NotFound",
    "OnFace",
    "Overloaded",
    "Part",
    "Path",
    "Point",
    "PointLike",
    "PointsLike",
    "PrecisionWarning",
    "Ray",
    "RegionLike",
    "RegionsLike",
    "Retries",
    "Samples",
    "SparseTable",
    "SurfacePoint",
    "Trace",
    "Vertex",
    "Voronoi",
    "WallLike",
    "WallsLike",
    "Xyz",
    "connect",
    "glb_bytes",
    "local",
    "ply_bytes",
    "progress_bar",
    "serve",
]
