#!/usr/bin/env python3
"""pages_test.py: what the pages for those who carry the code on say of the code is there.

In docs/*.md, CONTRIBUTING.md and the pages of the rooms, each path in backticks is a file or folder,
each name that looks like a type or a function occurs in the sources, each flag is one of the
server's, and each test that docs/http_edge.md quotes is one. The defaults in docs/methods.md are the contract's,
docs/errors.md names all flags of a limit or none, and README.md, the server and the engine trace
back over as many faces. docs/rooms.svg is what scripts/draw_rooms draws.
"""

import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGES = ["docs/*.md", "CONTRIBUTING.md", "core/README.md", "*/*/README.md"]
SOURCES = ["core", "proto", "server", "tests", "scripts", "clients", "cmake", "examples"]
PATH = re.compile(r"[\w.-]+(?:/[\w.*-]+)+/?|[\w-]+\.(?:h|cpp|py|sh|yaml|txt)")
NAME = re.compile(r"(?:\w+::)*\w+")
FLAG = re.compile(r"--[a-z][a-z-]+")


def words_of_sources():
    """Every word of every source."""
    words = set()
    for folder in SOURCES:
        for file in (ROOT / folder).rglob("*"):
            if file.suffix in (".h", ".cpp", ".py", ".sh", ".yaml", ".txt", ".cmake") or (
                    file.is_file() and file.parent == ROOT / "scripts"):
                if "node_modules" not in file.parts:
                    words.update(re.findall(r"\w+", file.read_text(encoding="utf-8",
                                                                   errors="replace")))
    return words


def is_there(path, page):
    """Whether a path is one from the top, from the page, or the end of one."""
    path = path.rstrip("/")
    if "*" in path:
        return any(ROOT.glob(path)) or any(page.parent.glob(path))
    if (ROOT / path).exists() or (page.parent / path).exists():
        return True
    return any(any((ROOT / folder).rglob(path)) for folder in SOURCES)


def looks_like_code(name):
    """Types, qualified names, and functions of two words or more."""
    return "::" in name or re.match(r"[A-Z][a-z]+[A-Z]\w*$", name) or re.match(r"[a-z]+_\w+$", name)


def wrong_defaults():
    """The defaults that docs/methods.md tells otherwise than the contract does."""
    contract = (ROOT / "proto/openapi.yaml").read_text(encoding="utf-8")
    schemas = contract[contract.index("\n  schemas:\n"):]
    page = (ROOT / "docs/methods.md").read_text(encoding="utf-8")
    for setting, schema in (("method", "Method"), ("bound", "Bound"), ("refine", "Refine"),
                            ("points_per_edge", "PointsPerEdge"), ("labels", "Flag")):
        default = re.search(rf"\n    {schema}:.*?default: (\w+)", schemas, re.S)[1]
        if not re.search(rf"^\| `{setting}` \| `?{default}`? \|", page, re.M):
            yield f"docs/methods.md has no row that says that `{setting}` is {default} by default."


def missing_flags():
    """The flags of limits that are missing among others of the same error in docs/errors.md."""
    pages = [(ROOT / f"docs/{name}.md").read_text(encoding="utf-8")
             for name in ("limits", "errors")]
    sections = dict(re.findall(r"^### `(\w+)`\n(.*?)(?=^##|\Z)", pages[1], re.S | re.M))
    for row in re.findall(r"^\|.*\|$", pages[0], re.M):
        flags = re.findall(r"`(--[a-z-]+)`", row)[:1]
        for code in re.findall(r"errors\.md#(\w+)", row):
            text = sections[code]
            if "`--" in text and "(limits.md)" not in text and flags and flags[0] not in text:
                yield f"docs/errors.md: `{code}` does not name {flags[0]}, as docs/limits.md does."


def traced_faces():
    """Where `auto` is said to trace back over another number of faces than elsewhere."""
    said = {}
    for file in ("README.md", "proto/wire/methods.cpp", "core/back_traced/wavefront.h"):
        text = re.sub(r"[\s/\"]+", " ", (ROOT / file).read_text(encoding="utf-8"))
        said[file] = re.search(r"way (?:back )?over (\w+(?: \w+)?) faces", text)[1]
    if len(set(said.values())) > 1:
        yield f"over how many faces `auto` traces back: {said}"


def main():
    """Prints what is not there."""
    words = words_of_sources()
    config = "".join((ROOT / "server/config" / file).read_text(encoding="utf-8")
                     for file in ("config.cpp", "options.cpp"))
    flags = set(FLAG.findall(config))
    flags |= {"--" + flag for flag in re.findall(r'"([a-z][a-z-]+)"', config)}
    cases = "".join(file.read_text(encoding="utf-8")
                    for room in ("edge", "proxies") for file in (ROOT / "tests/server" / room).glob("*.cpp"))
    failed = checked = 0
    for page in sorted({file for pattern in PAGES for file in ROOT.glob(pattern)}):
        if "node_modules" in page.parts or page.parts[len(ROOT.parts)] not in (
                "core", "proto", "server", "docs", "CONTRIBUTING.md"):
            continue
        if page.name == "http_edge.md":
            for name in re.findall(r'"([^"\n]+)"', page.read_text(encoding="utf-8")):
                checked += 1
                if f'TEST_CASE("{name}")' not in cases:
                    failed += 1
                    print(f"FAILED: {page.relative_to(ROOT)}: no test is called {name!r}.")
        for quoted in re.findall(r"`([^`\n]+)`", page.read_text(encoding="utf-8")):
            text = quoted.removesuffix("()")
            wrong = ""
            if PATH.fullmatch(text) and not text.startswith(("v1/", "build/")):
                wrong = "" if is_there(text, page) else "is no file of the tree"
            elif FLAG.fullmatch(text) and page.name in ("architecture.md", "http_edge.md"):
                wrong = "" if text in flags else "is no flag of the server"
            elif NAME.fullmatch(text) and looks_like_code(text):
                missing = [part for part in text.split("::") if part not in words]
                wrong = "is in no source" if missing else ""
            else:
                continue
            checked += 1
            if wrong:
                failed += 1
                print(f"FAILED: {page.relative_to(ROOT)}: `{quoted}` {wrong}. Write what it is "
                      "called now.")
    for problem in (*wrong_defaults(), *missing_flags(), *traced_faces()):
        failed += 1
        print(f"FAILED: {problem}")
    stale = [subprocess.run([ROOT / "scripts" / maker, "--check"], check=False).returncode
             for maker in ("draw_rooms", "write_methods")]
    print(f"{checked} names on pages, {failed} of them gone")
    return 1 if failed or any(stale) or checked < 100 else 0


if __name__ == "__main__":
    sys.exit(main())
