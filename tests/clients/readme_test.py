#!/usr/bin/env python3
"""readme_test.py BUILD: the README's tour with curl. Every command in it is run against a
server with the sample meshes, as it stands there, and has to print what stands there."""

import os
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "contract"))

from server import Server  # noqa: E402


def tour(readme):
    """The (command, expected output) of the section, in order."""
    section = re.search(r"^## A minute with curl\n(.*?)^## ", readme, re.S | re.M).group(1)
    steps = []
    for block in re.findall(r"^```sh\n(.*?)^```$", section, re.S | re.M):
        for line in block.splitlines():
            if line.startswith("$ "):
                steps.append([line[2:], ""])
            elif line.startswith("> "):
                steps[-1][0] += "\n" + line[2:]
            else:
                steps[-1][1] += line + "\n"
    return steps


def main():
    """Runs the tour in one shell, so that its variables last."""
    build = pathlib.Path(sys.argv[1]).resolve()
    steps = tour((ROOT / "README.md").read_text(encoding="utf-8"))
    with tempfile.TemporaryDirectory(prefix="readme_") as folder:
        folder = pathlib.Path(folder)
        subprocess.run(
            [build / "make_samples", folder / "build" / "samples"],
            check=True,
            stdout=subprocess.DEVNULL,
        )
        (folder / "clients").symlink_to(ROOT / "clients")
        with Server(build, "--samples", folder / "build" / "samples") as server:
            address = f"127.0.0.1:{server.port}"
            end = "--- end of a step ---"
            script = "".join(f"{command}\necho '{end}'\n" for command, _ in steps)
            run = subprocess.run(
                ["bash", "-c", script.replace("localhost:8080", address)],
                cwd=folder,
                env={**os.environ, "GEODESICD_URL": f"http://{address}", "NO_PROXY": "*"},
                capture_output=True,
                text=True,
                timeout=300,
                check=False,
            )
        printed = run.stdout.replace("\r", "").split(end + "\n")
        made = {name: (folder / name).stat().st_size for name in ("field.png", "path.glb")}
    failed = 0
    for (command, expected), found in zip(steps, printed + [""] * len(steps)):
        if found != expected:
            failed += 1
            print(f"FAILED: {command}\n  README: {expected!r}\n  here:   {found!r}")
    print(f"{len(steps)} commands of the README's tour, {failed} failed; made {made}")
    if run.stderr:
        print(f"on stderr: {run.stderr[-1000:]}")
    sys.exit(1 if failed or len(steps) < 10 or not all(made.values()) else 0)


if __name__ == "__main__":
    main()
