"""Look at a site as it was built: every internal link and anchor leads somewhere, and no page asks another host.

python docs/_ext/site_check.py build/docs/html
"""

from __future__ import annotations

import re
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

REQUESTS = {"script": "src", "img": "src", "iframe": "src", "source": "src", "object": "data", "link": "href"}
"""what a browser fetches by itself, by tag."""
NO_REQUESTS = {"canonical", "license", "search", "index", "next", "prev", "author", "help"}
"""kinds of <link> that it does not fetch."""


class Page(HTMLParser):
    """The links, anchors and requests of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.anchors: set[str] = {"", "top"}
        self.requests: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        """Note what the tag refers to."""
        found = {key: value or "" for key, value in attributes}
        self.anchors |= {found[key] for key in ("id", "name") if key in found}
        if tag == "a" and "href" in found:
            self.links.append(found["href"])
        kind = set(found.get("rel", "").split())
        if tag in REQUESTS and REQUESTS[tag] in found and not (tag == "link" and kind & NO_REQUESTS):
            self.requests.append(found[REQUESTS[tag]])


def problems(site: Path) -> list[str]:
    """What is wrong with a built site, a line each."""
    pages = {path: Page(path.read_text(encoding="utf-8")) for path in sorted(site.rglob("*.html"))}
    found = []
    for path, page in pages.items():
        where = path.relative_to(site)
        found += [f"{where}: asks another host: {url}" for url in page.requests if urlsplit(url).netloc]
        for link in page.links + [url for url in page.requests if not url.startswith("data:")]:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if not target.exists():
                found.append(f"{where}: leads nowhere: {link}")
            elif target in pages and unquote(parts.fragment) not in pages[target].anchors:
                found.append(f"{where}: no such anchor: {link}")
    for path in sorted(site.rglob("*.css")):
        urls = re.findall(r"(?:url\(|@import )['\"]?((?:https?:)?//[^'\")]+)", path.read_text(encoding="utf-8"))
        found += [f"{path.relative_to(site)}: asks another host: {url}" for url in urls]
    return found


def main() -> int:
    """Print what is wrong; the exit code is 1 if anything is."""
    site = Path(sys.argv[1]).resolve()
    found = problems(site)
    print("\n".join(found) or f"{len(list(site.rglob('*.html')))} pages: all links lead somewhere, no external request")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
