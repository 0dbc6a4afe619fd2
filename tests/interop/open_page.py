"""Opens a page of volmap in headless Chromium: light, dark, on a phone, in print. Fails on any message of the console,
any request, any overflow, a table that doesn't sort. Screenshots and the PDF are left beside the page.

python open_page.py PAGE.html COLUMN

COLUMN of the first table holds numbers that are not in order; the first column is 1.
"""

import pathlib
import shutil
import sys

from playwright.sync_api import sync_playwright

FORMS = {
    "light": dict(viewport=dict(width=1280, height=900), color_scheme="light"),
    "dark": dict(viewport=dict(width=1280, height=900), color_scheme="dark"),
    "phone": dict(viewport=dict(width=360, height=740), color_scheme="light", device_scale_factor=2, has_touch=True),
    "phone-dark": dict(viewport=dict(width=360, height=740), color_scheme="dark", device_scale_factor=2),
}


def chromium(playwright):
    """Debian's Chromium, or the one that `playwright install chromium` brings."""
    path = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    # A container's root has no sandbox; the page is ours.
    return playwright.chromium.launch(executable_path=path, args=["--no-sandbox", "--disable-dev-shm-usage"])


def luminance(colour):
    """Relative luminance (WCAG 2) of `rgb(r, g, b)`."""
    parts = [float(x) / 255 for x in colour[colour.index("(") + 1 : -1].split(",")[:3]]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def check_contrast(page, form):
    """Every text on the page's ground has a contrast of 4.5 at least."""
    pairs = page.evaluate(
        """() => [...document.querySelectorAll("h1,h2,p,li,a,th,td,dt,dd,figcaption,caption,footer,button,summary,svg text")]
            .map((e) => {
                let ground = e;
                while (ground && getComputedStyle(ground).backgroundColor === "rgba(0, 0, 0, 0)") ground = ground.parentElement;
                const style = getComputedStyle(e);
                return [e.closest("svg") ? style.fill : style.color,
                        ground ? getComputedStyle(ground).backgroundColor : "rgb(255, 255, 255)", e.tagName];
            })"""
    )
    assert pairs
    for text, ground, tag in pairs:
        a, b = sorted([luminance(text), luminance(ground)])
        contrast = (b + 0.05) / (a + 0.05)
        assert contrast >= 4.5, f"{form}: {tag} {text} on {ground}: {contrast:.2f}"


def check_structure(page):
    assert page.locator("h1").count() == 1
    # Thumbnails stand before the name of what they show.
    assert page.locator("img:not(.thumbnail)").evaluate_all("all => all.every(i => i.alt)")
    assert page.locator("img").evaluate_all("all => all.every(i => i.complete && i.naturalWidth > 0)")
    assert page.locator("svg").evaluate_all("all => all.every(s => s.getAttribute('aria-label'))")
    assert page.locator("h2").first.evaluate("h => h.getBoundingClientRect().top") > page.locator(".verdict").evaluate(
        "v => v.getBoundingClientRect().bottom"
    )
    scripts = page.locator("script").count()
    assert scripts == 1, f"{scripts} scripts"


def check_sorting(page, number):
    """A click on the head of a column of numbers sorts by them, up and down; what isn't a number stays last."""
    table = page.locator("table.sortable").first
    column = lambda: table.locator(f"tbody tr td:nth-child({number})").evaluate_all(
        "cells => cells.map(c => c.dataset.v === undefined ? null : Number(c.dataset.v))"
    )
    before = column()
    numbers = sorted(x for x in before if x is not None)
    empty = [x for x in before if x is None]
    assert numbers != before[: len(numbers)], "the rows of the test are not in order"
    head = table.locator("th").nth(number - 1)
    head.locator("button").click()
    assert column() == numbers + empty, column()
    assert head.get_attribute("aria-sort") == "ascending"
    head.locator("button").press("Enter")
    assert column() == numbers[::-1] + empty, column()
    assert head.get_attribute("aria-sort") == "descending"
    table.locator("th").first.locator("button").click()
    names = table.locator("tbody tr td:first-child").all_inner_texts()
    assert names == sorted(names), names


def main(path, column):
    path = pathlib.Path(path).resolve()
    with sync_playwright() as playwright:
        browser = chromium(playwright)
        for form, options in FORMS.items():
            context = browser.new_context(**options)
            page = context.new_page()
            messages, requests = [], []
            page.on("console", lambda message: messages.append(message.text))
            page.on("pageerror", lambda error: messages.append(str(error)))
            page.on("dialog", lambda dialog: (messages.append(dialog.message), dialog.dismiss()))
            page.on("request", lambda request: requests.append(request.url))
            page.goto(path.as_uri())
            wide = page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
            assert wide <= 0, f"{form}: {wide} pixels too wide"
            check_structure(page)
            check_contrast(page, form)
            page.screenshot(path=path.with_name(f"{form}.png"), full_page=True)
            check_sorting(page, column)
            if form == "light":
                page.pdf(path=path.with_name("print.pdf"), format="A4", print_background=False)
                page.emulate_media(media="print")
                assert page.locator("nav").evaluate_all("all => all.every(n => n.offsetParent === null)")
            foreign = [url for url in requests if url != path.as_uri() and not url.startswith("data:")]
            assert not foreign, foreign
            assert not messages, f"{form}: {messages}"
            context.close()
        print(f"{path.name}: {len(FORMS)} forms, printed, {browser.version}")
        browser.close()


main(sys.argv[1], int(sys.argv[2]))
