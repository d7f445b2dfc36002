"""What to do next about an error, where the server's own sentence does not say it."""

from __future__ import annotations

import socket
import ssl
from collections.abc import Iterator

import httpx

_NO_USE = "Asking again will not help: "
_TOKEN = "Client(token=), --token or $GEODESICD_TOKEN"
_OF_CODE = {
    "mesh_unknown": "Upload it, again if it was deleted. client.meshes() and 'geodesic list' tell "
    "what is there",
    "unauthorized": f"Give a token: {_TOKEN}",
    "forbidden": f"Give a token with that scope: {_TOKEN}",
    "method_unknown": "client.methods() lists them",
    "too_many_vertices": "Simplify the mesh, or start the server with a larger --max-vertices",
    "too_many_faces": "Simplify the mesh, or start the server with a larger --max-faces",
    "external_uri": "Upload the .gltf file by its path: the files that it names are sent with it",
    "format_unknown": "Of other formats trimesh and meshio make meshes, which upload takes",
    "snap_too_far": "Are units and axes those of the mesh? If so, give a larger max_snap",
    "outside_region": "A place, such as (x, y, z), finds the closest point of what is left",
    "no_hit": "mesh.bbox says where the mesh is",
    "no_loop": "A loop goes round a handle, a waist or a limb; mesh.path needs none",
    "store_full": f"{_NO_USE}delete meshes, or give the server a larger --store-max-bytes or disk",
    "deadline": "Give a longer deadline=, or a method that is faster",
    "request_timeout": "The request came too slowly: ask again, or over a faster network",
    "overloaded": "Ask later, or give Client more patience: retries=Retries(attempts=)",
    "too_many_requests": "Ask for less at a time, or later: retries=Retries(attempts=)",
    "draining": "The server is about to stop: ask again once it has been started",
    "store_unavailable": "Ask later: the server cannot reach where it keeps its meshes",
    "internal": "This is a fault of the server's: its log says more, under the request's name",
}
# What OpenSSL calls plain HTTP in reply to TLS.
_NO_TLS = {"WRONG_VERSION_NUMBER", "HTTP_REQUEST"}
_BETWEEN = "This is no reply of geodesicd's own"
OF_OTHERS = f"{_BETWEEN}: is that address one, and what is between?"
_OF_STATUS = {
    401: f"{_BETWEEN}: what is before the server wants to know who asks. Give a token: {_TOKEN}",
    403: f"{_BETWEEN}: what is before the server does not let this through",
    413: f"{_NO_USE}what is before the server takes no body so large, such as nginx's "
    "client_max_body_size",
    429: f"{_BETWEEN}: what is before the server wants fewer requests. Ask later",
    502: f"{_BETWEEN}: what is before the server does not reach it. Is it running?",
    503: f"{_BETWEEN}: what is before the server does not reach it. Ask later",
    504: f"{_BETWEEN}: what is before the server waited too long. Give the query a progress=, "
    "which makes it a job",
    507: f"{_NO_USE}what is before the server has no room",
}


# What a hint says in Python, and what is said instead to who asks from a shell.
_IN_SHELL = {
    "client.meshes() and 'geodesic list' tell": "'geodesic list' tells",
    "Client(token=), --token": "--token",
    "client.methods() lists them": "/v1/methods of the server says what each is for",
    "give a larger max_snap": "name a place that is nearer",
    "such as (x, y, z),": "such as p:X,Y,Z,",
    "mesh.bbox says": "The bbox in 'geodesic list --json' says",
    "mesh.path needs none": "'geodesic path' needs none",
    "a longer deadline=": "a longer --deadline",
    "Ask later, or give Client more patience: retries=Retries(attempts=)": "Ask later",
    "or later: retries=Retries(attempts=)": "or later",
    ". Give the query a progress=, which makes it a job": "",
    "Give Client(url) or $GEODESICD_URL": "Give --url or $GEODESICD_URL",
    "ask without progress=, or start": "ask for less, or start",
    "client.status()['limits'] says": "/v1/status of the server says",
    "(max=, dtype=numpy.float32, quantised=True)": "(a nearer --max)",
    "give method='auto', a tolerance or a nearer max": "give --method auto, --tolerance or a "
    "nearer --max",
    "give Client a longer timeout=, or the query a progress=, which makes it a job": "ask later, "
    "or for less",
    ", or give Client(verify=ssl.create_default_context(cafile=))": "",
    "Client(url), --url": "--url",
}


def in_shell(hint: str) -> str:
    """A hint as it is told to who asks from a shell."""
    for python, shell in _IN_SHELL.items():
        hint = hint.replace(python, shell)
    return hint


def remark_in_shell(remark: str) -> str:
    """A remark of the server as it is told to who asks from a shell, where no command has
    ``max_snap``."""
    return remark.replace(", or give max_snap to have such points refused", "")


def of_error(status: int, code: str, detail: str, limit: int | None) -> str | None:
    """What to do about a reply that is an error, whose code is ``http_…`` if it is no problem
    document."""
    if code.startswith("http_3"):
        return "Give Client(url) or $GEODESICD_URL the address that it sends to"
    if code.startswith("http_"):
        return _OF_STATUS.get(status, OF_OTHERS)
    if code == "too_large":
        return _NO_USE + _smaller(detail)
    if code == "too_much_memory":
        return _NO_USE + _cheaper(detail)
    if code == "index_out_of_range" and limit is not None:
        return f"Vertices and faces are counted from 0; the last is {limit}"
    return _OF_CODE.get(code)


def _smaller(detail: str) -> str:
    if "kept" in detail:  # a job's reply
        return "ask without progress=, or start the server with a larger --job-result-bytes"
    if "body" in detail:
        return (
            "send less at once, or start the server with a larger --max-body-bytes (for queries "
            "--max-json-bytes)"
        )
    return "ask for less at once: client.status()['limits'] says how much is taken"


def _cheaper(detail: str) -> str:
    if "reply" in detail:
        return (
            "ask for less (max=, dtype=numpy.float32, quantised=True), or start the server with a "
            "larger --reply-memory-bytes"
        )
    return (
        "give method='auto', a tolerance or a nearer max, or start the server with a larger "
        "--query-memory-bytes"
    )


def of_failure(error: httpx.RequestError) -> str:
    """What to do where no reply came."""
    if isinstance(error, httpx.ReadTimeout):
        return (
            "It may still be computing: give Client a longer timeout=, or the query a progress=, "
            "which makes it a job"
        )
    if _caused(error, ssl.SSLCertVerificationError):
        return (
            "This machine does not trust that certificate: name the file of its authority in "
            "$SSL_CERT_FILE, or give Client(verify=ssl.create_default_context(cafile=))"
        )
    hung_up = _caused(error, ssl.SSLEOFError, ssl.SSLZeroReturnError)
    if _caused(error, ssl.SSLError) and not hung_up:
        return "Does the server speak TLS? Without it, its address begins with http://"
    if _caused(error, socket.gaierror):
        return "Is the name of the server right: Client(url), --url or $GEODESICD_URL?"
    if isinstance(error, httpx.ConnectError | httpx.ConnectTimeout | httpx.PoolTimeout):
        return (
            "Is a server running there? Start one with 'geodesic serve', or name another: "
            "Client(url), --url or $GEODESICD_URL"
        )
    return (
        "The connection broke: ask again. If it breaks again, the server's log may say why; one "
        "that speaks TLS has an address that begins with https://"
    )


def is_lasting(error: httpx.RequestError) -> bool:
    """Whether asking again would fail alike: certificates and what is no TLS do not change. Other
    failures of TLS may pass, such as the end of a connection to a server that starts again."""
    return any(
        isinstance(one, ssl.SSLCertVerificationError)
        or (isinstance(one, ssl.SSLError) and getattr(one, "reason", None) in _NO_TLS)
        for one in _causes(error)
    )


def _caused(error: BaseException, *kinds: type[BaseException]) -> bool:
    """Whether an error is of one of these kinds, or comes from one."""
    return any(isinstance(one, kinds) for one in _causes(error))


def _causes(error: BaseException) -> Iterator[BaseException]:
    """An error and what it comes from."""
    seen: BaseException | None = error
    while seen is not None:
        yield seen
        seen = seen.__cause__ or seen.__context__
