#!/usr/bin/env python3
"""run_pages.py BUILD PYTHON [--pictures]: what the documentation's pages tell to do, done.

Against a server with the sample meshes, page by page: commands in blocks of `sh` that begin with `$`
have to print what stands there. Blocks of `python` run with PYTHON, which has the client, and each
line that ends with `# = VALUE` has to have that value; a warning, such as of a point far from the
surface, is a failure there. In other blocks of `sh`, bash has to find the
words in order, and geodesicd has to take its flags. Each picture of a tutorial is made by a command
of its page; --pictures puts those into docs/ anew.
"""

import os
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests" / "contract"), str(ROOT / "tests" / "clients")]

from readme_test import failures, run, steps_in  # noqa: E402
from server import Server  # noqa: E402

# Runs a page's Python, statement by statement, and compares values with the comments.
RUNNER = r"""
import ast, re, sys
lines = open(sys.argv[1], encoding="utf-8").read().splitlines()
names, checked = {"__name__": "page"}, 0
for node in ast.parse("\n".join(lines)).body:
    said = re.search(r"#\s*= (.*)$", lines[node.end_lineno - 1])
    if isinstance(node, ast.Expr) and said:
        value = eval(compile(ast.Expression(node.value), "page", "eval"), names)
        expected = eval(said.group(1), names)
        checked += 1
        if value != expected:
            sys.exit(f"{lines[node.end_lineno - 1]}: here it is {value!r}")
    else:
        exec(compile(ast.Module([node], []), "page", "exec"), names)
print(checked)
"""


def blocks(text, language):
    """The blocks of code in a language."""
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.S | re.M)


def dry_problems(text, build, folder):
    """What is wrong with the commands that are not run."""
    keys = {**os.environ, "AWS_ACCESS_KEY_ID": "id", "AWS_SECRET_ACCESS_KEY": "secret"}  # pages show none
    for block in blocks(text, "sh"):
        if block.startswith("$"):
            continue
        checked = subprocess.run(["bash", "-n"], input=block, text=True, capture_output=True, check=False)
        if checked.returncode:
            yield f"bash: {checked.stderr.strip()}"
        for line in block.replace("\\\n", " ").splitlines():
            flags = re.match(r"(?:build/release/)?geodesicd (.*)", line)
            if flags:
                said = subprocess.run(["bash", "-c", f"'{build}/geodesicd' --check-config {flags[1]}"], cwd=folder,
                                      env=keys, text=True, capture_output=True, check=False)
                if said.returncode:
                    yield f"{line}: {said.stdout}{said.stderr}"


def python_problems(text, python, server, folder):
    """How a page's Python fails, and how many values it compared."""
    code = "\n".join(blocks(text, "python"))
    if not code:
        return None, 0
    (folder / "page.py").write_text(code.replace("localhost:8080", f"127.0.0.1:{server.port}"), encoding="utf-8")
    (folder / "runner.py").write_text(RUNNER, encoding="utf-8")
    ran = subprocess.run([python, "-W", "error::UserWarning", "runner.py", "page.py"], cwd=folder, text=True, capture_output=True,
                         timeout=300, check=False)
    return (ran.stderr[-1500:] if ran.returncode else None), int(ran.stdout or 0)


def size_of(png):
    """The width and height of a PNG."""
    data = png.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n", png
    return struct.unpack(">II", data[16:24])


def main():
    """All pages, each with a fresh server and folder."""
    build, python = pathlib.Path(sys.argv[1]).resolve(), os.path.abspath(sys.argv[2])
    renew = "--pictures" in sys.argv
    failed = commands = values = pictures = 0
    for page in sorted((ROOT / "docs").rglob("*.md")):
        text = page.read_text(encoding="utf-8")
        steps = steps_in(text)
        with tempfile.TemporaryDirectory(prefix="pages_") as name:
            folder = pathlib.Path(name)
            # What `make run` has built beside the program.
            (folder / "clients/web/viewer/dist").mkdir(parents=True)
            (folder / "clients/web/viewer/dist/index.html").touch()
            (folder / "build").mkdir()
            (folder / "build" / "docs").symlink_to(ROOT / "build" / "docs")
            for problem in dry_problems(text, build, folder):
                failed += 1
                print(f"FAILED: {page.name}: {problem}")
            if not steps and not blocks(text, "python"):
                continue
            (folder / "build" / "release").symlink_to(build)
            subprocess.run([build / "make_samples", folder / "build" / "samples"], check=True,
                           stdout=subprocess.DEVNULL)
            with Server(build, "--samples", folder / "build" / "samples") as server:
                printed, complaints = run([command for command, _ in steps], folder, server)
                # The last line of a reply may have no end.
                wrong = failures(steps, [out.rstrip("\n") + "\n" if out else "" for out in printed])
                if wrong:
                    print(f"  in {page.relative_to(ROOT)}; on stderr: {complaints[-600:]}")
                failed += wrong
                commands += len(steps)
                problem, count = python_problems(text, python, server, folder)
                values += count
                if problem:
                    failed += 1
                    print(f"FAILED: {page.relative_to(ROOT)}: {problem}")
            for picture in re.findall(r"!\[[^\]]*\]\((\w+\.png)\)", text):
                if page.parent.name != "tutorials":
                    continue
                pictures += 1
                if renew:
                    shutil.copy(folder / picture, page.parent / picture)
                made, kept = folder / picture, page.parent / picture
                if not made.exists() or size_of(made) != size_of(kept):
                    failed += 1
                    print(f"FAILED: {page.name}: {picture} is not what its command makes")
    print(f"{commands} commands, {values} values of Python, {pictures} pictures, {failed} failed")
    return 1 if failed or commands < 30 or values < 12 or pictures < 4 else 0


if __name__ == "__main__":
    sys.exit(main())
