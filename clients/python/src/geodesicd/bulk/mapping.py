"""One question about many meshes."""

from __future__ import annotations

import contextlib
import hashlib
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import GeodesicError
from ..flows import Progress
from ..gltf_files import buffer_files
from ..remarks import kept_remarks
from ..service import Reading
from . import questions
from .cluster import Cluster, cluster, lasting, reason
from .output import Output, output_at
from .report import Answered, Report
from .servers import server_of_worker


def map_meshes(
    question: str,
    meshes: Iterable[str | os.PathLike[str]],
    out: str | os.PathLike[str],
    *,
    client: Any = None,
    url: str | None = None,
    token: str | None = None,
    binary: str | os.PathLike[str] | None = None,
    flags: Sequence[str] = (),
    workers: int | None = None,
    retries: int = 3,
    reading: Reading | None = None,
    progress: Progress | None = None,
    **asked: Any,
) -> Report:
    """Asks many meshes the same, and writes each answer as it comes. What is there already is not
    computed again, nor is a file whose bytes another one has.

    Args:
        question: ``"distance"``, ``"regions"``, ``"distance_at"``, ``"table"``, ``"path"`` or
            ``"samples"``: a method of :class:`geodesicd.Mesh`.
        meshes: files, where the workers find them, too.
        out: a folder ``….zarr``, with a group a mesh, or ``….parquet``, with a file a mesh; either
            is called by the SHA-256 of the mesh's file. All workers write there.
        client: a :class:`distributed.Client` of a cluster; without it, processes here.
        url: the server or fleet to ask; without it $GEODESICD_URL; without that, each worker starts
            a server of its own.
        token: of that server.
        binary, flags: of the workers' own servers, as :func:`geodesicd.serve` has them.
        workers: how many processes, without ``client``; else one a processor.
        retries: how often a mesh is tried again whose worker or server is lost.
        reading: how the files are to be read, as :meth:`geodesicd.Client.upload` takes it.
        progress: called with the part that is done, from 0 to 1.
        asked: what that method takes.

    Raises:
        ValueError, TypeError: no such question, or ``out`` has answers to another one.
        GeodesicError, RuntimeError, FileNotFoundError: there is no server to ask.
    """
    files = [os.fspath(mesh) for mesh in meshes]
    output = output_at(out)
    words = {**questions.checked(question, asked), **(reading or {})}
    with (
        output.opened(words) as manifest,
        cluster(client, url, token, binary, flags, workers, retries) as dask,
    ):
        output.note_engine(manifest, dask.engine)
        job = _Job(question, asked, reading or {}, output, dask.server)
        return _Run(job, dask, manifest, progress).over(files)


@dataclass(frozen=True)
class _Job:
    """What is asked of each mesh, as workers get it."""

    question: str
    asked: Mapping[str, Any]
    reading: Reading
    output: Output
    server: str


class _Run:
    """A run over files: first their digests, since several may have the same bytes and what is
    there is called by them; then the answers that are missing."""

    def __init__(
        self, job: _Job, dask: Cluster, manifest: dict[str, Any], progress: Progress | None
    ) -> None:
        self._job = job
        self._dask = dask
        self._manifest = manifest
        self._progress = progress
        self._report = Report()
        self._unread: dict[str, str] = {}
        self._refused: dict[str, str] = {}  # by the digest
        self._done = 0

    def over(self, files: list[str]) -> Report:
        """All of them."""
        different = list(dict.fromkeys(files))
        digests: dict[str, str] = self._manifest["meshes"]
        try:
            for digest, future in self._dask.run(_answered, self._missing(different)):
                self._note(digest, reason(future) or future.result())
                self._step(different)
        finally:
            failed: dict[str, str] = self._manifest["failures"]
            for file in different:
                failed.pop(file, None)
                why = self._unread.get(file) or self._refused.get(digests.get(file, ""))
                if why:
                    failed[file] = self._report.failures[file] = why
        return self._report

    def _note(self, digest: str, outcome: str | Answered) -> None:
        if isinstance(outcome, Answered):
            self._report.computed += outcome.computed
            self._report.there += not outcome.computed
            if outcome.remarks:
                self._report.remarks[outcome.file] = outcome.remarks
        else:
            self._refused[digest] = outcome

    def _missing(self, files: list[str]) -> Iterator[tuple[str, tuple[Any, ...]]]:
        """The jobs of what has to be computed."""
        there, begun = self._job.output.keys(), set[str]()
        jobs = ((file, (absolute(file),)) for file in files)
        for file, future in self._dask.run(_digest, jobs):
            digest, failure = None, reason(future)
            if failure is None:
                digest, failure = future.result()
            if digest is None:
                self._unread[file] = failure
                self._manifest["meshes"].pop(file, None)
                self._step(files)
                continue
            self._manifest["meshes"][file] = digest
            if digest not in there and digest not in begun:
                yield digest, (self._job, digest, file, absolute(file))
            else:
                self._report.there += digest in there and digest not in begun
                self._step(files)
            begun.add(digest)

    def _step(self, files: list[str]) -> None:
        self._done += 1
        if self._progress is not None:
            self._progress(self._done / len(files))


def absolute(file: str) -> str:
    """A file as workers find it, which may be in another folder."""
    return str(Path(file).absolute())


def digest_of(file: str) -> str:
    """The SHA-256 of a file, as of what is uploaded: of a .gltf file with its buffers."""
    path = Path(file)
    files = {"": path}
    if path.suffix.lower() == ".gltf":
        files |= buffer_files(path)
    digests = {}
    for name, one in files.items():
        with one.open("rb") as opened:
            digests[name] = hashlib.file_digest(opened, "sha256").hexdigest()
    if len(digests) == 1:
        return digests[""]
    whole = "\n".join(f"{digest} {name}" for name, digest in digests.items())
    return hashlib.sha256(whole.encode()).hexdigest()


def _digest(file: str) -> tuple[str | None, str | None]:
    """The digest of a file; else why there is none."""
    try:
        return digest_of(file), None
    except (OSError, ValueError) as error:
        return None, lasting(error)


def _answered(job: _Job, digest: str, file: str, path: str) -> Answered | str:
    """Asks about a mesh and writes the answer; why not, if that would fail alike again."""
    if job.output.has(digest):  # the worker that wrote it was lost before it could say so
        return Answered(file, False, [])
    server = server_of_worker(job.server)
    with kept_remarks() as remarks:
        try:
            mesh = server.client().upload(path, **job.reading)
            try:
                found = questions.answer(job.question, mesh, job.asked)
            finally:
                if server.own:  # nobody else asks for it, and disks end
                    with contextlib.suppress(GeodesicError):
                        mesh.delete()
        except (GeodesicError, OSError, ValueError, TypeError) as error:
            return lasting(error)
    about = {"file": file, "mesh": mesh.id, "vertices": mesh.vertices, "faces": mesh.faces,
             "remarks": remarks}  # fmt: skip
    job.output.write(digest, found, about)
    return Answered(file, True, remarks)
