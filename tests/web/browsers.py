"""A real browser, and a page that keeps an account of what it asked for."""

from __future__ import annotations

import contextlib
import os
import shutil
import time
from collections.abc import Iterator
from urllib.parse import urlsplit

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome")
SIZE = {"width": 1360, "height": 900}
DROP = """async (text) => {
  const data = new DataTransfer();
  data.items.add(new File([text], "dropped.csv"));
  const zone = document.querySelector(".drop");
  for (const kind of ["dragover", "drop"])
    zone.dispatchEvent(new DragEvent(kind, { dataTransfer: data, bubbles: true }));
}"""
"""Drops a file of this text where the section takes files."""


def executable() -> str:
    """The browser; a test is skipped where there is none."""
    named = os.environ.get("PA10D_CHROMIUM")
    found = named or next((path for name in NAMES if (path := shutil.which(name))), None)
    if found is None:
        pytest.skip("no Chromium here (apt-get install chromium, or PA10D_CHROMIUM=PATH)")
    return found


@contextlib.contextmanager
def chromium() -> Iterator:
    """A headless browser; it may run as root, which its sandbox does not like."""
    path = executable()
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=path, args=["--no-sandbox"])
        try:
            yield browser
        finally:
            browser.close()


def until(page, condition: str, seconds: float = 30.0, among=lambda: "") -> None:
    """Wait for a JavaScript condition. Asked from here, because the page's own policy forbids
    evaluating strings in it, which is how Playwright would wait. among: what else to tell of
    the page where it never becomes true."""
    end = time.monotonic() + seconds
    while not page.evaluate(condition):
        assert time.monotonic() < end, f"never true: {condition} {among()}"
        page.wait_for_timeout(30)


def until_known(page) -> None:
    """Wait until control has started, or cannot: until then the guide has nothing else to say."""
    until(page, "!document.querySelector('.guide')?.textContent.includes('is not there yet')", 90)


class Visitor:
    """One browser window with a session of its own. ``asked``: every address it fetched;
    ``refused``: those that were answered by an error."""

    def __init__(self, browser, url: str, **options) -> None:
        self.url = url
        self.context = browser.new_context(**{"viewport": SIZE, **options})
        self.page = self.context.new_page()
        self.page.set_default_timeout(60_000)
        self.page.set_default_navigation_timeout(150_000)  # a browser may come from a cold disk
        self.asked: list[str] = []
        self.refused: list[str] = []
        self.errors: list[str] = []
        self._open: set = set()
        self.page.on("request", self._asks)
        for end in ("requestfinished", "requestfailed"):
            self.page.on(end, lambda request: self._open.discard(request))
        self.page.on("response", self._answered)
        self.page.on("websocket", lambda socket: self.asked.append(socket.url))
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.on("console", self._heard)

    def _asks(self, request) -> None:
        self.asked.append(request.url)
        self._open.add(request)

    def _answered(self, answer) -> None:
        if answer.status >= 400:
            self.refused.append(f"{answer.status} {answer.url}")

    def _heard(self, message) -> None:
        if message.type == "error" and "Failed to load resource" not in message.text:
            self.errors.append(message.text)

    def open(self, section: str = "") -> None:
        """Go to a section, once the page knows what there is."""
        self.page.goto(f"{self.url}/#/{section}")
        until(self.page, "document.querySelector('#arm-state')?.textContent.length > 1")
        self.page.locator(f"#{section or 'robot'} h1").wait_for()

    def until_answered(self, seconds: float = 30.0) -> None:
        """Wait until everything that was asked for has come."""
        end = time.monotonic() + seconds
        while self._open:
            assert time.monotonic() < end, [request.url for request in self._open]
            self.page.wait_for_timeout(30)

    def foreign(self) -> list[str]:
        """What was asked of anybody but the daemon."""
        mine = urlsplit(self.url).netloc
        inside = ("data", "blob", "about")
        asked = [urlsplit(address) for address in self.asked]
        return [a.geturl() for a in asked if a.scheme not in inside and a.netloc != mine]

    def close(self) -> None:
        """End the session."""
        self.context.close()
