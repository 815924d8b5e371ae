"""Checks of a built site: every link inside has its target, and nothing comes from elsewhere."""

from __future__ import annotations

from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

# Tags that load something, and the attribute that names it. A plain <a> only leads somewhere.
LOADS = {
    "img": "src",
    "script": "src",
    "iframe": "src",
    "source": "src",
    "video": "src",
    "audio": "src",
    "object": "data",
    "embed": "src",
}
# Kinds of <link> that a browser fetches.
FETCHED = {"stylesheet", "icon", "preload", "modulepreload", "preconnect", "prefetch", "manifest"}
RUSTDOC = "rust"  # rustdoc checks its own links


class Page(HTMLParser):
    """The links, the loaded files and the anchors of one page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.loaded: list[str] = []
        self.anchors: set[str] = {"", "top"}
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in attrs}
        self.anchors.update(given[name] for name in ("id", "name") if name in given)
        if tag == "a" and "href" in given:
            self.links.append(given["href"])
        elif tag == "link" and FETCHED & set(given.get("rel", "").split()):
            self.loaded.append(given.get("href", ""))
        elif given.get(LOADS.get(tag, "")):
            self.loaded.append(given[LOADS[tag]])


@cache
def read(path: Path) -> Page:
    return Page(path.read_text(encoding="utf-8"))


def is_elsewhere(address: str) -> bool:
    """Whether an address names another machine."""
    parts = urlsplit(address)
    return parts.scheme in ("http", "https") or (not parts.scheme and bool(parts.netloc))


def broken(page: Path, address: str) -> str | None:
    """Why an address within the site leads nowhere, or None."""
    parts = urlsplit(address)
    if parts.scheme or parts.netloc:
        return None
    target = page if not parts.path else (page.parent / unquote(parts.path)).resolve()
    if target.is_dir():
        target /= "index.html"
    if not target.is_file():
        return "there is no such file"
    if parts.fragment and target.suffix == ".html" and parts.fragment not in read(target).anchors:
        return "the page has no such anchor"
    return None


def problems(site: Path) -> list[str]:
    """One line for each dead link and each file that is loaded from another machine."""
    site = site.resolve()
    found = []
    for path in sorted(site.rglob("*.html")):
        if path.relative_to(site).parts[0] == RUSTDOC:
            continue
        page, name = read(path), path.relative_to(site)
        for address in page.loaded:
            if is_elsewhere(address):
                found.append(f"{name}: loads {address}")
        for address in [*page.links, *page.loaded]:
            if reason := broken(path, address):
                found.append(f"{name}: {address}: {reason}")
    for path in sorted(site.rglob("*.css")):
        text = path.read_text(encoding="utf-8")
        if "url(http" in text or "url(//" in text or "@import" in text:
            found.append(f"{path.relative_to(site)}: loads a file from another machine")
    return sorted(set(found))
