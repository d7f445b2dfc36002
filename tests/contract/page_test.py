#!/usr/bin/env python3
"""page_test.py BUILD: /docs/api/ in a browser. Every operation, parameter, schema and error
code of the contract has to be in the page that its script draws, and nothing may be
loaded from elsewhere or kept back by the page's own policy."""

import html
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

from server import Server


def browser():
    """A Chromium, or nothing."""
    names = ("chromium", "chromium-browser", "google-chrome")
    return next((path for path in map(shutil.which, names) if path), None)


def drawn(program, url):
    """The page's elements once its scripts have run, and what the browser logged."""
    with tempfile.TemporaryDirectory(prefix="page_") as profile:
        command = [
            program,
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--enable-logging=stderr",
        ]
        command += [f"--user-data-dir={profile}", "--virtual-time-budget=20000", "--dump-dom", url]
        run = subprocess.run(command, capture_output=True, timeout=300, check=True)
    return run.stdout.decode("utf-8", "replace"), run.stderr.decode("utf-8", "replace")


def main():
    """Draws the page and looks for what has to be there."""
    program = browser()
    if program is None:
        print("skipped: there is no Chromium to draw /docs/api/ with")
        sys.exit(77)
    build = pathlib.Path(sys.argv[1])
    with Server(build) as server:
        contract = json.loads(server.ask("GET", "/openapi.json").body)
        page, log = drawn(program, f"http://127.0.0.1:{server.port}/docs/api/")
    problems = []
    there = set(map(html.unescape, re.findall(r'data-operation="([^"]*)"', page)))
    operations = {
        f"{method.upper()} {path}"
        for path, item in contract["paths"].items()
        for method in item
        if method in ("get", "head", "post", "put", "patch", "delete")
    }
    if there != operations:
        problems.append(f"operations of the page and the contract differ: {there ^ operations}")
    for name in contract["components"]["schemas"]:
        if f'id="schema-{name}"' not in page:
            problems.append(f"the schema {name} is not on the page")
    for code in contract["components"]["schemas"]["ErrorCode"]["enum"]:
        if f'<code class="name">{code}</code>' not in page:
            problems.append(f"the code {code} is not on the page")
    forms = len(re.findall(r'<details class="try"', page))
    if forms != len(operations):
        problems.append(f"{forms} forms for {len(operations)} operations")
    if not re.search(r"curl -s ['\"]http://127\.0\.0\.1:[0-9]+/v1/meshes/", page):
        problems.append("no curl line names this server")
    for outside in re.findall(r'(?:src|href)="((?:https?:)?//[^"]+)"', page):
        problems.append(f"the page refers to {outside}")
    for line in log.splitlines():
        if "CONSOLE" in line and '"[DOM]' not in line:  # those are hints on forms
            problems.append(f"the browser says: {line[-300:]}")
    for problem in problems:
        print(f"FAILED: {problem}")
    print(f"{len(there)} operations on the page, {len(problems)} problems")
    sys.exit(1 if problems else 0)


if __name__ == "__main__":
    main()
