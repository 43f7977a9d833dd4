"""The viewer in a notebook: a kernel of Jupyter serves its page, and a browser without a screen shows it."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from browser import Browser, opened
from notebook_kernel import Kernel, kernel

CELL = """
import os
os.environ.update(TRAME_IFRAME_BUILDER="jupyter-extension", TRAME_BACKEND="jupyter")  # as in JupyterLab
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
def page(shown: list[dict[str, Any]]) -> Iterator[Browser]:
    """The page, drawn."""
    address = re.search(r'src="([^"]+)"', html(shown[-1]))
    assert address is not None
    with opened(width=1100, height=760) as browser:
        browser.let_in()
        browser.open(address[1])
        browser.wait(lambda: drawn(browser) and browser.find_all(".v-slider-thumb"), "the page is drawn")
        yield browser


def pixels(browser: Browser) -> Any:
    """The picture within the page, without its bar."""
    return browser.pixels().astype(int)[100:-220, 200:-160]


def drawn(browser: Browser) -> bool:
    """Whether the picture shows more than a plain ground: the tones of the film."""
    return bool(np.ptp(pixels(browser), axis=2).max() > 80)


def items(browser: Browser) -> dict[str, Any]:
    """Those of the menu that is open, by what they say."""
    return {item.text: item for item in browser.find_all(".v-list-item")}


def moved(browser: Browser, before: Any) -> float:
    """Share of the pixels that differ."""
    return float((np.abs(pixels(browser) - before).max(axis=2) > 12).mean())


def go_to(browser: Browser, key: str, words: str) -> None:
    """Move the slider by a key."""

    def is_there() -> bool:
        browser.find(".v-slider-thumb").send_keys(key)  # once more, where the page has not taken it yet
        return words in browser.find(".words").text

    browser.wait(is_there, f"{words} is shown")


HOME, END = ("\ue011", "0.000 s"), ("\ue010", "0.040 s")


def choose(browser: Browser, color: str) -> None:
    """Choose what the film is coloured by."""
    browser.click(lambda: browser.find(".colour"), "the list of colours")
    browser.wait(lambda: color in items(browser), "the menu is open")
    browser.click(lambda: items(browser)[color], color)
    browser.wait(lambda: color not in items(browser), "the menu is closed")


def test_the_slider_moves_the_shape(page: Browser) -> None:
    go_to(page, *HOME)
    before = pixels(page)
    go_to(page, *END)
    page.wait(lambda: moved(page, before) > 0.002, "the shape has moved")


def test_the_menu_colours(page: Browser) -> None:
    choose(page, "Film")
    before = pixels(page)
    page.click(lambda: page.find(".colour"), "the list of colours")
    page.wait(lambda: {"Film", "State of the film", "Strain of springs"} <= set(items(page)), "the menu is open")
    page.click(lambda: items(page)["State of the film"], "a colour")
    page.wait(lambda: moved(page, before) > 0.02, "the film is coloured")


def test_it_plays_from_the_start_to_the_end(page: Browser) -> None:
    go_to(page, *END)
    # The page itself notes what it shows: all may be over before it is asked.
    page.run(
        "window.seen = [];"
        "new MutationObserver(() => window.seen.push(document.querySelector('.words').textContent))"
        ".observe(document.body, {subtree: true, childList: true, characterData: true})"
    )
    page.click(lambda: page.find(".play"), "the button")
    page.wait(lambda: "0.000 s" in "".join(page.run("return window.seen")), "it plays")
    page.wait(lambda: "0.040 s" in page.find(".words").text and page.find_all(".mdi-play"), "it has come to the end")


def test_nothing_is_loaded_from_elsewhere(page: Browser) -> None:
    loaded = page.run("return performance.getEntriesByType('resource').map(entry => entry.name)")
    assert loaded
    assert [name for name in loaded if not name.startswith(("http://localhost:", "blob:http://localhost:"))] == []


def test_the_kernel_follows_the_page(notebook: Kernel, page: Browser) -> None:
    choose(page, "State of the film")
    go_to(page, *END)
    messages = notebook.run("print(shown.viewer.color, shown.viewer.index)")
    assert [message["text"].split() for message in messages if message["kind"] == "stream"] == [["state", "8"]]


@pytest.mark.usefixtures("shown")
def test_documentation_has_pictures(notebook: Kernel) -> None:
    code = 'import pyvista\npyvista.global_theme.jupyter_backend = "static"\nrun.view()'
    messages = notebook.run(code)
    assert [message["kind"] for message in messages].count("display_data") == 1
    assert notebook.run("1")[-1]["kind"] == "status"
    assert not [message for message in notebook.run("2") if message["kind"] == "update_display_data"]
