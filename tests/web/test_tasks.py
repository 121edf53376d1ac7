"""Ten things that somebody wants on the first day, each by what the page says, in five clicks."""

from __future__ import annotations

import re

import pytest
from browsers import until

pytestmark = pytest.mark.long
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
                found = next((one for one in these.all() if one.is_visible()), found)
            plain = self.page.get_by_text(words)
            found = found or next((one for one in plain.all() if one.is_visible()), None)
            if found:
                return found.click()
            self.page.wait_for_timeout(50)
        raise AssertionError(f"nothing to be seen is called {name!r}")

    def choose(self, label: str, what: str) -> None:
        """From a list; counts as one click."""
        self.clicks += 1
        assert self.clicks <= MOST, f"more than {MOST} clicks"
        self.page.get_by_label(label).locator("visible=true").first.select_option(what)

    def sees(self, words: str) -> None:
        """Somewhere, before long."""
        self.page.get_by_text(re.compile(words)).locator("visible=true").first.wait_for()


@pytest.fixture
def someone(archive, visit):
    visitor = visit(archive[0])
    visitor.open()
    yield Stranger(visitor.page)
    assert not visitor.errors


def test_1_watch_the_arm_go_through_a_recording(someone):
    for name in ("Runs", "train_a", "▶ Play"):
        someone.click(name)
    someone.sees(r"At [1-9]\.\d\d s, rad")


def test_2_see_a_measured_temperature_or_torque_over_time(someone):
    for name in ("Runs", "train_a", "Explore"):
        someone.click(name)
    someone.page.locator("#explore .chart canvas").nth(1).wait_for()


def test_3_where_does_the_model_fail(someone):
    someone.click("Compare")
    someone.page.locator("#compare-start:enabled").wait_for()
    someone.page.locator("#compare").get_by_role("button", name="Compare").click()
    someone.clicks += 1
    someone.page.locator(".sentence").first.wait_for(timeout=120_000)
    someone.sees("joint 4")


def test_4_what_frequency_is_in_a_torque(someone):
    for name in ("Explore", "Recordings", "train_a", "Spectrum"):
        someone.click(name)
    someone.sees("Spectrum of torque measured")


def test_5_leave_the_middle_of_a_run_out_of_fits(someone):
    for name in ("Explore", "Recordings", "train_a", "Zoom in", "Leave this stretch out"):
        someone.click(name)
    someone.sees("train_a: .* s left out")
    someone.page.get_by_role("button", name=re.compile("^use .* again")).click()


def test_6_what_does_a_model_say_of_a_run(someone):
    for name in ("Explore", "Recordings", "valid_a"):
        someone.click(name)
    someone.page.locator("#explore summary", has_text="Models").click()
    someone.page.get_by_label("m0").check()
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


def test_8_look_at_the_joints_of_the_arm_from_above(someone):
    someone.page.locator("#robot .arm-stage canvas").wait_for()
    before = someone.page.locator("#robot .arm-stage canvas").screenshot()
    someone.click("Top")
    someone.page.wait_for_timeout(500)
    assert someone.page.locator("#robot .arm-stage canvas").screenshot() != before


def test_9_see_a_motion_before_it_is_made(arm, visit):
    visitor = visit(arm.url)
    visitor.open()
    stranger = Stranger(visitor.page)
    for name in ("Experiments", "Tracking", "Check"):
        stranger.click(name)
    visitor.page.get_by_text("The plan, before anything moves").wait_for(timeout=120_000)
    stranger.click("▶ Play the plan")
    stranger.sees("mm between|no floor")


def test_10_stop_the_arm(arm, visit):
    visitor = visit(arm.url)
    visitor.open()
    stranger = Stranger(visitor.page)
    stranger.click("Stop")
    visitor.page.locator("#stop-said").wait_for()
    assert stranger.clicks == 1
