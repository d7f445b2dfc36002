#!/usr/bin/env python3
"""readers.py PORT: the README's three readers, each at work within ten lines, on a machine where
`make run` has just started the server: a web page, Python, and who runs it for others. The blocks of
"At work in ten lines" are run as they stand there, but for the address, in a fresh clone. Needs what
`make run` has installed, and nothing else."""

import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]


def block(language, text):
    """The first block of code in a language."""
    return re.search(rf"^```{language}\n(.*?)^```$", text, re.S | re.M).group(1)


def part(title, text):
    """What stands below a title in bold, up to the next."""
    return re.search(rf"^\*\*{title}\.?\*\*(.*?)(?=^\*\*|\Z)", text, re.S | re.M).group(1)


def run(command, folder):
    """A command's output; its errors are shown, and end the test."""
    print(f"+ {command.strip()}", flush=True)
    done = subprocess.run(["bash", "-euo", "pipefail", "-c", command], cwd=folder, text=True,
                          stdout=subprocess.PIPE, check=False)
    print(done.stdout, end="", flush=True)
    if done.returncode:
        sys.exit(f"readers: this failed with {done.returncode}")
    return done.stdout.strip()


def expect(what, printed, wanted):
    if printed != wanted:
        sys.exit(f"readers: {what}: {printed!r}, and not {wanted!r}")
    print(f"readers: {what} is at work")


def main():
    server = f"http://127.0.0.1:{sys.argv[1]}"
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    text = re.search(r"^## At work in ten lines\n(.*?)^## ", readme, re.S | re.M).group(1)
    text = text.replace("http://localhost:8080", server).replace("localhost:8080", server[7:])
    with tempfile.TemporaryDirectory() as name:
        clone = pathlib.Path(name) / "geodesicd"
        run(f"git clone --quiet {ROOT} {clone}", ROOT)
        (clone / "build").mkdir()
        (clone / "build" / "samples").symlink_to(ROOT / "build" / "samples")

        web = part("A web page", text)
        run(block("sh", web), clone)
        (clone / "page.mjs").write_text(
            block("js", web) + "\nconsole.log(field.values.length, geometry.getAttribute('color').count);\n",
            encoding="utf-8")
        expect("the web page", run("node page.mjs", clone), "6633 6633")

        python = part("Python", text)
        (clone / "page.py").write_text(
            block("python", python) + "\nprint(field.shape, path.points.shape, round(path.length, 3))\n",
            encoding="utf-8")
        # In one shell, so that the environment lasts; pip talks before the page does.
        said = run(block("sh", python) + "python page.py", clone)
        expect("Python", said.splitlines()[-1], "(10000,) (261, 3) 151.835")

        for line in re.findall(r"^\$ (.*)\n(.*)$", part("Running it for others", text), re.M):
            expect("the operator", run(line[0], clone), line[1])


main()
