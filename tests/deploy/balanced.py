"""Three real servers behind a real nginx, which is configured as a file in deploy/ says."""

import http.client
import json
import pathlib
import re
import subprocess
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(HERE.parent / "crash"), str(HERE.parent / "cluster")]

import nginx  # noqa: E402
from service import digest, mesh, reply_on  # noqa: E402

SIDE = 12  # vertices of a mesh along a side
MESHES = 24  # so many that chance does not give all of them to one server


def directives(text, *names):
    """All directives of these names in a configuration, as words."""
    text = re.sub(r"^\s*#.*$", "", text, flags=re.M)
    return [found.split() for name in names for found in re.findall(rf"^\s*({name}\b[^;]*;)", text, re.M)]


def maps_of(text):
    """The blocks `map` of a configuration, as words."""
    return [block.split() for block in re.findall(r"^\s*(map [^{]*\{.*?^\s*\})$", text, re.M | re.S)]


class Balancer:
    """An nginx with `inside` in its http {…}, listening on a port without TLS."""

    def __init__(self, folder, inside, port):
        self.port = port
        folder.mkdir()
        command = nginx.command(nginx.program(), folder, inside)
        checked = subprocess.run([*command, "-t"], capture_output=True, text=True, check=False)
        self.complaints = checked.stderr if checked.returncode or "[warn]" in checked.stderr else ""
        self._process = subprocess.Popen(command)
        for _ in range(100):
            try:
                self.ask("GET", "/v1/methods")
                return
            except ConnectionRefusedError:
                time.sleep(0.05)
        raise TimeoutError("nginx does not answer")

    def ask(self, method, path, body=None, headers=None):
        """(status, headers in lower case, body) of one request on a connection of its own."""
        return reply_on(http.client.HTTPConnection("127.0.0.1", self.port, timeout=40), method, path, body, headers)

    def stop(self):
        """Ends it."""
        self._process.terminate()
        self._process.wait(30)


def shares_out(expect, balancer, servers, random_):
    """What deploy/ promises of a balancer, with `servers` that have the same meshes. Kills one of them."""
    expect("nginx finds its configuration in order", not balancer.complaints, balancer.complaints)
    meshes = [mesh(SIDE, random_.random()) for _ in range(MESHES)]
    for data in meshes:
        for server in servers:
            server.ask("POST", "/v1/meshes", data)
    questions = [f"/v1/meshes/{digest(data)}/distance?from=v:{random_.randrange(SIDE)}&at=v:{SIDE}" for data in meshes]
    answers = [balancer.ask("GET", question)[0::2] for question in questions]
    expect("meshes are found", {status for status, _ in answers} == {200}, answers)
    again = [balancer.ask("GET", question)[1].get("geo-cache") for question in questions for _ in range(3)]
    expect("what is about one mesh goes to one server", set(again) == {"hit"}, again)
    kept = [sum(server.ask("GET", question)[1].get("geo-cache") == "hit" for question in questions)
            for server in servers]
    expect("and not all of them to the same", sum(kept) == MESHES > max(kept), kept)

    found = []
    for _ in range(6):  # jobs that name no mesh
        status, headers, body = balancer.ask("POST", "/v1/meshes", mesh(SIDE, random_.random()),
                                             {"Prefer": "respond-async"})
        if status != 202:
            found.append((status, body))
            continue
        job = json.loads(body)
        found += [balancer.ask("GET", f"/v1/jobs/{job['id']}")[0] for _ in range(3)]
    expect("a job is found where it runs", found == [200] * 18, found)
    large = mesh(200, random_.random())
    assert len(large) > 1 << 20
    expect("a mesh of more than 1 MB comes through", balancer.ask("POST", "/v1/meshes", large)[0] == 201)

    servers[random_.randrange(len(servers))].kill()
    left = [balancer.ask("GET", question)[0::2] for question in questions]
    expect("with one server killed, the others answer the same", left == answers, left)
