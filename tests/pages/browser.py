#!/usr/bin/env python3
"""Opens pages of the program in a headless Chromium and checks what a reader gets.

Usage: browser.py OUT PAGE...

Every page must load without a console error and without a request to a network, every map and
every curve must show points, and hovering, picking, zooming, keys, downloads and the dark scheme
must work. Screenshots of 390 and 1400 pixels, light and dark, are written to OUT.
"""

import pathlib
import shutil
import sys
import time

from playwright.sync_api import sync_playwright

# Seconds in which a page must be drawn.
LIMIT = 2.0

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


def check(condition, text):
    if not condition:
        raise AssertionError(text)


def open_page(browser, path, width, dark, faults):
    context = browser.new_context(
        viewport={"width": width, "height": 900},
        color_scheme="dark" if dark else "light",
        has_touch=width < 500,
        accept_downloads=True,
    )
    page = context.new_page()
    page.on("console", lambda m: m.type in ("error", "warning") and faults.append(m.text))
    page.on("pageerror", lambda e: faults.append(str(e)))
    page.on("request", lambda r: r.url.startswith("http") and faults.append(f"request {r.url}"))
    began = time.monotonic()
    page.goto(path.resolve().as_uri())
    # Pages of pictures alone have no script.
    if page.locator("#data").count() > 0:
        page.wait_for_selector("html[data-ready=true]", state="attached", timeout=20_000)
    return page, time.monotonic() - began


def check_content(page, empty):
    # Pictures are drawn once they come near the window.
    for section in page.locator("section.map, section.curves").all():
        section.scroll_into_view_if_needed()
        section.locator(".js-plotly-plot").first.wait_for(state="attached")
    page.evaluate("scrollTo(0, 0)")
    plots = page.evaluate(CURVES)
    for plot in plots:
        if plot["none"]:
            check(sum(plot["cells"]) == 0, f"{plot['id']}: says that it has no values")
        elif plot["kind"] == "map":
            check(plot["images"] == 1 or sum(plot["cells"]) == 0, f"{plot['id']}: no picture")
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
    picture.scroll_into_view_if_needed()
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
    check(page.evaluate(ranges, handle) == whole, "the key 0 does not show all")
    page.mouse.move(*at(0.2, 0.2))
    page.mouse.down()
    page.mouse.move(*at(0.4, 0.4), steps=4)
    page.mouse.move(*at(0.7, 0.8), steps=4)
    page.mouse.up()
    page.wait_for_timeout(250)
    check(page.evaluate(ranges, handle) != whole, "dragging does not zoom")
    section.locator("[data-reset]").click()
    page.wait_for_timeout(100)
    check(page.evaluate(ranges, handle) == whole, "the button does not show all")
    for kind, start in (("png", b"\x89PNG"), ("csv", b'"')):
        with page.expect_download() as download:
            section.locator(f"[data-{kind}]").click()
        content = pathlib.Path(download.value.path()).read_bytes()
        check(content.startswith(start), f"{kind} begins with {content[:8]!r}")
    for scale in ("linear", "log"):
        section.locator(f"[data-scale={scale}]").click()
    for along in ("x", "y"):
        section.locator(f"[data-along={along}]").click()
    check(title(), "the curve has no title")


def main():
    out, *pages = map(pathlib.Path, sys.argv[1:])
    out.mkdir(parents=True, exist_ok=True)
    failed = 0
    with sync_playwright() as playwright:
        chromium = shutil.which("chromium") or shutil.which("chromium-browser")
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        for path in pages:
            name = path.parent.name
            empty = "empty" in name
            faults = []
            try:
                page, seconds = open_page(browser, path, 1400, False, faults)
                check(seconds < LIMIT, f"drawn after {seconds:.2f} s")
                check_content(page, empty)
                page.screenshot(path=out / f"{name}-1400-light.png", full_page=True)
                check_map(page)
                page.emulate_media(color_scheme="dark")
                page.wait_for_timeout(300)
                page.screenshot(path=out / f"{name}-1400-dark.png", full_page=True)
                page.context.close()
                page, _ = open_page(browser, path, 390, False, faults)
                check_content(page, empty)
                page.screenshot(path=out / f"{name}-390-light.png", full_page=True)
                page.context.close()
                check(not faults, "; ".join(faults))
                print(f"{name}: drawn in {seconds:.2f} s")
            except Exception as error:  # a page that fails does not hide the others
                failed += 1
                print(f"{name}: FAILED: {error}")
                print("  ", "; ".join(faults)[:2000])
        browser.close()
    sys.exit(1 if failed else 0)


main()
