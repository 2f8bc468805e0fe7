"""Checks the built site: no broken link, and pages of more than 900 words have a table of contents.

    python docs/site/check.py target/site/html [--open [PICTURES]]

With `--open` all pages are opened in Chromium: no console error, no network, no page too wide, no text
cut off by a box around it, and the search works without a server.
"""

import html.parser
import pathlib
import shutil
import sys
import urllib.parse

WIDTHS = (1400, 390)
#: Texts that a box around them cuts off: the box is narrower than they are, and does not scroll.
CUT = """
() => [...document.querySelectorAll("main, main *")].filter((box) => {
    const style = getComputedStyle(box);
    return ["hidden", "clip"].includes(style.overflowX) && box.clientWidth > 1
        && !box.closest(".katex, svg, .js-plotly-plot") && box.scrollWidth > box.clientWidth + 1;
}).map((box) => `${box.tagName} ${box.textContent.trim().slice(0, 60)}`)
"""
LONG = 900


class Page(html.parser.HTMLParser):
    """Links, anchors and words of a page."""

    def __init__(self, path: pathlib.Path) -> None:
        super().__init__()
        self.links: list[str] = []
        self.anchors: set[str] = set()
        self.words = 0
        self.has_contents = False
        self._depth = 0
        # Depth of the formula within, whose symbols are no words.
        self._formula = 0
        self.feed(path.read_text())

    def handle_starttag(self, tag, attrs):
        found = dict(attrs)
        self.links += [found[key] for key in ("href", "src") if found.get(key)]
        self.anchors |= {found[key] for key in ("id", "name") if found.get(key)}
        self.has_contents |= found.get("class") == "contents"
        if self._depth or tag == "main":
            if not self._formula and (found.get("class") or "").startswith("katex"):
                self._formula = self._depth + 1
            self._depth += tag not in ("br", "hr", "img", "input", "meta", "link", "wbr")

    def handle_endtag(self, tag):
        self._depth -= bool(self._depth)
        if self._depth < self._formula:
            self._formula = 0

    def handle_data(self, data):
        self.words += len(data.split()) if self._depth and not self._formula else 0


def broken(root: pathlib.Path, pages: dict[pathlib.Path, Page]) -> list[str]:
    """Links that lead nowhere, and long pages without a table of contents."""
    faults = []
    for path, page in pages.items():
        for link in page.links:
            if urllib.parse.urlsplit(link).scheme:
                continue
            file, _, anchor = urllib.parse.unquote(link).partition("#")
            to = (path.parent / file).resolve() if file else path
            if not to.is_file():
                faults.append(f"{path.relative_to(root)}: {link} leads nowhere")
            elif anchor and to in pages and anchor not in pages[to].anchors:
                faults.append(f"{path.relative_to(root)}: {link} has no such heading")
        if page.words > LONG and not page.has_contents:
            faults.append(f"{path.relative_to(root)}: {page.words} words without a table of contents")
    return faults


def opened(page, path: pathlib.Path, out: pathlib.Path | None) -> list[str]:
    """What is wrong with a page in this window."""
    page.faults.clear()
    page.goto(path.as_uri())
    page.wait_for_load_state("load")
    width = page.viewport_size["width"]
    over = page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
    missing = page.evaluate(
        "[...document.images].filter((i) => i.complete && !i.naturalWidth).map((i) => i.src)"
    )
    cut = page.evaluate(CUT)
    faults = [*page.faults, *([f"{over} pixels too wide"] if over > 0 else [])]
    faults += [f"cut off: {text}" for text in cut]
    faults += [f"no picture {source}" for source in missing]
    if out:
        name = "-".join(path.with_suffix("").parts[-2:])
        page.screenshot(path=out / f"{name}-{width}.png")
    return [f"{path.name} at {width}: {fault}" for fault in faults]


def window(browser, width: int):
    """An empty page that notes what its console says and what it wants of a network."""
    page = browser.new_page(viewport={"width": width, "height": 900})
    page.faults = []
    page.on("console", lambda m: m.type in ("error", "warning") and page.faults.append(m.text))
    page.on("pageerror", lambda error: page.faults.append(str(error)))
    page.on("request", lambda r: r.url.startswith("http") and page.faults.append(f"request of {r.url}"))
    return page


def searched(page, root: pathlib.Path) -> list[str]:
    page.goto((root / "index.html").as_uri())
    page.locator("#mdbook-search-toggle").click()
    page.locator("#mdbook-searchbar").press_sequentially("bicoherence")
    results = page.locator("#mdbook-searchresults li")
    results.first.wait_for(timeout=20_000)
    texts = " ".join(results.all_text_contents()).lower()
    return [] if "bicoherence" in texts else [f"search: bicoherence is not found: {texts[:200]}"]


def all_opened(root: pathlib.Path, files: list[pathlib.Path], out: pathlib.Path | None) -> list[str]:
    from playwright.sync_api import sync_playwright

    faults = []
    with sync_playwright() as playwright:
        chromium = shutil.which("chromium") or shutil.which("chromium-browser")
        options = ["--no-sandbox", "--disable-background-networking"]
        browser = playwright.chromium.launch(executable_path=chromium, args=options)
        for width in WIDTHS:
            page = window(browser, width)
            for path in files:
                faults += opened(page, path, out)
        faults += searched(window(browser, WIDTHS[0]), root)
        browser.close()
    return faults


def main() -> None:
    root = pathlib.Path(sys.argv[1]).resolve()
    is_opened = sys.argv[2:3] == ["--open"]
    out = pathlib.Path(sys.argv[3]) if len(sys.argv) > 3 else None
    if out:
        out.mkdir(parents=True, exist_ok=True)
    files = sorted(root.rglob("*.html"))
    results = [path for path in files if path.parent == root / "gallery"]
    pages = {path: Page(path) for path in files if path not in results and path.name != "toc.html"}
    faults = broken(root, pages)
    said = f"{len(pages)} pages, {sum(len(page.links) for page in pages.values())} links"
    if is_opened:
        faults += all_opened(root, [*pages, *results], out)
        said += f", {len(results)} results, opened at {WIDTHS[0]} and {WIDTHS[1]} pixels"
    print("\n".join(faults) or f"{said}: all is well")
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()
