"""A page of runs in a real browser: it draws, plays, changes colour, and asks for nothing from outside."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import Browser, Pixels, opened
from membrane_rs import Spin
from membrane_rs.report import pictures as report_pictures
from membrane_rs.report import write_report
from report_pages import FRAMES, made, sail, staged_sail

STAGE = "#view-stage"
HOSTILE = "<script>window.hacked = 1<!--<img src=x onerror='window.hacked = 2'>\"'&amp;"
TITLE = f"</script></title>{HOSTILE}</script>"


@pytest.fixture(scope="module")
def one(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page of one run."""
    folder = tmp_path_factory.mktemp("one")
    return write_report(made(sail(), folder / "run"), folder / "page.html")


@pytest.fixture(scope="module")
def several(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page of three runs, one in stages and one without frames, with names that are HTML, and an experiment."""
    folder = tmp_path_factory.mktemp("several")
    runs = [
        made(replace(staged_sail(), name=HOSTILE), folder / "staged"),
        made(sail(name="slow", laws=[*sail().laws[:-1], Spin(frequency=2.0)]), folder / "<b>slow &amp;"),
        made(sail(name="blind"), folder / "blind", frames=()),
    ]
    (folder / "blind" / "frames.pvd").unlink()
    data = folder / "<i>camera.csv"
    data.write_text("time [ms],deployment_rate,</svg><script>window.hacked=3</script>\n0,0.5,1\n10,0.6,2\n", "utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(report_pictures, "_drawn", lambda _: [])  # a contact sheet takes seconds
        return write_report([*runs[:2], folder / "blind"], folder / "page.html", data=data, title=TITLE)


def ready(browser: Browser, page: Path) -> None:
    """Open a page and wait until it has drawn."""
    browser.open(page)
    wait_for(browser)


def wait_for(browser: Browser) -> None:
    browser.wait(lambda: browser.run("return document.getElementById('view-view').dataset.state") == "ready", "it drew")


def place(browser: Browser) -> float:
    """The place between frames that is drawn."""
    return float(browser.run("return document.getElementById('view-view').dataset.place"))


def is_at(browser: Browser, frame: int) -> bool:
    return place(browser) == frame


def go_to(browser: Browser, frame: int) -> Pixels:
    """Move the slider of time; what is seen then."""
    browser.run(
        "const s = document.getElementById('view-time'); s.value = arguments[0]; s.dispatchEvent(new Event('input'))",
        frame,
    )
    browser.wait(lambda: place(browser) == frame, f"frame {frame} was drawn")
    return browser.pixels("#view-canvas")


def choose(browser: Browser, name: str, value: str) -> None:
    """Choose an entry of a list."""
    browser.run(
        "const s = document.getElementById(arguments[0]); s.value = arguments[1]; s.dispatchEvent(new Event('change'))",
        name, value,
    )  # fmt: skip
    wait_for(browser)


def click_on(browser: Browser, element: Any, right: int) -> None:
    """Click so many pixels to the right of the middle of an element."""
    from selenium.webdriver import ActionChains

    browser.run("arguments[0].scrollIntoView({block: 'center'})", element)
    ActionChains(browser.driver).move_to_element_with_offset(element, right, 0).click().perform()


def differ(one: Pixels, other: Pixels) -> int:
    """How many pixels of two pictures differ visibly."""
    return int((np.abs(one.astype(int) - other.astype(int)).max(axis=2) > 24).sum())


def test_it_opens_from_disk_and_draws(browser: Browser, one: Path, tmp_path: Path) -> None:
    ready(browser, one)
    assert browser.console() == []
    assert browser.requests() == {"file"}
    seen = browser.pixels("#view-canvas")
    background = seen[100, 4]
    drawn = (np.abs(seen.astype(int) - background).max(axis=2) > 24).mean()
    assert 0.02 < drawn < 0.9
    assert len(np.unique(seen.reshape(-1, 3), axis=0)) > 50
    assert browser.find("h1").text == "small-sail"
    assert browser.find("#view-label").text == "0.020 s"
    assert browser.run("return document.title") == "small-sail"
    browser.driver.save_screenshot(str(tmp_path / "page.png"))
    assert (tmp_path / "page.png").stat().st_size > 10_000


def test_the_slider_and_keys_move_it(browser: Browser, one: Path) -> None:
    ready(browser, one)
    last, first = browser.pixels("#view-canvas"), go_to(browser, 0)
    assert differ(first, last) > 1000
    assert browser.find("#view-label").text == "0.000 s"
    assert differ(go_to(browser, FRAMES - 1), last) < 50
    view = browser.find("#view-view")
    for key, expected in (("\ue011", 0), ("\ue014", 1), ("\ue014", 2), ("\ue012", 1), ("\ue010", FRAMES - 1)):
        view.send_keys(key)  # Home, right, right, left, End
        browser.wait(partial(is_at, browser, expected), f"a key led to frame {expected}")
    assert browser.console() == []


def test_space_plays_a_page_that_was_just_opened(browser: Browser, one: Path) -> None:
    from selenium.webdriver.common.action_chains import ActionChains

    ready(browser, one)
    choose(browser, "view-speed", "4")
    browser.run("document.activeElement.blur()")
    for key, expected in (("\ue012", FRAMES - 2), (" ", FRAMES - 1)):  # left, space
        ActionChains(browser.driver).send_keys(key).perform()
        browser.wait(partial(is_at, browser, expected), f"frame {expected}")
    assert browser.run("return scrollY") == 0
    browser.run("scrollTo(0, document.body.scrollHeight)")
    assert browser.run("return document.getElementById('view-view').getBoundingClientRect().bottom < 0")
    ActionChains(browser.driver).send_keys("\ue012").perform()

    def home_scrolls() -> bool:
        ActionChains(browser.driver).send_keys("\ue011").perform()  # a key right after a scroll may be lost
        return bool(browser.run("return scrollY") == 0)

    browser.wait(home_scrolls, "the page is at its head")
    assert place(browser) == FRAMES - 1, "the picture was out of sight"
    assert browser.console() == []


def test_it_plays_to_the_end(browser: Browser, one: Path) -> None:
    ready(browser, one)
    first = go_to(browser, 0)
    # So slowly that it goes on however late it is looked at.
    browser.run("document.getElementById('view-speed').add(new Option('slow', '0.002'))")
    go_to(browser, 4)
    choose(browser, "view-speed", "0.002")
    browser.find("#view-play").click()
    browser.wait(lambda: place(browser) > 4.0, "it plays")
    assert browser.find("#view-play").text.endswith("Pause")
    browser.find("#view-view").send_keys(" ")
    browser.wait(
        lambda: browser.run("return document.getElementById('view-view').dataset.playing") == "false", "it stops"
    )
    browser.wait(lambda: place(browser).is_integer(), "it stops at a frame")
    assert differ(browser.pixels("#view-canvas"), first) > 50
    choose(browser, "view-speed", "4")
    browser.find("#view-play").click()
    browser.wait(lambda: place(browser) == FRAMES - 1, "it played to the end")
    browser.wait(lambda: browser.find("#view-play").text.endswith("Play"), "it has ended")
    assert browser.console() == []


def test_every_field_has_colours_and_a_scale(browser: Browser, one: Path) -> None:
    ready(browser, one)
    seen = {"": go_to(browser, 6)}
    assert not browser.find("#view-scale").is_displayed()
    names = browser.run("return [...document.getElementById('view-field').options].map((o) => o.value)")
    assert {"von_mises", "state", "speed", "crease_angle", "tension"} < set(names)
    for name in names[1:]:
        choose(browser, "view-field", name)
        seen[name] = browser.pixels("#view-canvas")
        assert differ(seen[name], seen[""]) > 500, name
        assert browser.find("#view-scale .bar").size["width"] > 100
        assert len(browser.find("#view-scale .ends").text.split()) >= 2
        picture, scale = browser.find(STAGE).rect, browser.find("#view-scale").rect
        assert scale["y"] > picture["y"] + picture["height"] - 2  # the film hides nothing of it, nor it the film
    assert differ(seen["von_mises"], seen["speed"]) > 500
    assert browser.find("#view-field").get_attribute("value") == "speed"
    before = browser.pixels("#view-canvas")
    assert differ(go_to(browser, 9), before) > 500
    choose(browser, "view-field", "")
    assert differ(go_to(browser, 6), seen[""]) < 50
    assert browser.console() == []


def test_the_camera_stands_still_and_comes_back(browser: Browser, one: Path) -> None:
    ready(browser, one)
    turning = go_to(browser, 5)
    choose(browser, "view-frame", "fixed")
    browser.wait(lambda: differ(browser.pixels("#view-canvas"), turning) > 500, "the sail turns")
    choose(browser, "view-frame", "turning")
    browser.wait(lambda: differ(browser.pixels("#view-canvas"), turning) < 50, "it turns back")
    box = browser.find("#view-canvas")
    from selenium.webdriver import ActionChains

    ActionChains(browser.driver).click_and_hold(box).move_by_offset(150, 60).release().perform()
    browser.wait(lambda: differ(browser.pixels("#view-canvas"), turning) > 500, "a drag turns it")
    browser.find("#view-home").click()
    browser.wait(lambda: differ(browser.pixels("#view-canvas"), turning) < 50, "the view is reset")


def test_one_of_several_runs_is_chosen(browser: Browser, several: Path) -> None:
    ready(browser, several)
    assert browser.console() == []
    assert browser.requests() == {"file"}
    first = browser.pixels("#view-canvas")
    shown = (
        "return [...document.querySelectorAll('[data-of-run]')].filter((e) => !e.hidden).map((e) => e.dataset.ofRun)"
    )
    assert set(browser.run(shown)) == {"run-0"}
    assert browser.find("#view-label").text.endswith("· let go")
    assert go_to(browser, 0) is not None
    assert browser.find("#view-label").text.endswith("· hold </script>")
    choose(browser, "view-run", "run-1")
    assert set(browser.run(shown)) == {"run-1"}
    assert differ(browser.pixels("#view-canvas"), first) > 200
    choose(browser, "view-run", "run-2")
    assert not browser.find(STAGE).is_displayed()
    assert "no frames" in browser.find("#view-note").text
    choose(browser, "view-run", "run-0")
    assert differ(browser.pixels("#view-canvas"), first) < 50
    assert browser.console() == []


def test_names_are_only_names(browser: Browser, several: Path) -> None:
    ready(browser, several)
    assert browser.run("return window.hacked") is None
    assert browser.find("h1").text == TITLE
    assert browser.run("return document.title") == TITLE
    labels = browser.run("return [...document.querySelectorAll('#view-run option')].map((e) => e.textContent)")
    assert labels == ["staged", "<b>slow &amp;", "blind"]
    assert "<i>camera" in browser.find(".legend").text
    assert "</svg><script>window.hacked=3</script>" in browser.find("#curves .note").text
    assert HOSTILE.split('"', maxsplit=1)[0] in browser.run("return document.querySelector('pre code').textContent")


def test_curves_are_shown_hidden_and_lead_to_their_time(browser: Browser, several: Path) -> None:
    ready(browser, several)
    assert browser.run("return document.querySelectorAll('#curves .run-0').length") >= 2
    box = browser.find("input[data-shows='run-1']")
    visible = "return [...document.querySelectorAll('#curves .run-1')].filter((e) => e.style.display !== 'none').length"
    count = browser.run(visible)
    box.click()
    assert (count > 1, browser.run(visible)) == (True, 0)
    box.click()
    assert browser.run(visible) == count
    svg = browser.find("#curves svg")
    before = place(browser)
    click_on(browser, svg, -100)
    browser.wait(lambda: place(browser) != before, "a click on a curve goes to its time")
    x, first, last = browser.run(
        "const s = arguments[0], l = s.querySelector('.now'), v = s.dataset.timeScale.split(' ').map(Number);"
        "return [Number(l.getAttribute('x1')), v[0], v[1]]",
        svg,
    )
    assert first < x < last


@pytest.mark.parametrize("width", [800, 1280])
def test_it_is_readable_with_names_for_all_controls(browser: Browser, several: Path, width: int) -> None:
    browser.driver.set_window_size(width, 900)
    try:
        ready(browser, several)
        assert browser.run("return document.documentElement.scrollWidth <= innerWidth")
        without = browser.run(
            "return [...document.querySelectorAll('button, input, select, img, svg')].filter((e) => !(e.alt || "
            "e.getAttribute('aria-label') || e.textContent.trim() && e.matches('button') || e.labels && e.labels.length"
            ")).map((e) => e.outerHTML.slice(0, 80))"
        )
        assert without == []
        levels = browser.run("return [...document.querySelectorAll('h1, h2, h3')].map((e) => Number(e.tagName[1]))")
        assert levels[0] == 1
        assert max(np.diff(levels)) <= 1
        assert browser.run("return document.querySelectorAll('[id]').length") == browser.run(
            "return new Set([...document.querySelectorAll('[id]')].map((e) => e.id)).size"
        )
    finally:
        browser.driver.set_window_size(1280, 900)


def test_it_is_dark_where_that_is_wanted_and_prints(browser: Browser, one: Path) -> None:
    try:
        browser.media(prefers_color_scheme="dark")
        ready(browser, one)
        assert browser.pixels("#view-canvas")[100, 4].max() < 64
        assert browser.pixels("body")[-2, 2].max() < 64
        browser.media(prefers_color_scheme="light")
        browser.wait(lambda: browser.pixels("#view-canvas")[100, 4].min() > 200, "the picture is light")
        browser.media(media="print")
        assert not browser.find(".controls").is_displayed()
        assert browser.find(".sheets img").is_displayed()
        assert len(browser.driver.print_page()) > 50_000
    finally:
        browser.media()


def test_without_webgl_the_rest_remains(several: Path) -> None:
    with opened("--disable-gpu", "--disable-3d-apis") as browser:
        browser.open(several)
        browser.wait(lambda: browser.find("#view-failed").is_displayed(), "it says that it cannot draw")
        assert "needs WebGL" in browser.find("#view-failed").text
        wait_for(browser)
        browser.console()  # k3d's own complaints
        for hidden in (STAGE, "#view-controls", "#view-help"):
            assert not browser.find(hidden).is_displayed()
        reading = browser.find("[data-of-run='run-0'] [data-samples]")
        before = reading.text
        click_on(browser, browser.find("#curves svg"), -100)
        browser.wait(lambda: reading.text != before, "a click on a curve goes to its time")
        choose(browser, "view-run", "run-1")
        assert browser.find("[data-of-run='run-1'] [data-samples]").is_displayed()
        assert browser.find("#view-failed").is_displayed()
        choose(browser, "view-run", "run-2")
        assert not browser.find("#view-failed").is_displayed()  # it has no frames, with or without WebGL
        assert browser.console() == []


def test_without_scripts_pictures_curves_and_tables_remain(browser: Browser, one: Path) -> None:
    browser.driver.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": True})
    try:
        browser.open(one)
        assert "JavaScript is off" in browser.find("noscript p").text
        for shown in (".sheets img", "#curves svg", ".readings", "pre code"):
            assert browser.find(shown).is_displayed(), shown
        for hidden in (STAGE, "#view-controls", "#view-help", ".legend input"):
            assert not browser.find(hidden).is_displayed(), hidden
    finally:
        browser.driver.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": False})


def test_a_narrow_page_shows_the_whole_shape(browser: Browser, one: Path) -> None:
    browser.driver.set_window_size(500, 900)  # Chromium's windows are not narrower
    try:
        ready(browser, one)
        assert browser.run("return document.documentElement.scrollWidth <= innerWidth")
        seen = browser.pixels("#view-canvas").astype(int)
        drawn = np.abs(seen - seen[-2, 2]).max(axis=2) > 24
        assert drawn[80:].any()
        assert not drawn[80:, :8].any()
        assert not drawn[80:, -8:].any()
    finally:
        browser.driver.set_window_size(1280, 900)
