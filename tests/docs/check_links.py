#!/usr/bin/env python3
"""check_links.py SITE CONTRACT: every link of the built site leads somewhere.

Files and anchors of all pages are looked up in the folder SITE; those of the API's page, which a
script draws, in the operations and schemas of CONTRACT (openapi.yaml). No page may load anything
from another host, hold a script or style that the policy forbids, or lead to a path from the root,
which would not hold below a proxy's prefix. Each error code has its heading, and no other has one.
"""

import html.parser
import pathlib
import re
import sys
import urllib.parse

ROOT = pathlib.Path(__file__).resolve().parents[2]
CODES = {
    "core/base/error.h": r'inline constexpr ErrorCode ErrorCode::\w+\{"(\w+)"\}',
    "proto/wire/input_codes.h": r'ErrorCode \w+\{"(\w+)"\}',
    "server/base/service_codes.h": r'ErrorCode \w+\{"(\w+)"\}',
}
METHODS = ("get", "head", "post", "put", "patch", "delete")
LOADS = {("img", "src"), ("script", "src"), ("link", "href"), ("iframe", "src"), ("source", "src")}


class Page(html.parser.HTMLParser):
    """The ids of a page, what it links to and loads, and what its policy would refuse."""

    def __init__(self, text):
        super().__init__()
        self.ids, self.links, self.loads, self.refused, self.headings = set(), [], [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        if given.get("id"):
            self.ids.add(given["id"])
            if re.fullmatch("h[1-6]", tag):
                self.headings.append((tag, given["id"]))
        for name, value in attrs:
            if name in ("href", "src") and value:
                is_load = (tag, name) in LOADS and given.get("rel") not in ("canonical", "prev", "next")
                (self.loads if is_load else self.links).append(value)
            if name == "style" or name.startswith("on"):
                self.refused.append(f"{tag} {name}={value}")
        if tag == "style" or (tag == "script" and not given.get("src")
                              and given.get("type") != "application/json"):
            self.refused.append(f"<{tag}> within the page")


def ids_of_contract(file):
    """The anchors that the API's page draws."""
    text = file.read_text(encoding="utf-8")
    codes = re.search(r"^    ErrorCode:\n.*?enum:\n(.*?)^      examples", text, re.S | re.M).group(1)
    schemas = text[text.index("\n  schemas:\n"):]
    return ({"about", "errors", "schemas"}
            | set(re.findall(r"operationId: (\w+)", text))
            | set(re.findall(r"- (\w+)", codes))
            | {f"schema-{name}" for name in re.findall(r"^    (\w+):", schemas, re.M)})


def error_codes():
    """All codes that the sources have."""
    return {code for file, pattern in CODES.items()
            for code in re.findall(pattern, (ROOT / file).read_text(encoding="utf-8"))}


def problems_of(name, page, site, pages):
    """What is wrong with a page's references."""
    for refused in page.refused:
        yield f"{name}: the policy forbids {refused}"
    for target in [*page.links, *page.loads]:
        parts = urllib.parse.urlsplit(target)
        if parts.scheme == "data":
            continue
        if parts.scheme or parts.netloc:
            if target in page.loads:
                yield f"{name}: loads {target} from another host"
            continue
        if parts.path.startswith("/"):
            yield f"{name}: {target} begins at the root and would not hold below a prefix"
            continue
        file = (site / name).parent / urllib.parse.unquote(parts.path) if parts.path else site / name
        file = file.resolve()
        if target.endswith("/") or file.is_dir():
            file = file / "index.html"
        if name == "api/index.html" and not file.is_relative_to(site):
            continue  # the server's own page and paths
        if not file.is_file() or not file.is_relative_to(site):
            yield f"{name}: {target} leads nowhere"
            continue
        other = file.relative_to(site).as_posix()
        if parts.fragment and other in pages and parts.fragment not in pages[other].ids:
            yield f"{name}: {other} has no #{parts.fragment}"


def main():
    """Prints what is wrong."""
    site, contract = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
    pages = {file.relative_to(site).as_posix(): Page(file.read_text(encoding="utf-8"))
             for file in sorted(site.rglob("*.html"))}
    pages["api/index.html"].ids |= ids_of_contract(contract)
    found = [problem for name, page in pages.items() for problem in problems_of(name, page, site, pages)]
    headings = {heading for tag, heading in pages["errors/index.html"].headings if tag == "h3"}
    found += [f"errors.md has no heading for {code}" for code in sorted(error_codes() - headings)]
    found += [f"errors.md has a heading for {code}, which is no code" for code in sorted(headings - error_codes())]
    links = sum(len(page.links) + len(page.loads) for page in pages.values())
    for problem in found:
        print(f"FAILED: {problem}")
    print(f"{len(pages)} pages, {links} links, {len(error_codes())} error codes, {len(found)} problems")
    return 1 if found or len(pages) < 20 or links < 500 or len(error_codes()) < 30 else 0


if __name__ == "__main__":
    sys.exit(main())
