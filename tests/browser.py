"""A headless Chromium for tests of pages: what it shows, what its console says, what it asks the network for.

Chromium and its driver come from the system (Debian: chromium, chromium-driver); without them a test is skipped. The
network is cut off.
"""

from __future__ import annotations

import io
import json
import os
import shutil
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

PROGRAMS = ("chromium", "chromium-browser", "google-chrome")
DRIVER = "chromedriver"
SECONDS = 240.0
"""A page that takes longer for what is waited for fails its test; software draws slowly on a busy machine."""
GRAPHICS = ("--use-angle=swiftshader", "--enable-unsafe-swiftshader")
"""WebGL by software."""
Pixels = NDArray[np.uint8]


def missing() -> str | None:
    """Why no page can be opened here; None where it can."""
    if not any(map(shutil.which, PROGRAMS)):
        return f"no Chromium: none of {', '.join(PROGRAMS)} is installed"
    return None if shutil.which(DRIVER) else f"no {DRIVER} is installed"


class Browser:
    """One window of Chromium."""

    def __init__(self, width: int = 1280, height: int = 900, flags: Sequence[str] = GRAPHICS) -> None:
        from selenium import webdriver
        from selenium.webdriver.chrome.service import Service

        options = webdriver.ChromeOptions()
        options.binary_location = str(next(filter(None, map(shutil.which, PROGRAMS))))
        for flag in (
            "--headless=new", "--hide-scrollbars", "--force-device-scale-factor=1", f"--window-size={width},{height}",
            "--disable-dev-shm-usage", *flags,
        ):  # fmt: skip
            options.add_argument(flag)
        if hasattr(os, "geteuid") and os.geteuid() == 0:
            options.add_argument("--no-sandbox")  # Chromium refuses root its sandbox
        options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
        self.driver: Any = webdriver.Chrome(options, Service(str(shutil.which(DRIVER))))
        self.driver.set_page_load_timeout(SECONDS)
        self.driver.set_script_timeout(SECONDS)
        self.driver.execute_cdp_cmd("Network.enable", {})
        self.cut_off()

    def cut_off(self) -> None:
        """Let nothing through the network."""
        off = {"offline": True, "latency": 0, "downloadThroughput": 0, "uploadThroughput": 0}
        self.driver.execute_cdp_cmd("Network.emulateNetworkConditions", off)

    def let_in(self) -> None:
        """Let the network in, for a page that is served on this machine."""
        on = {"offline": False, "latency": 0, "downloadThroughput": -1, "uploadThroughput": -1}
        self.driver.execute_cdp_cmd("Network.emulateNetworkConditions", on)

    def open(self, page: Path | str) -> None:
        """Open a file or an address, with logs that hold nothing of before."""
        self.console()
        self.requests()
        self.driver.get(page if isinstance(page, str) else page.resolve().as_uri())

    def run(self, script: str, *values: object) -> Any:
        """What a script in the page returns."""
        return self.driver.execute_script(script, *values)

    def find(self, selector: str) -> Any:
        """The first element of a CSS selector."""
        return self.driver.find_element("css selector", selector)

    def find_all(self, selector: str) -> list[Any]:
        """All elements of a CSS selector."""
        return list(self.driver.find_elements("css selector", selector))

    def wait(self, holds: Callable[[], object], what: str) -> None:
        """Wait until something holds; fail by its name. What is asked of an element that the page replaces meanwhile,
        or of one that still moves or is covered, is asked again.
        """
        from selenium.common import exceptions

        passing = (
            exceptions.StaleElementReferenceException, exceptions.NoSuchElementException,
            exceptions.ElementNotInteractableException, exceptions.ElementClickInterceptedException,
        )  # fmt: skip
        end = time.monotonic() + SECONDS
        while True:
            with suppress(*passing):
                if holds():
                    return
            assert time.monotonic() < end, f"waited {SECONDS:g} s until {what}; the console says {self.console()}"
            time.sleep(0.02)

    def click(self, element: Callable[[], Any], what: str) -> None:
        """Click on an element once that is possible; `element` finds it."""

        def clicked() -> bool:
            element().click()
            return True

        self.wait(clicked, f"{what} can be clicked on")

    def pixels(self, selector: str = "") -> Pixels:
        """What an element shows, or the window, (height, width, 3)."""
        from PIL import Image

        seen = self.find(selector).screenshot_as_png if selector else self.driver.get_screenshot_as_png()
        with Image.open(io.BytesIO(seen)) as image:
            return np.asarray(image.convert("RGB"))

    def console(self) -> list[str]:
        """Warnings and errors of the console since it was last asked."""
        entries = self.driver.get_log("browser")
        return [entry["message"] for entry in entries if entry["level"] in ("WARNING", "SEVERE")]

    def requests(self) -> set[str]:
        """The kinds of what was asked for since the last call, such as "file" and "https", but for data."""
        messages = [json.loads(entry["message"])["message"] for entry in self.driver.get_log("performance")]
        sent = [message["params"] for message in messages if message["method"] == "Network.requestWillBeSent"]
        return {params["request"]["url"].partition(":")[0] for params in sent} - {"data", "blob"}

    def media(self, **features: str) -> None:
        """Emulate media: `media(prefers_color_scheme="dark")`, `media(media="print")`; nothing: back to normal."""
        kind = features.pop("media", "")
        pairs = [{"name": name.replace("_", "-"), "value": value} for name, value in features.items()]
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": kind, "features": pairs})

    def close(self) -> None:
        """End the program."""
        self.driver.quit()


@contextmanager
def opened(*flags: str, width: int = 1280, height: int = 900) -> Iterator[Browser]:
    """A Chromium with other flags than those of `GRAPHICS`, or a skipped test."""
    reason = missing()
    if reason is not None:
        pytest.skip(reason)
    pytest.importorskip("selenium")
    made = Browser(width, height, flags or GRAPHICS)
    try:
        yield made
    finally:
        made.close()


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """A Chromium, or a skipped test."""
    with opened() as made:
        yield made
