"""Ten things that somebody wants on the first day, each by what the page says, in five clicks."""

from __future__ import annotations

import os
import re
import signal

import pytest
from benches import children_of
from browsers import until
from small_arm import small_arm

from pa10d.client import local_daemon
from pa10d.daemon.presence import present

pytestmark = [pytest.mark.long, pytest.mark.timeout(600)]
MOST = 5
ROLES = ("button", "link", "tab", "checkbox")


class Stranger:
    """Clicks what can be read, and counts."""

    def __init__(self, page) -> None:
        self.page, self.clicks = page, 0

    def click(self, name: str) -> None:
        """A button, link, tab, box or line of this name, wherever it is to be seen first."""
        self.clicks += 1
        assert self.clicks <= MOST, f"more than {MOST} clicks"
        words = re.compile(f"^{re.escape(name)}")
        found = None
        for _ in range(400):
            for role in ROLES:
                these = self.page.get_by_role(role, name=words)
                found = found or next((one for one in these.all() if one.is_visible()), None)
            plain = self.page.get_by_text(words)
            found = found or next((one for one in plain.all() if one.is_visible()), None)
            if found:
                return found.click()
            self.page.wait_for_timeout(50)
        raise AssertionError(f"nothing to be seen is called {name!r}")

    def sees(self, words: str) -> None:
        """Somewhere, before long."""
        self.page.get_by_text(re.compile(words)).locator("visible=true").first.wait_for()


@pytest.fixture
def someone(archive, visit):
    visitor = visit(archive[0])
    visitor.open()
    yield Stranger(visitor.page)
    assert not visitor.errors


def test_1_which_joint_and_how_sure(someone):
    for name in ("Diagnose", "What is missing?"):
        someone.click(name)
    finding = someone.page.locator(".finding").first
    finding.wait_for(timeout=400_000)
    assert "joint 4" in finding.inner_text().lower()
    someone.sees("by chance|significan|p = |p <")


def test_2_watch_the_arm_go_through_a_recording(someone):
    for name in ("Runs", "train_a", "▶ Play"):
        someone.click(name)
    someone.sees(r"At [1-9]\.\d\d s, rad")


def test_3_where_does_the_model_fail(someone):
    someone.click("Compare")
    someone.page.locator("#compare-start:enabled").wait_for()
    someone.page.locator("#compare").get_by_role("button", name="Compare").click()
    someone.clicks += 1
    someone.page.locator(".sentence").first.wait_for(timeout=120_000)
    someone.sees("^4 E1")  # the worst joint


def test_4_what_frequency_is_in_a_torque(someone):
    for name in ("Explore", "Recordings", "train_a", "Spectrum"):
        someone.click(name)
    someone.sees("Spectrum of torque measured")


def test_5_leave_the_middle_of_a_run_out_of_fits(someone):
    for name in ("Explore", "Recordings", "train_a"):
        someone.click(name)
    someone.page.keyboard.press("Escape")  # the list that lies over the buttons
    for name in ("Zoom in", "Leave this stretch out"):
        someone.click(name)
    someone.sees("train_a: .* s left out")
    someone.page.get_by_role("button", name=re.compile("^use again")).click()


def test_6_what_does_a_model_say_of_a_run(someone):
    for name in ("Explore", "Recordings", "valid_a"):
        someone.click(name)
    someone.page.locator("#explore summary", has_text="Models").click()
    someone.page.get_by_role("checkbox", name="m0").check()
    someone.clicks += 2
    assert someone.clicks <= MOST
    chosen = "document.querySelector('#explore figcaption select').textContent"
    until(someone.page, f"{chosen}.includes('model m0: residual')")


def test_7_take_a_model_elsewhere(someone):
    someone.click("Models")
    someone.page.get_by_text("m0").first.wait_for()
    with someone.page.expect_download() as got:
        someone.click("URDF")
    assert got.value.suggested_filename.endswith(".urdf")


def test_8_make_a_joint_slower_and_take_it_back(arm, visit):
    visitor = visit(arm.url)
    visitor.open()
    stranger, page = Stranger(visitor.page), visitor.page
    before = arm.tuning()["values"]
    for name in ("Tune", "Limits"):
        stranger.click(name)
    page.get_by_label("velocity of joint 2 S2, rad/s").fill("0.5")
    for name in ("Show the difference", "Write version"):
        stranger.click(name)
    stranger.sees("of the profile holds")
    assert arm.tuning()["values"] != before
    arm.wait_for_robot("inactive", timeout=90)
    stranger.clicks = 0
    for name in ("Undo the last change", "Undo: back to"):
        stranger.click(name)
    until(page, "document.querySelector('#tune').textContent.includes('version 1.')")
    assert arm.tuning()["values"] == before
    arm.wait_for_robot("inactive", timeout=90)
    page.click("#lease")


def test_9_see_a_motion_before_it_is_made(arm, visit):
    visitor = visit(arm.url)
    visitor.open()
    stranger = Stranger(visitor.page)
    stranger.click("Experiments")
    visitor.page.locator("#experiments h1").wait_for()
    for name in ("Tracking", "Check"):
        stranger.click(name)
    visitor.page.get_by_text("The plan, before anything moves").wait_for(timeout=120_000)
    stranger.click("▶ Play the plan")
    stranger.sees("mm between|no floor")


def test_10_get_the_arm_back_after_a_fault(tmp_path, visit, browser):
    with local_daemon(tmp_path / "data", str(small_arm(tmp_path)), clock="simulated") as client:
        visitor = visit(client.url)
        visitor.open("models")
        stranger = Stranger(visitor.page)
        client.enable()
        for pid in children_of(present(tmp_path / "data").pid, "pa10d.daemon.processes.simulator"):
            os.kill(pid, signal.SIGKILL)
        client.wait_for_robot("fault")
        client.let_others_command()
        visitor.page.locator("#models .guide a", has_text="Reset").wait_for()
        stranger.click("Reset")
        visitor.page.locator("#robot").get_by_role("button", name="Reset").click()
        stranger.clicks += 1
        visitor.page.locator("#arm-state", has_text="inactive").wait_for(timeout=90_000)
        assert stranger.clicks <= MOST
