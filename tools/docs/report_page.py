"""Make the picture and the comparison of docs/report.md: python tools/docs/report_page.py. Needs Chromium and its
driver, and plotly, which nothing else needs; with --picture neither plotly nor a machine that does nothing else.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

import membrane_rs
import numpy as np
from marked import DOCS, ROOT, MarkedPart, copy_small
from membrane_rs._markdown import table
from membrane_rs.report import write_report

sys.path.append(str(ROOT / "tests"))

from browser import Browser

COMPARISON = MarkedPart(DOCS / "report.md", "report-libraries")
UNTIL, FRAMES, SHOWN, FIELD = 0.4, 30, 10, "speed"
PICTURE = (1280, 1000)
"""Width and height of the window [pixels]."""
CHOOSE = (
    "const s = document.getElementById(arguments[0]);s.value = arguments[1]; s.dispatchEvent(new Event(arguments[2]))"
)
STATE = "return document.getElementById('view-view').dataset[arguments[0]]"
ANIMATE = """
const [frame, done] = arguments, start = performance.now();
Plotly.animate(document.querySelector('.plotly-graph-div'), [frame],
  {frame: {duration: 0, redraw: true}, transition: {duration: 0}, mode: 'immediate'})
  .then(() => requestAnimationFrame(() => done(performance.now() - start)));
"""


def is_drawn(browser: Browser, frame: int) -> bool:
    """Whether a frame is drawn."""
    return float(browser.run(STATE, "place")) == frame


def by_k3d(run: membrane_rs.Run, folder: Path, browser: Browser) -> tuple[int, float, float]:
    """Bytes of the page; seconds to the first picture, and of a frame. The page is pictured in passing."""
    page = write_report(run, folder / "k3d.html")
    began = time.perf_counter()
    browser.open(page)
    browser.wait(lambda: browser.run(STATE, "state") == "ready", "it drew")
    first = time.perf_counter() - began
    frames = range(SHOWN)
    began = time.perf_counter()
    for frame in frames:
        browser.run(CHOOSE, "view-time", frame, "input")
        browser.wait(partial(is_drawn, browser, frame), "a frame was drawn")
    each = (time.perf_counter() - began) / len(frames)
    browser.run(CHOOSE, "view-field", FIELD, "change")
    browser.wait(lambda: browser.run(STATE, "state") == "ready", "it was coloured")
    browser.driver.save_screenshot(str(folder / "page.png"))
    copy_small(folder / "page.png", "report.png", colours=None)
    return page.stat().st_size, first, each


def by_plotly(run: membrane_rs.Run, folder: Path, browser: Browser) -> tuple[int, float, float]:
    """The same of plotly's `Mesh3d` with frames, and one field."""
    go: Any = import_module("plotly.graph_objects")

    def mesh(frame: Any) -> Any:
        x, y, z = frame.positions.T.astype(np.float32)
        i, j, k = frame.triangles.T.astype(np.int32)
        values = frame.on_triangles["stress_1"].astype(np.float32)
        return go.Mesh3d(x=x, y=y, z=z, i=i, j=j, k=k, intensity=values, intensitymode="cell", flatshading=True)

    frames = [go.Frame(data=[mesh(frame)], name=str(k)) for k, frame in enumerate(run.frames)]
    page = folder / "plotly.html"
    go.Figure(data=[mesh(run.frames[0])], frames=frames).write_html(page, include_plotlyjs=True, auto_play=False)
    began = time.perf_counter()
    browser.open(page)
    browser.wait(lambda: browser.run("return !!document.querySelector('.plotly-graph-div canvas')"), "it drew")
    first = time.perf_counter() - began
    each = [browser.driver.execute_async_script(ANIMATE, str(frame)) for frame in range(1, 5)]
    return page.stat().st_size, first, float(np.mean(each)) * 1e-3


def main() -> None:
    """Write both."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--picture", action="store_true", help="the picture alone")
    only_picture = parser.parse_args().picture
    run = membrane_rs.run("okuizumi-model-1", until=UNTIL, frames=FRAMES)
    browser = Browser(*PICTURE)
    with tempfile.TemporaryDirectory() as folder:
        found = {"k3d, all fields, and the rest of the page": by_k3d(run, Path(folder), browser)}
        if not only_picture:
            found["plotly, one field, nothing else"] = by_plotly(run, Path(folder), browser)
    browser.close()
    if only_picture:
        return
    rows = [
        [name, f"{1e-6 * size:.1f} MB", f"{first:.1f} s", f"{each:.2f} s"]
        for name, (size, first, each) in found.items()
    ]
    COMPARISON.write(table(["page", "size", "first picture", "a frame"], rows, words=(0,)))


if __name__ == "__main__":
    main()
