"""The walk itself: asks, holds each reply against the document and remembers what there
was; and the requests that the document's examples make."""

import collections
import hashlib
import json
import pathlib
import subprocess
import tempfile

import bodies

UPLOADS = ("uploadMesh", "putMesh")
# Of these parameters exactly one is needed, which the document can only say in words.
NEEDED = {"getIsolines": ["levels"], "getTrace": ["direction"], "getLoop": ["through"]}


class Walk:
    """Asks, checks each reply, and remembers what there was."""

    def __init__(self, contract):
        self.contract = contract
        self.statuses = collections.defaultdict(set)  # operation -> statuses
        self.codes = collections.defaultdict(set)  # operation -> (status, code)
        self.types = collections.defaultdict(set)  # operation -> types of good replies
        self.replies = 0
        self.problems = []

    def note(self, operation, reply, how):
        """Holds a reply against the document."""
        self.replies += 1
        self.statuses[operation.id].add(str(reply.status))
        if reply.status < 300:
            self.types[operation.id].add(reply.headers.get("content-type", "").split(";")[0])
        if reply.headers.get("content-type") == "application/problem+json" and reply.body:
            self.codes[operation.id].add((str(reply.status), json.loads(reply.body)["code"]))
        for wrong in self.contract.wrong(operation, reply):
            self.fail(f"{operation.id} {how}: {reply.status}: {wrong}")
        return reply

    def fail(self, text):
        """Remembers what is wrong; the walk goes on."""
        if text not in self.problems:
            self.problems.append(text)

    def ask(self, server, operation, target, body=None, headers=None, **more):
        """One request, checked."""
        headers = dict(headers or {})
        if isinstance(body, (dict, list, str)) and body:
            kinds = list((operation.body or {"content": ["text/plain"]})["content"])
            headers.setdefault("Content-Type", kinds[0])
            body = body if isinstance(body, str) else json.dumps(body)
        try:
            reply = server.ask(operation.method, target, body, headers, **more)
        except OSError as error:
            raise RuntimeError(
                f"{operation.method} {target} {body}: {error!r}; the server's end: "
                f"{server.process.poll()} {server.log()}"
            ) from error
        shown = target if len(target) < 160 else target[:157] + "..."
        return self.note(operation, reply, f"{operation.method} {shown} {str(body or '')[:120]}")

    def ask_for(self, status, *arguments, **more):
        """One request that has to have this status."""
        reply = self.ask(*arguments, **more)
        if reply.status != status:
            self.fail(
                f"{arguments[1].id}: {reply.status} instead of {status}: "
                f"{arguments[2:]} {reply.body[:300]}"
            )
        return reply


def least_query(operation):
    """The parameters of the URL that an operation cannot do without."""
    extra = [
        (name, value)
        for name, value in operation.example_query(all_of_them=True)
        if name in NEEDED.get(operation.id, ())
    ]
    return operation.example_query() + extra


def first_request(operation, upload=bodies.TRIANGLE, **path):
    """The least that an operation takes: its target and its body."""
    if operation.id == "putMesh":
        path = {"id": hashlib.sha256(upload).hexdigest(), **path}
    target = operation.target(least_query(operation), **path)
    for _, value in operation.example_bodies():
        return target, value
    return target, upload if operation.body else None


def samples(build):
    """The sample meshes by their names; plane.glb is the one of the document's examples."""
    with tempfile.TemporaryDirectory(prefix="contract_samples_") as folder:
        command = [f"{build}/make_samples", folder]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        return {file.name: file.read_bytes() for file in pathlib.Path(folder).iterdir()}
