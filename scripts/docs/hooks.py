"""What the site's generator has no setting for: pages that stand outside of docs/, scripts as files
(the server's policy allows none inside a page), small pictures, and the API's page."""

import hashlib
import io
import json
import pathlib
import re
import shutil
import sys

import yaml
from mkdocs.structure.files import File
from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parents[2]
# Pages of the site that are files of the repository's top folder.
OUTSIDE = {"CONTRIBUTING.md": "contributing.md", "SECURITY.md": "security.md",
           "CHANGELOG.md": "changelog.md"}
WIDEST = 720  # pixels of a picture on a page; the whole one is behind it
MOST_BYTES = 20_000  # a picture that has more is made smaller
LINK = re.compile(r"(?<!!)\[([^\]]*)\]\(([^)\s]+)\)")
INLINE_SCRIPT = re.compile(r"<script(?![^>]*\ssrc=)(?![^>]*type=\"?application/json)[^>]*>(.*?)</script>", re.S)


def on_files(files, config):
    """Adds the pages that stand outside of docs/."""
    for source, page in OUTSIDE.items():
        text = (ROOT / source).read_text(encoding="utf-8")
        if source == "CHANGELOG.md":  # long, and what it says stands on other pages, too
            text = "---\nsearch:\n  exclude: true\n---\n" + text
        files.append(File.generated(config, page, content=text))
    return files


def where_now(target, page):
    """A link's target as the site has it, or nothing where the site has no such file."""
    if re.match(r"[a-z]+:|#", target):
        return target
    path, mark, anchor = target.partition("#")
    base = ROOT if page in OUTSIDE.values() else (ROOT / "docs" / page).parent
    file = (base / path).resolve()
    if not file.exists() or not file.is_relative_to(ROOT):
        return target  # the generator says that it is missing
    name = file.relative_to(ROOT).as_posix()
    if name in OUTSIDE:
        found = OUTSIDE[name]
    elif name.startswith("docs/") and not file.is_dir():
        found = name.removeprefix("docs/")
    else:
        return None
    up = "../" * page.count("/")
    return up + found + mark + anchor


def on_page_markdown(markdown, page, **_):
    """Links to files that are no pages become their names."""
    def put(match):
        text, target = match.groups()
        if api := re.fullmatch(r"(?:\.\./)*api/index\.html(#\w+)?", target):
            # It is no page of the generator's: only as HTML does it take the link as it is.
            return f'<a href="{"../" * page.url.count("/")}api/{api[1] or ""}">{text}</a>'
        target_now = where_now(target, page.file.src_uri)
        if target_now is None:
            return text if target.rstrip("/") in text.replace("`", "") else f"{text} (`{target}`)"
        return f"[{text}]({target_now})"

    # As a session at a terminal, prompts and output are left out where the commands are copied.
    markdown = re.sub(r"^```sh\n(?=\$ )", "```console\n", markdown, flags=re.M)
    # Not inside blocks of code.
    parts = re.split(r"(^```.*?^```$|`[^`\n]+`(?!\]))", markdown, flags=re.S | re.M)
    return "".join(part if i % 2 else LINK.sub(put, part) for i, part in enumerate(parts))


def smaller(file):
    """A picture as WebP, at most WIDEST wide: its bytes and size."""
    with Image.open(file) as picture:
        picture = picture.convert("RGBA" if "A" in picture.getbands() else "RGB")
        if picture.width > WIDEST:
            height = round(picture.height * WIDEST / picture.width)
            picture = picture.resize((WIDEST, height), Image.Resampling.LANCZOS)
        out = io.BytesIO()
        picture.save(out, "WEBP", quality=35, method=6)
        return out.getvalue(), picture.size


def is_of_numbers(table):
    """Whether most cells of a table begin with a digit."""
    cells = [re.sub(r"<[^>]*>", "", cell).strip() for cell in re.findall(r"<td[^>]*>(.*?)</td>", table, re.S)]
    return 2 * sum(cell[:1].isdigit() for cell in cells) > len(cells) > 0


def without_numbers_in_search(html):
    """Nobody searches for a figure, and each page loads what the search knows."""

    def mark(match):
        return match.group(0).replace("<table", "<table data-search-exclude", 1) if is_of_numbers(match.group(0)) else match.group(0)

    return re.sub(r"<table.*?</table>", mark, html, flags=re.S)


def on_page_content(html, page, config, **_):
    """Gives each picture its size, and leads from a small copy of a large one to the whole."""
    site = (pathlib.Path(config.site_dir) / page.file.dest_uri).parent

    def put(match):
        before, source, after = match.groups()
        # By now relative to the page's address.
        file = (site / source).resolve()
        original = pathlib.Path(config.docs_dir) / file.relative_to(pathlib.Path(config.site_dir).resolve())
        if original.suffix != ".png":
            return match.group(0)
        if original.stat().st_size <= MOST_BYTES:
            with Image.open(original) as picture:
                width, height = picture.size
            return f'<img{before}src="{source}"{after} width="{width}" height="{height}" loading="lazy">'
        data, (width, height) = smaller(original)
        small = file.with_suffix(".webp")
        small.parent.mkdir(parents=True, exist_ok=True)
        small.write_bytes(data)
        address = source.removesuffix(".png") + ".webp"
        return (f'<a href="{source}"><img{before}src="{address}"{after} width="{width}" '
                f'height="{height}" loading="lazy"></a>')

    return without_numbers_in_search(re.sub(r'<img([^>]*?)src="([^":]+)"([^>]*?) ?/?>', put, html))


def on_post_page(output, page, config):
    """Puts scripts that stand inside a page into files, and names the search."""
    folder = pathlib.Path(config.site_dir) / "assets" / "inline"
    up = "../" * (page.file.dest_uri.count("/"))

    def put(match):
        text = match.group(1)
        if not text.strip():
            return ""
        name = hashlib.sha256(text.encode()).hexdigest()[:16] + ".js"
        folder.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
        return f'<script src="{up}assets/inline/{name}"></script>'

    # The theme's dialogue has no name for those who hear the page.
    output = output.replace('role="dialog"', 'role="dialog" aria-label="Search"')
    return INLINE_SCRIPT.sub(put, output)


def on_post_build(config):
    """Adds the API's page, as it stands without a server, and takes out what nobody asks for."""
    site = pathlib.Path(config.site_dir)
    shutil.copytree(ROOT / "clients/web/docs", site / "api", dirs_exist_ok=True)
    page = site / "api" / "index.html"
    text = page.read_text(encoding="utf-8")
    for name in ("openapi.json", "openapi.yaml"):
        text = text.replace(f'"../../{name}"', f'"{name}"')
    # A page that no server served speaks of the one that `make run` starts.
    text = text.replace('<html lang="en">', '<html lang="en" data-server="http://localhost:8080">')
    text = text.replace('<a class="home" href="../../">', '<a class="home" href="../">')
    page.write_text(text, encoding="utf-8")
    contract = (ROOT / "proto/openapi.yaml").read_text(encoding="utf-8")
    contract = contract.replace("\n  - url: /\n", "\n  - url: http://localhost:8080\n", 1)
    (site / "api" / "openapi.yaml").write_text(contract, encoding="utf-8")
    with open(site / "api" / "openapi.json", "w", encoding="utf-8") as file:
        json.dump(yaml.safe_load(contract), file, default=str)
    # The page of a missing page has absolute addresses, and so would a map of the site.
    for name in ("404.html", "sitemap.xml", "sitemap.xml.gz"):
        (site / name).unlink(missing_ok=True)
    for file in [*site.rglob("*.map"), *(site / "assets/javascripts/lunr").rglob("*.js")]:
        file.unlink()
    if not any(site.glob("assets/inline/*.js")):
        sys.exit("docs: no script was taken out of a page; the theme has changed, look at hooks.py")
