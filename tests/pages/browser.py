#!/usr/bin/env python3
"""Opens pages of the program in a headless Chromium and checks what a reader gets.

Usage: browser.py [--record] OUT PAGE...

Every page must load without a console error and without a request to a network, every map and
every curve must show points, and hovering, picking, zooming, keys, downloads, swipes and the dark
scheme must work. What a page consists of is compared with structure.json beside this file, which
--record writes anew. Screenshots of 390 and 1400 pixels, light and dark, are written to OUT.
"""

import json
import pathlib
import shutil
import subprocess
import sys

from playwright.sync_api import sync_playwright

# Browsers at once.
BROWSERS = 3
# A page that takes more processor time than this has hung.
LIMIT = 30.0

CURVES = """() => [...document.querySelectorAll('.js-plotly-plot')].map((plot) => ({
    id: plot.closest('section').id,
    none: plot.closest('section').querySelector('.readout')?.textContent.includes('no values') ?? false,
    kind: plot.classList.contains('picture') ? 'map' : 'curve',
    points: plot.data.filter((t) => t.type !== 'heatmap' && t.hoverinfo !== 'skip')
        .map((t) => t.y.filter((v) => v !== null && Number.isFinite(v)).length),
    cells: plot.data.filter((t) => t.type === 'heatmap')
        .map((t) => t.z.flat().filter((v) => v !== null).length),
    paths: plot.querySelectorAll('.scatterlayer .js-line, .scatterlayer .point').length,
    images: plot.querySelectorAll('.heatmaplayer image').length,
}))"""


# Sections in order; of each picture its axes and how many curves and maps it has.
STRUCTURE = """() => [...document.querySelectorAll('section')].map((section) => ({
    id: section.id,
    heading: section.querySelector('h2')?.textContent ?? '',
    plots: [...section.querySelectorAll('.js-plotly-plot')].map((plot) => ({
        maps: plot.data.filter((t) => t.type === 'heatmap' && t.hoverinfo !== 'skip').length,
        curves: plot.data.filter((t) => t.type !== 'heatmap' && t.hoverinfo !== 'skip').length,
        axes: Object.keys(plot.layout).filter((key) => /^[xy]axis/.test(key)).sort()
            .map((key) => plot.layout[key].title?.text ?? ''),
    })),
    tables: [...section.querySelectorAll('table')].map((table) => table.caption?.textContent ?? ''),
}))"""
NEAR = "(element) => element.scrollIntoView({ block: 'nearest' })"
# Until nothing is left to draw.
IDLE = "new Promise((done) => requestIdleCallback(done, { timeout: 5000 }))"
STORED = pathlib.Path(__file__).with_name("structure.json")


def check(condition, text):
    if not condition:
        raise AssertionError(text)


def open_page(browser, path, width, dark, faults):
    context = browser.new_context(
        viewport={"width": width, "height": 900},
        color_scheme="dark" if dark else "light",
        has_touch=width < 500,
        is_mobile=width < 500,
        accept_downloads=True,
    )
    page = context.new_page()
    page.on("console", lambda m: m.type in ("error", "warning") and faults.append(m.text))
    page.on("pageerror", lambda e: faults.append(str(e)))
    page.on("request", lambda r: r.url.startswith("http") and faults.append(f"request {r.url}"))
    metrics = context.new_cdp_session(page)
    metrics.send("Performance.enable", {"timeDomain": "threadTicks"})
    page.goto(path.resolve().as_uri())
    page.wait_for_selector("html[data-ready=true]", state="attached", timeout=20_000)
    values = {m["name"]: m["value"] for m in metrics.send("Performance.getMetrics")["metrics"]}
    return page, values["TaskDuration"]


def check_content(page, empty):
    # Pictures are drawn once they come near the window.
    for section in page.locator("section.map, section.curves").all():
        section.evaluate(NEAR)
        section.locator(".js-plotly-plot").first.wait_for(state="attached")
    page.evaluate("scrollTo(0, 0)")
    plots = page.evaluate(CURVES)
    for plot in plots:
        if plot["none"]:
            check(sum(plot["cells"]) == 0, f"{plot['id']}: says that it has no values")
        elif plot["kind"] == "map":
            check(plot["images"] >= 1 or sum(plot["cells"]) == 0, f"{plot['id']}: no picture")
            check(sum(plot["cells"]) > 0 or empty, f"{plot['id']}: no cells")
        elif not empty:
            check(max(plot["points"], default=0) > 0, f"{plot['id']}: no points")
            check(plot["paths"] > 0, f"{plot['id']}: nothing is drawn")
    wide = page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
    check(wide <= 0, f"the page is {wide} pixels too wide")


def check_map(page):
    """Hover, pick, keys, zoom, downloads on the first map."""
    section = page.locator("section.map").first
    if section.count() == 0:
        return
    picture = section.locator(".picture")
    picture.evaluate(NEAR)
    area = section.locator(".picture .nsewdrag").first.bounding_box()
    at = lambda u, v: (area["x"] + u * area["width"], area["y"] + v * area["height"])
    readout = section.locator(".readout")
    title = lambda: section.locator(".curve .gtitle").text_content()
    page.mouse.move(*at(0.3, 0.5))
    page.mouse.move(*at(0.31, 0.52))
    page.wait_for_timeout(150)
    check(" = " in readout.text_content(), f"hover says {readout.text_content()!r}")
    picture.focus()
    cells = page.evaluate("(p) => p.data[0].z.length * (p.data[0].z[0]?.length ?? 0)", picture.element_handle())
    if cells > 4:
        page.mouse.click(*at(0.31, 0.52))
        page.wait_for_timeout(150)
        first = readout.text_content()
        picture.focus()
        for key in ("ArrowRight", "ArrowUp"):
            page.keyboard.press(key)
        page.wait_for_timeout(150)
        check(readout.text_content() != first, "arrow keys move no pick")
    ranges = "(p) => JSON.stringify([p.layout.xaxis.range, p.layout.yaxis.range])"
    handle = picture.element_handle()
    whole = page.evaluate(ranges, handle)
    page.keyboard.press("+")
    page.wait_for_timeout(100)
    check(page.evaluate(ranges, handle) != whole, "the key + does not zoom")
    page.keyboard.press("0")
    page.wait_for_timeout(100)
    check(page.evaluate(ranges, handle) == whole, "the key 0 does not reset")
    page.mouse.move(*at(0.2, 0.2))
    page.mouse.down()
    page.mouse.move(*at(0.4, 0.4), steps=4)
    page.mouse.move(*at(0.7, 0.8), steps=4)
    page.mouse.up()
    page.wait_for_timeout(250)
    check(page.evaluate(ranges, handle) != whole, "dragging does not zoom")
    section.locator("[data-reset]").click()
    check_reset(page, section, lambda: page.evaluate(ranges, handle) == whole)
    check_downloads(page, section)
    for scale in ("linear", "log"):
        section.locator(f"[data-scale={scale}]").click()
    for along in ("x", "y"):
        section.locator(f"[data-along={along}]").click()
    check(title(), "the curve has no title")


def check_curves(page):
    """Hovering, zoom and downloads of the first group of curves."""
    section = page.locator("section.curves").first
    if section.count() == 0:
        return
    plot = section.locator(".js-plotly-plot")
    plot.evaluate(NEAR)
    area = section.locator(".nsewdrag").first.bounding_box()
    at = lambda u, v: (area["x"] + u * area["width"], area["y"] + v * area["height"])
    page.mouse.move(*at(0.5, 0.5))
    page.mouse.move(*at(0.52, 0.5))
    section.locator(".hoverlayer .hovertext").first.wait_for(state="attached", timeout=2000)
    ranges = "(p) => JSON.stringify(p.layout.xaxis.range)"
    handle = plot.element_handle()
    whole = page.evaluate(ranges, handle)
    page.mouse.move(*at(0.3, 0.5))
    page.mouse.down()
    page.mouse.move(*at(0.5, 0.5), steps=4)
    page.mouse.move(*at(0.7, 0.5), steps=4)
    page.mouse.up()
    page.wait_for_timeout(250)
    check(page.evaluate(ranges, handle) != whole, "dragging does not zoom curves")
    page.mouse.dblclick(*at(0.5, 0.5))
    check_reset(page, section, lambda: page.evaluate(ranges, handle) == whole)
    check_downloads(page, section)


def check_reset(page, section, is_as_opened):
    """All is shown; a picture that opened on a part of its axes has a button that leads back."""
    home = section.locator("[data-home]")
    page.wait_for_timeout(400)
    check(is_as_opened() == (home.count() == 0), "a reset does not show all")
    if home.count():
        home.click()
        page.wait_for_timeout(400)
        check(is_as_opened(), "the button does not show the display limits")


def check_downloads(page, section):
    for kind, start in (("png", b"\x89PNG"), ("csv", b'"')):
        with page.expect_download() as download:
            section.locator(f"[data-{kind}]").click()
        content = pathlib.Path(download.value.path()).read_bytes()
        check(content.startswith(start), f"{kind} begins with {content[:8]!r}")


def check_dark(page):
    """Light text on a dark page, in the pictures, too."""
    light = """(color) => {
        const [r, g, b] = color.match(/[0-9.]+/g).map(Number);
        return (0.2126 * r + 0.7152 * g + 0.0722 * b) / 255;
    }"""
    paper = page.evaluate(f"({light})(getComputedStyle(document.body).backgroundColor)")
    check(paper < 0.2, f"the dark page has a background of brightness {paper:.2f}")
    texts = page.evaluate(
        f"[...document.querySelectorAll('h1, td, .xtick text, .ytick text')]"
        f".map((e) => ({light})(getComputedStyle(e)[e.closest('svg') ? 'fill' : 'color']))"
    )
    check(min(texts) > 0.6, f"text of brightness {min(texts):.2f} on the dark page")


def check_phone(page):
    """A swipe scrolls the page and zooms nothing, a tap picks, wide tables scroll by themselves."""
    loose = page.evaluate(
        """[...document.querySelectorAll('table')].filter((table) =>
            table.scrollWidth > table.parentElement.clientWidth + 1
            && getComputedStyle(table.parentElement).overflowX !== 'auto').length"""
    )
    check(loose == 0, f"{loose} tables are cut off")
    plot = page.locator(".js-plotly-plot").first
    if plot.count() == 0:
        return
    # Fingers touch what is in the window.
    centered = "(p) => p.querySelector('.nsewdrag').scrollIntoView({ block: 'center' })"
    handle = plot.element_handle()
    session = page.context.new_cdp_session(page)
    ranges = "(p) => JSON.stringify([p.layout.xaxis.range, p.layout.yaxis.range])"
    # A busy machine may lose a gesture.
    for _ in range(6):
        page.evaluate(centered, handle)
        page.evaluate(IDLE)
        before = page.evaluate("scrollY"), page.evaluate(ranges, handle)
        area = page.locator(".nsewdrag").first.bounding_box()
        x, y = area["x"] + area["width"] / 2, area["y"] + area["height"] / 2
        touch = lambda kind, *at: session.send(
            "Input.dispatchTouchEvent", {"type": kind, "touchPoints": [{"x": x, "y": v} for v in at]}
        )
        touch("touchStart", y)
        for step in range(1, 11):
            touch("touchMove", y - 20 * step)
            page.wait_for_timeout(20)
        touch("touchEnd")
        page.wait_for_timeout(1000)
        scrolled = page.evaluate("scrollY") > before[0] + 50
        zoomed = page.evaluate(ranges, handle) != before[1]
        if scrolled and not zoomed:
            break
    check(scrolled, "a swipe over a picture does not scroll the page")
    check(not zoomed, "a swipe over a picture zooms it")
    section = page.locator("section.map").first
    if section.count() == 0:
        return
    picture = section.locator(".picture").element_handle()
    if page.evaluate("(p) => p.data[0].z.flat().length < 5", picture):
        return
    section.locator(".nsewdrag").first.wait_for(state="attached")
    page.evaluate(centered, picture)
    page.evaluate(IDLE)
    area = section.locator(".nsewdrag").first.bounding_box()
    page.touchscreen.tap(area["x"] + 0.6 * area["width"], area["y"] + 0.4 * area["height"])
    page.wait_for_timeout(300)
    check(" = " in section.locator(".readout").text_content(), "a tap picks nothing")


def check_structure(name, page, stored):
    """The stored page of this name, or what differs from it."""
    found = page.evaluate(STRUCTURE)
    if stored is None:
        return found
    wanted = stored.get(name)
    if wanted is None:
        print(f"{name}: its structure is not recorded")
        return found
    for a, b in zip(wanted, found):
        check(a == b, f"structure: {json.dumps(a)} became {json.dumps(b)}")
    check(len(wanted) == len(found), f"structure: {len(found)} sections instead of {len(wanted)}")
    return found


def check_page(browser, path, out, stored):
    """Checks one page; returns the seconds until it was drawn, and its structure."""
    name = path.parent.name
    empty = "empty" in name
    faults = []
    try:
        page, seconds = open_page(browser, path, 1400, False, faults)
        check(seconds < LIMIT, f"drawn after {seconds:.2f} s")
        check_content(page, empty)
        structure = check_structure(name, page, stored)
        page.screenshot(path=out / f"{name}-1400-light.png", full_page=True)
        check_map(page)
        if not empty:
            check_curves(page)
        page.emulate_media(color_scheme="dark")
        page.wait_for_timeout(300)
        check_dark(page)
        page.screenshot(path=out / f"{name}-1400-dark.png", full_page=True)
        page.context.close()
        page, _ = open_page(browser, path, 390, False, faults)
        check_content(page, empty)
        # Before the first picture of a whole page: on a busy machine a page takes no swipe after one.
        check_phone(page)
        page.screenshot(path=out / f"{name}-390-light.png", full_page=True)
        page.emulate_media(color_scheme="dark")
        page.wait_for_timeout(300)
        page.screenshot(path=out / f"{name}-390-dark.png", full_page=True)
        check(not faults, "; ".join(faults)[:2000])
        return seconds, structure
    finally:
        for context in browser.contexts:
            context.close()


def main():
    arguments = sys.argv[1:]
    record, alone = ("--record" in arguments, "--alone" in arguments)
    out, *pages = map(pathlib.Path, (a for a in arguments if not a.startswith("--")))
    # A page mostly waits, so several browsers share a core.
    if len(pages) >= 2 * BROWSERS and not (record or alone):
        command = [sys.executable, __file__, "--alone", out]
        parts = [subprocess.Popen([*command, *pages[i::BROWSERS]]) for i in range(BROWSERS)]
        sys.exit(max(part.wait() for part in parts))
    out.mkdir(parents=True, exist_ok=True)
    structure = json.loads(STORED.read_text())
    stored = None if record else dict(structure)
    failed = 0
    with sync_playwright() as playwright:
        chromium = shutil.which("chromium") or shutil.which("chromium-browser")
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        for path in pages:
            name = path.parent.name
            for attempt in ("first", "second", "last"):
                try:
                    seconds, structure[name] = check_page(browser, path, out, stored)
                    print(f"{name}: drawn in {seconds:.2f} s", flush=True)
                    break
                # A page that fails does not hide the others.
                except Exception as error:
                    print(f"{name}: FAILED, {attempt} attempt: {error}", flush=True)
                    failed += attempt == "last"
            if record:
                text = json.dumps(structure, indent=1, ensure_ascii=False, sort_keys=True)
                STORED.write_text(text + "\n")
        browser.close()
    sys.exit(1 if failed else 0)


main()
