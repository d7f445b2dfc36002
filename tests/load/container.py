"""A memory cgroup of one's own: what a container of so many bytes is to the kernel."""

import contextlib
import os
import pathlib

ROOT = pathlib.Path("/sys/fs/cgroup")


class Container:
    """Made when it is entered, of cgroup version 2 or 1; needs root."""

    def __init__(self, limit):
        self._limit = limit
        self._is_v2 = (ROOT / "cgroup.controllers").exists()
        self._parent = ROOT if self._is_v2 else ROOT / "memory"
        self.folder = self._parent / f"geodesicd_{os.getpid()}"

    def __enter__(self):
        if self._is_v2:  # what is there already may have it turned on
            with contextlib.suppress(OSError):
                (ROOT / "cgroup.subtree_control").write_text("+memory", encoding="ascii")
        self.folder.mkdir()
        name = "memory.max" if self._is_v2 else "memory.limit_in_bytes"
        (self.folder / name).write_text(str(self._limit), encoding="ascii")
        return self

    def __exit__(self, *_):
        with contextlib.suppress(OSError):
            self.folder.rmdir()

    @property
    def prefix(self):
        """Before a command: it is then in the container, and sees its limit where a container
        sees it."""
        script = f"echo $$ > {self.folder}/cgroup.procs && mount --bind {self.folder} {self._parent}"
        return ["unshare", "--mount", "sh", "-c", script + ' && exec "$@"', "sh"]

    def kills(self):
        """How many processes the kernel has killed for want of memory."""
        name = "memory.events" if self._is_v2 else "memory.oom_control"
        lines = (self.folder / name).read_text(encoding="ascii").splitlines()
        return sum(int(line.split()[1]) for line in lines if line.startswith("oom_kill "))
