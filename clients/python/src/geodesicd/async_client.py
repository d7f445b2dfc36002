"""The asynchronous client: the synchronous one with ``await`` before each call. Cancelling a
task that waits for a query with ``progress`` cancels the job, too.

    async with geodesicd.AsyncClient("http://localhost:8080") as client:
        mesh = await client.upload("bunny.glb")
        field = await mesh.distance(0)
"""

from __future__ import annotations

import asyncio
import functools
import ssl
from collections.abc import Callable, Coroutine
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
from .client import _single, method_signature
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


def _query(
    flow: Callable[Concatenate[str, P], Flow[T]],
) -> Callable[Concatenate[AsyncMesh, P], Coroutine[Any, Any, T]]:
    """A method of :class:`AsyncMesh` made of a query, as in the synchronous client."""

    @functools.wraps(flow)
    async def call(mesh: AsyncMesh, /, *arguments: P.args, **named: P.kwargs) -> T:
        return await mesh.client.run(flow(mesh.sized_id, *arguments, **named))

    call.__signature__ = method_signature(flow)  # type: ignore[attr-defined]
    return call


class AsyncMesh(Metadata):
    """A mesh on the server, as :class:`~geodesicd.Mesh`; its queries are awaited."""

    def __init__(self, client: AsyncClient, metadata: dict[str, Any]) -> None:
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
    async def distance(
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
    async def distance(
        self,
        sources: PointsLike,
        *,
        labels: Literal[True],
        max: float | None = None,
        **options: Unpack[CostOptions],
    ) -> LabelledDistances: ...
    async def distance(
        self, sources: PointsLike, *, labels: bool = False, **options: Any
    ) -> FloatArray | LabelledDistances:
        """The distance field, as :meth:`geodesicd.Mesh.distance`: (vertices,), mesh units."""
        if labels:
            return await self.regions(sources, **options)
        return await self.client.run(queries.distance(self.sized_id, sources, **options))

    async def prepare(self, progress: Progress | None = None) -> Self:
        """Has the server build now what queries need, so that the first is quick."""
        self._read(await self.client.run(service.prepare(self.id, progress)))
        return self

    async def rename(self, name: str) -> Self:
        """Gives the mesh a name on the server, in place of one that it has; an empty one takes
        that away.

        Args:
            name: at most 200 bytes of UTF-8, without control characters.

        Raises:
            GeodesicError: the server refuses it, or cannot be reached.
        """
        self._read(await self.client.run(service.rename(self.id, name)))
        return self

    async def refresh(self) -> Self:
        """Reads the metadata anew: ``name``, ``state`` and ``prepared`` change."""
        self._read(await self.client.run(service.metadata(self.id)))
        return self


class AsyncClient:
    """A connection to a server; takes what :class:`~geodesicd.Client` takes."""

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
        self._http = httpx.AsyncClient(**options)
        self._retries = retries or Retries()

    def __repr__(self) -> str:
        return f"<AsyncClient of {self.url}>"

    @property
    def url(self) -> str:
        """Where the server is."""
        return str(self._http.base_url).rstrip("/")

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        await self.close()

    async def close(self) -> None:
        """Closes its connections."""
        await self._http.aclose()

    async def upload(
        self,
        mesh: Any,
        faces: Any = None,
        *,
        name: str | None = None,
        progress: Progress | None = None,
        probe: bool = True,
        **reading: Unpack[service.Reading],
    ) -> AsyncMesh:
        """Uploads a mesh, as :meth:`geodesicd.Client.upload`."""
        # Reading and hashing a large file is not to hold up everything else.
        body = await asyncio.to_thread(body_of, mesh, faces)
        asked = service.upload(body, progress, probe=probe, reading=reading, name=name)
        found = await self.run(asked)
        warn_of_rounding(body, found, reading, stacklevel=3)
        return AsyncMesh(self, found)

    async def mesh(self, id: str) -> AsyncMesh:
        """A mesh that the server has.

        Args:
            id: its id; else its name or how the id begins, if no other mesh is called so.

        Raises:
            NotFound: it has not. ValueError: it has several; the message lists them.
        """
        return AsyncMesh(self, await self.run(lookup.metadata(id)))

    async def meshes(self, *, page_size: int = 1000) -> list[AsyncMesh]:
        """All meshes that the server has, in the order of their ids."""
        return [AsyncMesh(self, one) for one in await self.run(service.meshes(page_size))]

    async def status(self) -> dict[str, Any]:
        """Version, limits, load and caches, as ``/v1/status`` has them."""
        return await self.run(service.status())

    async def methods(self) -> list[dict[str, Any]]:
        """The methods, as :meth:`geodesicd.Client.methods`."""
        return await self.run(service.methods())

    async def fetch(
        self,
        method: str,
        target: str,
        *,
        headers: dict[str, str] | None = None,
        body: bytes | None = None,
    ) -> Reply:
        """A request of one's own, as :meth:`geodesicd.Client.fetch`."""
        request = Request(method, target, headers or {}, body, idempotent=method != "POST")
        reply: Reply = await self.run(_single(Send(request)))
        return reply

    async def run(self, flow: Flow[T]) -> T:
        """Carries out a flow, to its result."""
        steps = with_retries(flow, self._retries)
        try:
            step = next(steps)
            while True:
                try:
                    outcome = await self._carry_out(step)
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

    async def _carry_out(self, step: Step) -> Reply | None:
        if isinstance(step, Send):
            return await self._send(step.request)
        if isinstance(step, Watch):
            await self._watch(step)
        elif isinstance(step, Stream):
            await self._stream(step)
        else:
            await asyncio.sleep(step.seconds)
        return None

    async def _opened(self, request: Request) -> httpx.Response:
        built = self._http.build_request(
            request.method, request.target, **connection.content(request, asynchronous=True)
        )
        return await self._http.send(built, stream=True)

    async def _send(self, request: Request) -> Reply:
        try:
            response = await self._opened(request)
            try:
                body = Body(request.method, response.headers)
                async for chunk in response.aiter_bytes():
                    body.feed(chunk)
            finally:
                await response.aclose()
        except httpx.RequestError as error:
            raise connection.failure(error, request, self.url) from None
        return Reply(response.status_code, response.headers, body.finish())

    async def _stream(self, step: Stream) -> None:
        try:
            response = await self._opened(step.request)
            try:
                if response.status_code >= 300:
                    body = await response.aread()
                    raise error_of(response.status_code, response.headers, body)
                step.on_head(response.status_code, response.headers)
                async for chunk in response.aiter_bytes():
                    step.on_bytes(chunk)
            finally:
                await response.aclose()
        except httpx.RequestError as error:
            raise connection.failure(error, step.request, self.url) from None

    async def _watch(self, step: Watch) -> None:
        try:
            response = await self._opened(step.request)
            try:
                if response.status_code >= 400:
                    raise error_of(response.status_code, response.headers, await response.aread())
                async for line in response.aiter_lines():
                    step.on_line(line)
            finally:
                await response.aclose()
        except httpx.RequestError as error:
            raise connection.failure(error, step.request, self.url) from None
