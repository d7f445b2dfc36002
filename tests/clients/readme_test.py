#!/usr/bin/env python3
"""readme_test.py BUILD: the README's commands against a server with the sample meshes. Those
of the first lines, of the tour with curl and of the section on tokens are run as they stand there,
and have to print what stands there; a token is another each time."""

import os
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "contract"))

from server import Server  # noqa: E402


def section(title):
    """The text of a section of the README."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    return re.search(rf"^## {title}\n(.*?)^## ", readme, re.S | re.M).group(1)


def steps_in(text):
    """The [command, expected output] of its blocks, in order. Blocks without prompts are not run."""
    steps = []
    for block in re.findall(r"^```sh\n(\$.*?)^```$", text, re.S | re.M):
        for line in block.splitlines():
            if line.startswith("$ "):
                steps.append([line[2:], ""])
            elif line.startswith("> "):
                steps[-1][0] += "\n" + line[2:]
            else:
                steps[-1][1] += line + "\n"
    return steps


def run(commands, folder, server, **environment):
    """What each printed, in one shell, so that variables last; and what all wrote on stderr."""
    address = f"127.0.0.1:{server.port}"
    end = "--- end of a step ---"
    script = "".join(f"{command}\necho '{end}'\n" for command in commands)
    shell = subprocess.run(
        ["bash", "-c", script.replace("localhost:8080", address)],
        cwd=folder,
        env={**os.environ, "GEODESICD_URL": f"http://{address}", "NO_PROXY": "*", **environment},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    printed = shell.stdout.replace("\r", "").split(end + "\n")
    return printed + [""] * len(commands), shell.stderr


def as_any_jq(text):
    """Whole numbers as jq 1.6 prints them: jq 1.7 keeps their `.0`."""
    return re.sub(r"(?<=\d)\.0(?!\d)", "", text)


def failures(steps, printed):
    """How many steps printed something else, each of which is told."""
    failed = 0
    for (command, expected), found in zip(steps, printed):
        if as_any_jq(found) != as_any_jq(expected):
            failed += 1
            print(f"FAILED: {command}\n  README: {expected!r}\n  here:   {found!r}")
    return failed


def tour(build, folder):
    """The tour with curl: whether all of it went as written."""
    steps = steps_in(section("At work in ten lines")) + steps_in(section("A minute with curl"))
    with Server(build, "--samples", folder / "build" / "samples") as server:
        printed, complaints = run([command for command, _ in steps], folder, server)
    failed = failures(steps, printed)
    made = {name: (folder / "build" / name).stat().st_size for name in ("field.png", "path.glb")}
    print(f"{len(steps)} commands of the README's tour, {failed} failed; made {made}")
    if complaints:
        print(f"on stderr: {complaints[-1000:]}")
    return len(steps) >= 10 and not failed and all(made.values())


def without_secrets(text):
    """A token and its hash as the README abbreviates or invents them, put out."""
    return re.sub(r"\b[0-9a-f]{64}\b|2d2c…", "HASH", re.sub(r"geo_[\w-]{43}", "TOKEN", text))


def tokens(build, folder):
    """A token is made as written, its line is the file's, and with it the server answers."""
    make, ask = steps_in(section("Configuration"))
    (folder / "build" / "release").symlink_to(build)
    with Server(build) as any_server:
        (made, *_), complaints = run([make[0]], folder, any_server)
    token, line = made.splitlines()
    (folder / "tokens").write_text(line + "\n", encoding="utf-8")
    flags = ("--samples", folder / "build" / "samples", "--tokens", folder / "tokens")
    with Server(build, *flags) as server:
        refused = server.ask("GET", "/v1/meshes").status
        printed, more = run([ask[0]], folder, server, TOKEN=token)
    failed = failures([[make[0], without_secrets(make[1])]], [without_secrets(made)])
    failed += failures([ask], printed)
    print(f"2 commands of the README about tokens, {failed} failed; without a token {refused}")
    if complaints or more:
        print(f"on stderr: {(complaints + more)[-1000:]}")
    return refused == 401 and not failed


def main():
    """Both, with the samples where the README has them."""
    build = pathlib.Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory(prefix="readme_") as folder:
        folder = pathlib.Path(folder)
        subprocess.run(
            [build / "make_samples", folder / "build" / "samples"],
            check=True,
            stdout=subprocess.DEVNULL,
        )
        (folder / "clients").symlink_to(ROOT / "clients")
        went = [tour(build, folder), tokens(build, folder)]
    sys.exit(0 if all(went) else 1)


if __name__ == "__main__":
    main()
