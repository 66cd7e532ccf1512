"""Looks at a page in a real browser and says everything that is wrong with it.

`faults` returns one line for each problem, none for a good page. It is used on the reports and on
pages that are broken on purpose, which it must reject.
"""

from __future__ import annotations

import io
import os
import re
import shutil
from pathlib import Path

import numpy as np
from matplotlib.image import imread

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
WIDTHS = (1280, 390)
A4_WIDTH = 794  # pixels
ALLOWED = ("file:", "data:")

SCRIPT = (Path(__file__).parent / "pagecheck.js").read_text(encoding="utf-8")


def executable() -> str | None:
    """Return the system's browser: CHROMIUM, or the first that is found by name."""
    named = os.environ.get("CHROMIUM")
    return named or next((found for found in map(shutil.which, NAMES) if found), None)


class Watched:
    """A page with a record of all that it logs, throws and asks for."""

    def __init__(self, browser, path):
        self.context = browser.new_context(viewport={"width": WIDTHS[0], "height": 900})
        self.page = self.context.new_page()
        self.logged = []
        self.page.on("console", lambda m: self.logged.append(f"console {m.type}: {m.text[:200]}"))
        self.page.on("pageerror", lambda e: self.logged.append(f"page error: {e}"))
        self.page.on("request", lambda r: self._asked(r.url))
        self.page.goto(path.resolve().as_uri(), wait_until="load")

    def _asked(self, url):
        if not url.startswith(ALLOWED):
            self.logged.append(f"external request: {url[:80]}")

    def look(self, function):
        """Return what a function of pagecheck.js finds; the page's own policy cannot stop it."""
        return self.page.evaluate(f"() => {{ {SCRIPT}\nreturn {function}(); }}")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.context.close()


def faults(browser, path, folder=None, schemes=("light", "dark"), *, shot=True):
    """Return what is wrong with a page; screenshots go into `folder` where one is given.

    Without a `shot` nobody looks whether it is blank.
    """
    found = []
    with Watched(browser, path) as watched:
        watched.look("unfold")
        found += watched.look("structure")
        for scheme in schemes:
            watched.page.emulate_media(color_scheme=scheme)
            here = watched.look("contrast")
            for width in WIDTHS:
                watched.page.set_viewport_size({"width": width, "height": 900})
                here += watched.look("overflow")
                if shot and is_blank(watched.page.screenshot()):
                    here.append(f"the screenshot is blank at {width} px")
                if folder is not None:
                    watched.page.screenshot(path=folder / f"{scheme}-{width}.png", full_page=True)
            found += [f"{scheme}: {fault}" for fault in here]
        # A person whose screen is dark prints on white paper all the same, and all that is folded.
        watched.look("fold")
        watched.page.set_viewport_size({"width": A4_WIDTH, "height": 900})
        watched.page.emulate_media(media="print", color_scheme="dark")
        for function in ("paper", "overflow", "contrast"):
            found += [f"print: {fault}" for fault in watched.look(function)]
        return found + watched.logged


def printed(browser, path):
    """Print a page; return the number of sheets, and their sizes in points."""
    with Watched(browser, path) as watched:
        paper = watched.page.pdf(prefer_css_page_size=True, print_background=True)
    sheets = len(re.findall(rb"/Type\s*/Page\b(?!s)", paper))
    boxes = re.findall(rb"/MediaBox\s*\[\s*0\s+0\s+([\d.]+)\s+([\d.]+)", paper)
    return sheets, {(round(float(w)), round(float(h))) for w, h in boxes}


def is_blank(shot):
    """Say whether nearly all of a screenshot has one colour."""
    pixels = imread(io.BytesIO(shot), format="png")[..., :3]
    flat = pixels.reshape(-1, 3)
    return bool(np.mean(np.any(np.abs(flat - flat[0]) > 0.05, axis=1)) < 0.005)
