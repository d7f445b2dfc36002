"""The synchronous client.

    with geodesicd.Client("http://localhost:8080") as client:
        mesh = client.upload("bunny.glb")
        field = mesh.distance(0)

A client may be used by several threads at once.
"""

from __future__ import annotations

import functools
import inspect
import re
import ssl
import time
from collections.abc import Callable
from types import TracebackType
from typing import (
    Any,
    Concatenate,
    Literal,
    ParamSpec,
    Self,
    TypeVar,
    Unpack,
    overload,
)

import httpx
import numpy as np
from numpy.typing import DTypeLike

from . import (
    batches,
    connection,
    drawings,
    exports,
    large_tables,
    lookup,
    loops,
    queries,
    service,
    spreads,
    tables,
)
from .errors import GeodesicError, error_of
from .flows import Flow, Progress, Request, Retries, Send, Step, Stream, Watch, with_retries
from .mesh_input import body_of, warn_of_rounding
from .metadata import Metadata
from .options import CostOptions
from .points import PointsLike
from .results import FloatArray, LabelledDistances
from .wire import Body, Reply

P = ParamSpec("P")
T = TypeVar("T")


def method_signature(flow: Callable[..., Any]) -> inspect.Signature:
    """A query's signature as a method has it: with ``self`` for the mesh's id, and with the result
    that the flow returns."""
    signature = inspect.signature(flow)
    _, *parameters = signature.parameters.values()
    myself = inspect.Parameter("self", inspect.Parameter.POSITIONAL_OR_KEYWORD)
    result = re.sub(r"^Flow\[(.*)\]$", r"\1", str(signature.return_annotation))
    return signature.replace(parameters=[myself, *parameters], return_annotation=result)


def _query(flow: Callable[Concatenate[str, P], Flow[T]]) -> Callable[Concatenate[Mesh, P], T]:
    """A method of :class:`Mesh` made of a query: ``mesh.path(0, 9)`` runs
    ``queries.path(mesh.id, 0, 9)``, with the same parameters and documentation."""

    @functools.wraps(flow)
    def call(mesh: Mesh, /, *arguments: P.args, **named: P.kwargs) -> T:
        return mesh.client.run(flow(mesh.sized_id, *arguments, **named))

    call.__signature__ = method_signature(flow)  # type: ignore[attr-defined]
    return call


class Mesh(Metadata):
    """A mesh on the server: its metadata as attributes, and queries on it. Made by
    :meth:`Client.upload` and :meth:`Client.mesh`."""

    def __init__(self, client: Client, metadata: dict[str, Any]) -> None:
        super().__init__(metadata)
        self.client = client

    regions = _query(queries.regions)
    distance_at = _query(queries.distance_at)
    path = _query(queries.path)
    paths = _query(batches.paths)
    table = _query(tables.table)
    table_file = _query(large_tables.table_file)
    sparse_table = _query(large_tables.sparse_table)
    isolines = _query(spreads.isolines)
    samples = _query(spreads.samples)
    measure = _query(spreads.measure)
    extent = _query(spreads.extent)
    voronoi = _query(spreads.voronoi)
    trace = _query(queries.trace)
    loop = _query(loops.loop)
    logmap = _query(queries.logmap)
    nearest = _query(queries.nearest)
    picture = _query(queries.picture)
    annotated = _query(queries.annotated)
    batch = _query(batches.batch)
    query = _query(queries.query)
    geometry = _query(queries.geometry)
    geometry_glb = _query(queries.geometry_glb)
    cells_glb = _query(drawings.cells_glb)
    discs_glb = _query(drawings.discs_glb)
    map_glb = _query(drawings.map_glb)
    source = _query(queries.source)
    delete = _query(service.delete)
    to_trimesh = _query(exports.to_trimesh)
    to_pyvista = _query(exports.to_pyvista)
    draw = _query(exports.draw)

    @overload
    def distance(
        self,
        sources: PointsLike,
        *,
        labels: Literal[False] = False,
        max: float | None = None,
        dtype: DTypeLike = np.float64,
        quantised: bool = False,
        signed: bool = False,
        **options: Unpack[CostOptions],
    ) -> FloatArray: ...
    @overload
    def distance(
        self,
        sources: PointsLike,
        *,
        labels: Literal[True],
        max: float | None = None,
        **options: Unpack[CostOptions],
    ) -> LabelledDistances: ...
    def distance(
        self, sources: PointsLike, *, labels: bool = False, **options: Any
    ) -> FloatArray | LabelledDistances:
        """The distance field: from the nearest of the sources to every source vertex.

        Args:
            sources: points, which may carry offsets.
            labels: also say which source is nearest; the same as :meth:`regions`.
            max: what is farther counts as unreached; mesh units.
            dtype: float64 or float32, which is half to send.
            quantised: send 2 bytes a vertex; float32 in steps of the greatest distance / 65534.
            signed: below 0 inside ``sources``, which is one closed :class:`geodesicd.Curve` that
                separates the surface: on the smaller side, by area. Not ``quantised``.
            method: how distances are computed; ``client.methods()`` lists them. Without it, the
                server's default.
            points_per_edge: for ``method="steiner"`` only.
            bound: for ``method="auto"`` only; "upper": no distance is below the true one.
            tolerance: for ``method="auto"`` only: the largest relative error, 0 for none.
            within, forbid, walls: the part of the surface that it is about
                (:mod:`geodesicd.surface_regions`).
            costs: of ways that are cheap instead of short (:mod:`geodesicd.costs`).
            deadline: seconds, after which DeadlineExceeded is raised.
            progress: called with the part that is done, from 0 to 1.

        Returns:
            (vertices,) distances, infinite where unreached; with ``labels`` a pair of them and
            of (vertices,) int64 places in ``sources``, -1 where unreached.

        Raises:
            GeodesicError: the server refuses it, or cannot be reached.
        """
        if labels:
            return self.regions(sources, **options)
        return self.client.run(queries.distance(self.sized_id, sources, **options))

    def prepare(self, progress: Progress | None = None) -> Self:
        """Has the server build now what queries need, so that the first is quick."""
        self._read(self.client.run(service.prepare(self.id, progress)))
        return self

    def rename(self, name: str) -> Self:
        """Gives the mesh a name on the server, in place of one that it has; an empty one takes
        that away.

        Args:
            name: at most 200 bytes of UTF-8, without control characters.

        Raises:
            GeodesicError: the server refuses it, or cannot be reached.
        """
        self._read(self.client.run(service.rename(self.id, name)))
        return self

    def refresh(self) -> Self:
        """Reads the metadata anew: ``name``, ``state`` and ``prepared`` change."""
        self._read(self.client.run(service.metadata(self.id)))
        return self


class Client:
    """A connection to a server.

    Args:
        url: where it is; without it $GEODESICD_URL, else http://127.0.0.1:8080.
        token: its bearer token, if the server asks for one.
        timeout: seconds of silence after which ConnectionFailed is raised; None: never.
        retries: when to ask again; ``Retries(attempts=1)``: never.
        verify: as httpx has it: False, or an SSL context of one's own.
        connections: most at once.
    """

    def __init__(
        self,
        url: str | None = None,
        *,
        token: str | None = None,
        timeout: float | None = 300.0,
        retries: Retries | None = None,
        verify: bool | ssl.SSLContext = True,
        connections: int = 20,
    ) -> None:
        options = connection.options(url, token, timeout, verify, connections)
        self._http = httpx.Client(**options)
        self._retries = retries or Retries()

    def __repr__(self) -> str:
        return f"<Client of {self.url}>"

    @property
    def url(self) -> str:
        """Where the server is."""
        return str(self._http.base_url).rstrip("/")

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Closes its connections."""
        self._http.close()

    def upload(
        self,
        mesh: Any,
        faces: Any = None,
        *,
        name: str | None = None,
        progress: Progress | None = None,
        probe: bool = True,
        **reading: Unpack[service.Reading],
    ) -> Mesh:
        """Uploads a mesh, unless the server has it already.

        Args:
            mesh: a path to a .glb, .gltf, .drc, .obj, .ply or .stl file; the bytes of one; a
                pair (vertices (n, 3), faces (m, 3)), or the vertices alone, with faces behind
                them; or a mesh of trimesh, PyVista (PolyData)
                or meshio. Of a .gltf file the path will do: files beside it that hold its buffers
                are sent with it, images are not.
                Positions of arrays arrive as they are, float64 too (a .ply file is sent; a .glb
                file of float32). A .ply file is of some 50 bytes a vertex, so that the server's
                limit on a body, 256 MiB unless set otherwise, is met at 5.4 million vertices.
            name: what to call the mesh, if it has no name yet; without it, the name of the file.
                Arrays and bytes have none. A mesh that has a name keeps it: see
                :meth:`Mesh.rename`.
            progress: called with the part that is done, from 0 to 1: the first half is sending,
                the second the server's work.
            probe: ask first, by its digest, whether the server has it.
            reading: how the file is to be read, where it does not say it itself: ``scale=0.001``,
                ``up="z"``, ``weld=1e-6`` (or ``"off"``), and of a glTF file ``scene=`` and
                ``node=``, by index or name. The same file read in two ways is two meshes.
                ``weld=`` moves vertices at most so far apart onto the first of them. That was
                asked for, so there is no warning of it: ``mesh.warnings`` and ``mesh.report``
                tell how many were moved.

        Raises:
            TypeError, ValueError, OSError: it is no mesh, or cannot be read.
            GeodesicError: the server refuses it, or cannot be reached.

        Warns:
            PrecisionWarning: positions of arrays are too coarse for their edges, or the server
                has made one of several that differ although no ``weld=`` above 0 asked for it.
        """
        body = body_of(mesh, faces)
        asked = service.upload(body, progress, probe=probe, reading=reading, name=name)
        found = self.run(asked)
        warn_of_rounding(body, found, reading, stacklevel=3)
        return Mesh(self, found)

    def mesh(self, id: str) -> Mesh:
        """A mesh that the server has.

        Args:
            id: its id; else its name or how the id begins, if no other mesh is called so.

        Raises:
            NotFound: it has not. ValueError: it has several; the message lists them.
        """
        return Mesh(self, self.run(lookup.metadata(id)))

    def meshes(self, *, page_size: int = 1000) -> list[Mesh]:
        """All meshes that the server has, in the order of their ids."""
        return [Mesh(self, one) for one in self.run(service.meshes(page_size))]

    def status(self) -> dict[str, Any]:
        """Version, limits, load and caches, as ``/v1/status`` has them."""
        return self.run(service.status())

    def methods(self) -> list[dict[str, Any]]:
        """The methods: ``name``, ``paper``, ``exact``, ``cost`` and ``parameters`` of each."""
        return self.run(service.methods())

    def fetch(
        self,
        method: str,
        target: str,
        *,
        headers: dict[str, str] | None = None,
        body: bytes | None = None,
    ) -> Reply:
        """A request of one's own, for what has no method here.

        Raises:
            GeodesicError: the reply is an error.
        """
        request = Request(method, target, headers or {}, body, idempotent=method != "POST")
        reply: Reply = self.run(_single(Send(request)))
        return reply

    def run(self, flow: Flow[T]) -> T:
        """Carries out a flow, to its result."""
        steps = with_retries(flow, self._retries)
        try:
            step = next(steps)
            while True:
                try:
                    outcome = self._carry_out(step)
                except BaseException as error:
                    step = steps.throw(error)
                else:
                    step = steps.send(outcome)
        except StopIteration as end:
            value: T = end.value
            return value
        except GeodesicError as error:
            # Where in here it was noticed is nothing that its reader could use.
            error.server = connection.address(self.url)
            raise error.with_traceback(None) from None

    def _carry_out(self, step: Step) -> Reply | None:
        if isinstance(step, Send):
            return self._send(step.request)
        if isinstance(step, Watch):
            self._watch(step)
        elif isinstance(step, Stream):
            self._stream(step)
        else:
            time.sleep(step.seconds)
        return None

    def _opened(self, request: Request) -> httpx.Response:
        built = self._http.build_request(
            request.method, request.target, **connection.content(request, asynchronous=False)
        )
        return self._http.send(built, stream=True)

    def _send(self, request: Request) -> Reply:
        try:
            response = self._opened(request)
            try:
                body = Body(request.method, response.headers)
                for chunk in response.iter_bytes():
                    body.feed(chunk)
            finally:
                response.close()
        except httpx.RequestError as error:
            raise connection.failure(error, request, self.url) from None
        return Reply(response.status_code, response.headers, body.finish())

    def _stream(self, step: Stream) -> None:
        try:
            response = self._opened(step.request)
            try:
                if response.status_code >= 300:
                    body = response.read()
                    raise error_of(response.status_code, response.headers, body)
                step.on_head(response.status_code, response.headers)
                for chunk in response.iter_bytes():
                    step.on_bytes(chunk)
            finally:
                response.close()
        except httpx.RequestError as error:
            raise connection.failure(error, step.request, self.url) from None

    def _watch(self, step: Watch) -> None:
        try:
            response = self._opened(step.request)
            try:
                if response.status_code >= 400:
                    raise error_of(response.status_code, response.headers, response.read())
                for line in response.iter_lines():
                    step.on_line(line)
            finally:
                response.close()
        except httpx.RequestError as error:
            raise connection.failure(error, step.request, self.url) from None


def _single(step: Step) -> Flow[Any]:
    return (yield step)
