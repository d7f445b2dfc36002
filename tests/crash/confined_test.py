#!/usr/bin/env python3
"""As in its container: run by a user who is not root, on a root file system that is
read-only, with the store the one place to write to. And it writes nowhere else.

    confined_test.py GEODESICD

Needs root; otherwise it is skipped.
"""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

from service import Service, digest, mesh

USER = 10001  # the image's
failures = 0


def expect(what, is_so, *details):
    """Prints a line about one thing that must be so."""
    global failures
    failures += not is_so
    print(("ok: " if is_so else "FAILED: ") + what, *(() if is_so else details))


def can_write(folder):
    """Whether this process may make files in a folder."""
    try:
        with tempfile.NamedTemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def run(program, folder):
    """Inside: everything but the store is read-only."""
    places = {folder / "store": USER, folder / "log": 0}
    for place, owner in places.items():
        place.mkdir()
        subprocess.run(["mount", "-t", "tmpfs", "-o", f"size=64m,uid={owner},mode=700", "none", place],
                       check=True)
    # The build folder may be one that only its owner can enter.
    shutil.copy(program, folder / "geodesicd")
    start = folder / "start"
    start.write_text(f"""#!/bin/sh
exec setpriv --reuid={USER} --regid={USER} --clear-groups --bounding-set=-all --no-new-privs \\
  {folder}/geodesicd "$@"
""")
    start.chmod(0o755)
    for line in reversed(pathlib.Path("/proc/mounts").read_text().splitlines()):
        place = line.split()[1]
        if pathlib.Path(place) not in places and not place.startswith(("/proc", "/sys", "/dev")):
            subprocess.run(["mount", "-o", "remount,bind,ro", place], capture_output=True,
                           check=False)
    expect("the root file system is read-only", not can_write("/"))
    expect("and so is the folder for temporary files", not can_write(folder))

    service = Service(str(start), ["--store", str(folder / "store")], folder / "log" / "log")
    status = pathlib.Path(f"/proc/{service.process.pid}/status").read_text()
    users = next(line for line in status.splitlines() if line.startswith("Uid:")).split()[1:]
    expect("it is not root", users == [str(USER)] * 4, users)
    data = mesh(30, 1)
    expect("it takes a mesh", service.ask("POST", "/v1/meshes", data)[0] == 201)
    base = f"/v1/meshes/{digest(data)}"
    expect("it answers a query", service.ask("GET", f"{base}/path?from=v:0&to=v:899")[0] == 200)
    expect("it is ready", service.ask("GET", "/readyz")[0] == 200)
    expect("it deletes", service.ask("DELETE", base)[0] == 204)
    expect("it ends well", service.stop() == 0)


def main():
    """Runs the story in a mount namespace of its own."""
    program = os.path.abspath(sys.argv[1])
    if len(sys.argv) == 2:
        with tempfile.TemporaryDirectory() as folder:
            os.chmod(folder, 0o755)
            probe = ["unshare", "--mount", "mount", "-t", "tmpfs", "none", folder]
            if subprocess.run(probe, capture_output=True, check=False).returncode != 0:
                print("skipped: no mounts of our own here")
                sys.exit(77)
            again = ["unshare", "--mount", sys.executable, __file__, program, folder]
            sys.exit(subprocess.run(again, check=False).returncode)
    run(program, pathlib.Path(sys.argv[2]))
    sys.exit(failures != 0)


if __name__ == "__main__":
    main()
