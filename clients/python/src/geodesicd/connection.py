"""What both clients share of a connection: where the server is, how requests look to httpx,
and which of its failures mean what."""

from __future__ import annotations

import os
import ssl
from collections.abc import AsyncIterator, Iterator
from typing import Any

import httpx

from . import hints
from .errors import ConnectionFailed
from .flows import Request
from .mesh_input import UploadBody

DEFAULT_URL = "http://127.0.0.1:8080"


def url_of(url: str | None) -> str:
    """Where the server is: this, else $GEODESICD_URL, else DEFAULT_URL. ``localhost:8080`` will do.

    Raises:
        ValueError: no address of HTTP.
    """
    named = url or os.environ.get("GEODESICD_URL") or DEFAULT_URL
    full = named if "://" in named else f"http://{named}"
    try:
        parsed = httpx.URL(full)
    except httpx.InvalidURL as error:
        raise ValueError(f"{named!r} is no server's address: {error}") from None
    if parsed.scheme not in ("http", "https") or not parsed.host:
        raise ValueError(f"{named!r} is no server's address, such as {DEFAULT_URL}")
    return full


def address(url: str) -> str:
    """The host and port of a URL."""
    parsed = httpx.URL(url)
    host = f"[{parsed.host}]" if ":" in parsed.host else parsed.host
    return f"{host}:{parsed.port or (443 if parsed.scheme == 'https' else 80)}"


def options(
    url: str | None,
    token: str | None,
    timeout: float | None,
    verify: bool | ssl.SSLContext,
    connections: int,
) -> dict[str, Any]:
    """The arguments of httpx.Client and httpx.AsyncClient alike."""
    headers = {"User-Agent": "geodesicd-python", "Accept": "application/json"}
    if token is not None:
        headers["Authorization"] = f"Bearer {token}"
    return {
        "base_url": url_of(url),
        "headers": headers,
        # To connect is quick or never; an answer may be long in the making.
        "timeout": httpx.Timeout(timeout, connect=10, pool=None),
        "verify": verify,
        "limits": httpx.Limits(
            max_connections=connections, max_keepalive_connections=connections, keepalive_expiry=60
        ),
    }


def content(request: Request, asynchronous: bool) -> dict[str, Any]:
    """A request's headers and content as httpx takes them."""
    headers = dict(request.headers)
    body: Any = request.body
    if isinstance(body, UploadBody):
        headers["Content-Length"] = str(body.length)
        body = _async_chunks(body) if asynchronous else _chunks(body)
    return {"headers": headers, "content": body}


def _chunks(body: UploadBody) -> Iterator[bytes]:
    yield from body.chunks()


async def _async_chunks(body: UploadBody) -> AsyncIterator[bytes]:
    for chunk in body.chunks():
        yield chunk


def failure(error: httpx.RequestError, request: Request, url: str) -> ConnectionFailed:
    """httpx's failure as ours, which says where, and what to do."""
    not_sent = isinstance(error, httpx.ConnectError | httpx.ConnectTimeout | httpx.PoolTimeout)
    detail = str(error) or type(error).__name__
    return ConnectionFailed(
        f"{address(url)} gave no reply to {request.method} {request.target.partition('?')[0]}: "
        f"{detail}",
        sent=not not_sent,
        timeout=isinstance(error, httpx.ReadTimeout),
        lasting=hints.is_lasting(error),
        hint=hints.of_failure(error),
    )
