"""geodesicd as a service manager starts it: with few system calls, no capability, and a user of its own."""

import json
import os
import pathlib
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "crash"))

from service import digest, mesh  # noqa: E402

USER = 10001  # the image's
PYTHON = "/usr/bin/python3"  # another one may lie in a folder of root's


class Confined:
    """Starts programs with the system calls of `file`, which is of a `kind` that seccomp_filter.py knows."""

    def __init__(self, kind, file, folder):
        self.folder = pathlib.Path(folder)
        self.folder.chmod(0o755)
        # What lies elsewhere may be in folders that only their owner can enter.
        script, file = (shutil.copy(path, self.folder) for path in (HERE / "seccomp_filter.py", file))
        # Only root can give a process another user.
        self.user = USER if os.geteuid() == 0 else None
        as_user = ["setpriv", f"--reuid={USER}", f"--regid={USER}", "--clear-groups", "--bounding-set=-all",
                   "--no-new-privs"] if self.user else []
        self._start = [*as_user, PYTHON, script, kind, file, "--"]

    def program(self, program):
        """A script that starts a program so."""
        words = " ".join(f"'{word}'" for word in [*self._start, shutil.copy(program, self.folder)])
        script = self.folder / "start"
        script.write_text(f'#!/bin/sh\nexec {words} "$@"\n', encoding="utf-8")
        script.chmod(0o755)
        return script

    def place(self, name):
        """An empty folder that such a program may write to."""
        place = self.folder / name
        place.mkdir(mode=0o700)
        if self.user:
            os.chown(place, self.user, self.user)
        return place

    def refuses(self, code):
        """Whether Python code that works here fails there because the system says no."""
        free = subprocess.run([PYTHON, "-c", code], capture_output=True, text=True, check=False)
        bound = subprocess.run([*self._start, PYTHON, "-c", code], capture_output=True, text=True, check=False)
        return free.returncode == 0 and bound.returncode != 0 and "Error: [Errno" in bound.stderr


def filters_of(service):
    """How many filters of system calls hold for a server."""
    status = pathlib.Path(f"/proc/{service.process.pid}/status").read_text(encoding="utf-8")
    return int(status.partition("Seccomp_filters:")[2].split()[0])


def works(service, seed, headers=None):
    """Whether a server takes a mesh, which it decodes in a confined process, and answers a query on it."""
    data = mesh(12, seed)
    status, _, body = service.ask("POST", "/v1/meshes", data, headers=headers)
    if status == 201:
        status, _, body = service.ask("GET", f"/v1/meshes/{digest(data)}/distance?from=v:0&at=v:1", headers=headers)
        # The mesh is a grid whose steps are 1 long, and bumpy.
        if status == 200 and 1 <= json.loads(body)["distances"][0] < 2:
            return True
    print(status, body)
    return False
