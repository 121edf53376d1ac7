"""STOP is there before anything else, above everything else, and says whether it was heard."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import httpx
import pytest
from browsers import until

from pa10d.daemon.presence import present

ON_TOP = """() => {
  const box = document.getElementById("stop").getBoundingClientRect();
  const there = [[0.1, 0.1], [0.5, 0.5], [0.9, 0.9]].map(([x, y]) =>
    document.elementFromPoint(box.x + x * box.width, box.y + y * box.height)?.id);
  return box.width >= 90 && box.height >= 44 && there.every((id) => id === "stop");
}"""
NINE = """async () => {
  const main = document.querySelector("script[type=module]").src;
  const { notice } = await import(new URL("base/notices.js", main).href);
  for (let k = 0; k < 9; k += 1) 
    notice(`Number ${k} went wrong.`, { kind: "error", detail: "why ".repeat(60) });
}"""


def heard(page) -> None:
    """Told by the button's script or, pressed before that has come, by the page that the form of
    the bare button leads to."""
    page.get_by_text("Stop was heard").first.wait_for()


@pytest.mark.parametrize(
    "lost", ["never comes", pytest.param("is broken", marks=pytest.mark.long), "hangs"]
)
def test_stop_needs_nothing_else_of_the_page(archive, visit, lost):
    url, _ = archive
    page = visit(url).page
    kept = []
    answers = {
        "never comes": lambda route: route.abort(),
        "is broken": lambda route: route.fulfill(body="throw new Error('broken')"),
        "hangs": lambda route: kept.append(route),
    }
    page.route(lambda address: "/assets/" in address and "stop.js" not in address, answers[lost])
    page.goto(url, wait_until="commit")
    page.locator("#stop").wait_for(timeout=30_000)
    assert page.evaluate(ON_TOP)
    page.click("#stop", timeout=30_000)
    heard(page)


def test_stop_needs_no_script_at_all(archive, visit):
    url, _ = archive
    page = visit(url, java_script_enabled=False).page
    page.goto(url)
    page.click("#stop")
    page.get_by_role("heading", name="Stop was heard").wait_for()


@pytest.mark.parametrize("width", [390, pytest.param(1360, marks=pytest.mark.long)])
def test_nothing_covers_stop(archive, visit, width):
    url, _ = archive
    visitor = visit(url, viewport={"width": width, "height": 700})
    page = visitor.page
    visitor.open("runs")
    inside = """[...document.querySelectorAll("nav a")].every((link) =>
      link.getBoundingClientRect().left >= 0 && link.getBoundingClientRect().right <= innerWidth)"""
    assert page.evaluate(inside), "every section's name is to be seen, on a phone too"
    page.evaluate(NINE)
    assert page.locator(".notice:visible").count() == 3
    assert page.evaluate(ON_TOP)
    page.get_by_role("button", name="Close all").click()
    assert page.locator(".notice").count() == 0
    page.get_by_role("button", name="train_a", exact=True).click()
    until(
        page, "document.getElementById('run-detail').getBoundingClientRect().top < innerHeight / 2"
    )
    page.get_by_role("button", name="Delete", exact=True).click()
    page.get_by_role("dialog").wait_for()
    assert page.evaluate(ON_TOP)
    page.click("#stop")
    heard(page)
    page.locator("#stop-said").get_by_role("button", name="Close").click()
    page.get_by_role("button", name="Leave it").click()
    assert not visitor.errors


def test_no_section_is_beside_stop_on_a_phone(archive, visit):
    """A thumb on the upper edge of a tab is not to stop the arm; neither with larger text."""
    visitor = visit(archive[0], viewport={"width": 390, "height": 800})
    visitor.open("tune")
    below = """() => { const stop = document.getElementById("stop").getBoundingClientRect();
      return Math.min(...[...document.querySelectorAll("nav a")].map(
        (link) => link.getBoundingClientRect().top)) - stop.bottom; }"""
    assert visitor.page.evaluate(below) >= 4
    visitor.page.evaluate("() => { document.documentElement.style.fontSize = '200%'; }")
    assert visitor.page.evaluate(below) >= 4


@pytest.mark.long
def test_stop_grows_with_the_text_and_covers_nothing(archive, visit):
    """At 200 % text, as a browser's own setting gives it."""
    url, _ = archive
    for width in (390, 1360):
        visitor = visit(url, viewport={"width": width, "height": 700})
        page = visitor.page
        visitor.open("runs")
        size = "() => parseFloat(getComputedStyle(document.getElementById('stop')).fontSize)"
        before = page.evaluate(size)
        page.evaluate("() => { document.documentElement.style.fontSize = '200%'; }")
        assert page.evaluate(size) == 2 * before
        assert page.evaluate(ON_TOP)
        page.click("#stop")
        heard(page)
        apart = """() => document.getElementById("stop-said").getBoundingClientRect().top
          >= document.getElementById("stop").getBoundingClientRect().bottom"""
        assert page.evaluate(apart)
        right = """() => { const box = document.getElementById("stop").getBoundingClientRect();
          return box.left >= 0 && box.right <= innerWidth; }"""
        assert page.evaluate(right)
        page.evaluate(NINE)
        below = """() => document.getElementById("notices").getBoundingClientRect().top
          >= document.getElementById("header").getBoundingClientRect().bottom"""
        until(page, f"({below})()")


def test_stop_by_keyboard_also_while_typing(archive, visit):
    url, _ = archive
    visitor = visit(url)
    page = visitor.page
    visitor.open("models")
    page.get_by_label("Name").fill("sss")
    assert page.locator("#stop-said").is_hidden()
    page.keyboard.press("Escape")
    page.wait_for_timeout(800)
    page.keyboard.press("Escape")
    assert page.locator("#stop-said").is_hidden()
    for _ in range(4):  # two of them at once, however slow this machine is
        page.keyboard.press("Escape")
    heard(page)
    assert page.get_by_label("Name").input_value() == "sss"


def test_a_stop_that_nobody_hears_says_so_until_somebody_does(visit, tmp_path):
    """The daemon hangs, comes back, and dies; the lights never claim what nobody knows."""
    command = [sys.executable, "-m", "pa10d", "--data", str(tmp_path), "--json", "serve", "--port",
               "0", "--no-sim", "--channel", f"void-{tmp_path.name[-20:]}"]  # fmt: skip
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as daemon:
        daemon.stdout.readline()
        found = present(tmp_path)
        visitor = visit(found.url)
        page = visitor.page
        visitor.open("robot")
        os.kill(found.pid, signal.SIGSTOP)
        page.click("#stop")
        page.locator("#stop-said.bad", has_text="hardware emergency stop").wait_for(timeout=15_000)
        os.kill(found.pid, signal.SIGCONT)
        heard(page)
        daemon.kill()
        daemon.wait()
        page.click("#stop")
        said = page.locator("#stop-said.bad", has_text="STOP WAS NOT HEARD")
        said.wait_for(timeout=15_000)
        assert "hardware emergency stop" in said.inner_text()


@pytest.mark.long
def test_plots_come_compressed_for_good_and_only_when_one_is_shown(archive, visit):
    url, _ = archive
    visitor = visit(url)
    page = visitor.page
    visitor.open("robot")
    assert not [one for one in visitor.asked if "plotly" in one]
    page.goto(f"{url}/#/runs")
    page.get_by_role("button", name="train_a", exact=True).click()
    page.locator("#run-detail .main-svg").first.wait_for()
    (plotly,) = [one for one in visitor.asked if "plotly" in one]
    answer = httpx.get(plotly, headers={"Accept-Encoding": "gzip"}, trust_env=False, timeout=60)
    assert answer.headers["content-encoding"] == "gzip"
    assert int(answer.headers["content-length"]) < 1_600_000
    assert "immutable" in answer.headers["cache-control"]
    before = len(visitor.asked)
    page.reload()
    until(page, "document.querySelector('#arm-state')?.textContent.length > 1")
    again = [one for one in visitor.asked[before:] if "/assets/" in one]
    kept = page.evaluate(
        "performance.getEntriesByType('resource').filter((one) => one.name.includes('/assets/')"
        " && one.transferSize > 0).map((one) => one.name)"
    )
    assert again
    assert kept == [], "asked of the daemon again"


def test_the_page_is_there_at_once_on_a_slow_link(archive, visit):
    url, _ = archive
    page = visit(url).page
    line = page.context.new_cdp_session(page)
    line.send("Network.enable")
    line.send("Network.emulateNetworkConditions", {
        "offline": False, "latency": 150, "downloadThroughput": 50_000, "uploadThroughput": 20_000,
    })  # 400 kbit/s  # fmt: skip
    began = time.monotonic()
    page.goto(url, wait_until="commit")
    page.click("#stop")  # with or without its script
    page.get_by_text("Stop was heard").first.wait_for()
    assert time.monotonic() - began < 15.0  # 2 s on a quiet machine


def test_what_it_says_stands_there_no_longer_than_it_holds(archive, visit):
    url, _ = archive
    page, now = visit(url).page, {"state": "holding", "quiet": 0}
    page.goto(url)
    page.route("**/api/v1/robot/stop", lambda route: route.fulfill(json=now))
    page.route("**/api/v1/robot", lambda route: route.fulfill(json=now))
    page.click("#stop")
    page.get_by_text("The arm stands still and is held").wait_for()
    page.wait_for_timeout(1000)
    assert page.locator("#stop-said").is_visible()
    now["state"] = "inactive"
    page.get_by_text("The arm stands still, unpowered").wait_for()
    now["state"] = "running"
    page.locator("#stop-said").wait_for(state="hidden", timeout=4000)


def test_an_alarm_ends_once_the_arm_is_known_to_be_at_rest(archive, visit):
    url, _ = archive
    page, now = visit(url).page, {"state": "offline", "quiet": 0, "offline_reason": "it starts"}
    page.goto(url)
    page.route("**/api/v1/robot/stop", lambda route: route.fulfill(json=now))
    page.route("**/api/v1/robot", lambda route: route.fulfill(json=now))
    page.click("#stop")
    page.locator("#stop-said.bad", has_text="no drive answers (it starts)").wait_for()
    now["state"] = "inactive"
    page.locator("#stop-said.heard", has_text="stands still, unpowered").wait_for(timeout=4000)
    now |= {"state": "running", "quiet": 5}
    page.click("#stop")
    page.locator("#stop-said.bad", has_text="has not answered").wait_for(timeout=15_000)
    page.wait_for_timeout(1000)
    assert page.locator("#stop-said.bad").is_visible()
    now |= {"state": "holding", "quiet": 0}
    page.locator("#stop-said.heard", has_text="stands still and is held").wait_for(timeout=9000)
    now["state"] = "offline"
    page.locator("#stop-said.bad", has_text="no drive answers").wait_for(timeout=4000)
    now["state"] = "enabling"  # by somebody: nothing that was to stop
    page.locator("#stop-said").wait_for(state="hidden", timeout=4000)
