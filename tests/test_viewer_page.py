"""The viewer in a notebook: a kernel of Jupyter serves its page, and a browser without a screen shows it."""

from __future__ import annotations

import io
import re
import shutil
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from notebook_kernel import Kernel, kernel
from PIL import Image

CELL = """
import membrane_rs
run = membrane_rs.run("hanging-strip", 0.04, frames=9)
shown = run.view()
shown
"""


@pytest.fixture(scope="module")
def notebook(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Kernel]:
    pytest.importorskip("trame")
    with kernel(tmp_path_factory.mktemp("notebook")) as made:
        yield made


@pytest.fixture(scope="module")
def shown(notebook: Kernel) -> list[dict[str, Any]]:
    """What the cell shows, up to the page in place of the picture."""
    return notebook.run(CELL, until="update_display_data")


def html(message: dict[str, Any]) -> str:
    return str(message["data"]["text/html"])


def test_a_cell_shows_a_picture_and_then_the_page(shown: list[dict[str, Any]]) -> None:
    pictures = [message for message in shown if message["kind"] == "display_data"]
    assert len(pictures) == 1
    assert "data:image/png;base64," in html(pictures[0])
    assert shown[-1]["transient"]["display_id"] == pictures[0]["transient"]["display_id"]
    assert re.search(r'<iframe [^>]*src="http://localhost:\d+/', html(shown[-1]))
    assert not [message for message in shown if message["kind"] == "stream"]  # neither warnings nor log


@pytest.fixture(scope="module")
def page(shown: list[dict[str, Any]]) -> Iterator[Any]:
    """The page, drawn."""
    selenium = pytest.importorskip("selenium.webdriver")
    driver, chromium = shutil.which("chromedriver"), shutil.which("chromium") or shutil.which("google-chrome")
    if driver is None or chromium is None:
        pytest.skip("no Chromium with its driver here")
    options = selenium.ChromeOptions()
    options.binary_location = chromium
    for word in ("--headless=new", "--no-sandbox", "--disable-gpu", "--window-size=1100,760"):
        options.add_argument(word)
    browser = selenium.Chrome(options=options, service=selenium.ChromeService(driver))
    try:
        address = re.search(r'src="([^"]+)"', html(shown[-1]))
        assert address is not None
        browser.get(address[1])
        wait(lambda: drawn(browser) and browser.find_elements("css selector", ".v-slider-thumb"))
        yield browser
    finally:
        browser.quit()


def wait(done: Callable[[], object], seconds: float = 60.0) -> None:
    end = time.monotonic() + seconds
    while not done():
        assert time.monotonic() < end, "the page does not come to what is waited for"
        time.sleep(0.2)


def pixels(browser: Any) -> Any:
    """The picture within the page, without its bar."""
    seen = np.asarray(Image.open(io.BytesIO(browser.get_screenshot_as_png())).convert("RGB"), dtype=int)
    return seen[100:-220, 200:-160]


def drawn(browser: Any) -> bool:
    """Whether the picture shows more than a plain ground: the tones of the film."""
    return bool(np.ptp(pixels(browser), axis=2).max() > 80)


def items(browser: Any) -> dict[str, Any]:
    """Those of the menu that is open, by what they say."""
    return {item.text: item for item in browser.find_elements("css selector", ".v-list-item")}


def moved(browser: Any, before: Any) -> float:
    """Share of the pixels that differ."""
    return float((np.abs(pixels(browser) - before).max(axis=2) > 12).mean())


def test_the_slider_moves_the_shape(page: Any) -> None:
    before = pixels(page)
    thumb = page.find_element("css selector", ".v-slider-thumb")
    thumb.send_keys("\ue010")  # End
    wait(lambda: "0.040 s" in page.find_element("css selector", ".words").text)
    wait(lambda: moved(page, before) > 0.002)


def test_the_menu_colours(page: Any) -> None:
    before = pixels(page)
    page.find_element("css selector", ".colour").click()
    wait(lambda: "Film" in items(page))
    assert {"Film", "State of the film", "Strain of springs"} <= set(items(page))
    items(page)["State of the film"].click()
    wait(lambda: moved(page, before) > 0.02)


def test_it_plays_from_the_start_to_the_end(page: Any) -> None:
    words = page.find_element("css selector", ".words")
    page.find_element("css selector", ".play").click()
    wait(lambda: "0.040 s" not in words.text)
    wait(lambda: "0.040 s" in words.text and page.find_elements("css selector", ".mdi-play"))


def test_nothing_is_loaded_from_elsewhere(page: Any) -> None:
    loaded = page.execute_script("return performance.getEntriesByType('resource').map(entry => entry.name)")
    assert loaded
    assert [name for name in loaded if not name.startswith(("http://localhost:", "blob:http://localhost:"))] == []


def test_the_kernel_follows_the_page(notebook: Kernel, page: Any) -> None:
    messages = notebook.run("print(shown.viewer.color, shown.viewer.index)")
    assert [message["text"].split() for message in messages if message["kind"] == "stream"] == [["state", "8"]]


def test_documentation_has_pictures(notebook: Kernel) -> None:
    code = 'import pyvista\npyvista.global_theme.jupyter_backend = "static"\nrun.view()'
    messages = notebook.run(code)
    assert [message["kind"] for message in messages].count("display_data") == 1
    assert notebook.run("1")[-1]["kind"] == "status"
    assert not [message for message in notebook.run("2") if message["kind"] == "update_display_data"]
