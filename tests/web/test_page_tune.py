"""Tuning by buttons and keys: the difference first, the motion before and after, undo."""

from __future__ import annotations

import pytest
from browsers import until
from small_arm import small_arm

from pa10d.client import Client, local_daemon

LONG = 120_000  # ms for planning, moving and analysing on a loaded machine


@pytest.fixture(scope="module")
def own(browser, tmp_path_factory) -> Client:
    """An arm whose profile nobody else counts on."""
    folder = tmp_path_factory.mktemp("tune")
    with local_daemon(folder / "data", str(small_arm(folder)), clock="simulated") as client:
        client.profile = folder / "small.yaml"
        yield client


def written(page, arm, version: int) -> None:
    page.get_by_text(f"Version {version} of the profile holds").wait_for()
    arm.wait_for_robot("inactive", timeout=90)
    until(page, "!document.querySelector('#tune form .primary').disabled", 90)


def difference(page) -> list[str]:
    page.get_by_role("button", name="Show the difference").press("Enter")
    page.get_by_role("list", name="what changes").wait_for()
    return page.get_by_role("list", name="what changes").get_by_role("listitem").all_inner_texts()


def record(page, count: int) -> None:
    page.get_by_role("button", name="Record", exact=True).press("Enter")
    page.locator(".answers tbody tr").nth(count - 1).wait_for(timeout=LONG)


@pytest.mark.long
@pytest.mark.timeout(600)
def test_a_servo_is_tuned_by_its_step(own, visit):
    before = own.profile.read_text()
    visitor = visit(own.url)
    visitor.open("robot")
    visitor.open("tune")
    page = visitor.page
    page.get_by_label("joint", exact=True).select_option("2")
    page.get_by_label("moved by").select_option("pid")
    record(page, 1)

    page.get_by_label("bandwidth, Hz").fill("2")
    page.keyboard.press("Tab")
    assert difference(page) == ["bandwidth: 4 Hz → 2 Hz"]
    page.get_by_text("9 more values follow from that").wait_for()
    page.get_by_role("button", name="Write version 2").press("Enter")
    written(page, own, 2)
    assert "bandwidth_hz: 2" in own.profile.read_text()
    assert sum("telemetry" in address for address in visitor.asked) == 2  # with other limits
    record(page, 2)
    soft, hard = [
        page.locator(".answers tbody tr").nth(k).locator("td").all_inner_texts() for k in (1, 0)
    ]
    assert (soft[0], hard[0]) == ("PID alone", "PID alone")
    assert float(soft[1]) < 0.5 * float(hard[1])  # kp
    assert float(soft[8].split()[0]) > 2 * float(hard[8])  # RMS error
    assert "%" in soft[8]
    assert page.locator("#tune .u-over").count() == 2

    page.get_by_role("tab", name="Limits").click()
    page.get_by_label("velocity of joint 1 S1, rad/s").fill("1.2")
    page.keyboard.press("Tab")
    difference(page)
    page.get_by_text("joint 1: velocity of 1.2 rad/s goes beyond the URDF's 1").wait_for()
    write = page.get_by_role("button", name="Write version 3")
    assert write.is_disabled()
    page.get_by_label("I have read this, and want it").press("Space")
    assert write.is_enabled()
    page.click("#lease")
    page.locator("#lease", has_text="free to command").wait_for()
    own.enable()
    page.get_by_text("Not now: the arm is powered: disable it first.").wait_for()
    assert write.is_disabled()
    own.disable()
    own.let_others_command()
    page.get_by_role("button", name="Discard").click()

    page.get_by_role("button", name="Undo the last change").press("Enter")
    page.locator("#tune button:enabled", has_text="Undo: back to version 1").wait_for()
    page.get_by_role("button", name="Undo: back to version 1").press("Enter")
    written(page, own, 1)
    assert own.profile.read_text() == before
    page.get_by_label("bandwidth, Hz").wait_for(state="hidden")  # the tab stayed
    page.get_by_role("tab", name="Gains").click()
    assert page.get_by_label("bandwidth, Hz").input_value() == "4"
    assert visitor.errors == []


def test_a_slip_is_one_line_and_writes_nothing(arm, visit):
    before = arm.tuning()
    visitor = visit(arm.url)
    visitor.open("tune")
    page = visitor.page
    page.get_by_role("tab", name="Bounds").click()
    page.get_by_label("following error of joint 3").fill("-1")
    page.get_by_role("button", name="Show the difference").click()
    said = "Following error of joint 3: found -1, expected a number above 0"
    slip = page.locator("#tune").get_by_role("alert").filter(has_text=said)
    slip.wait_for()
    page.get_by_label("following error of joint 3").fill("0.2")
    page.keyboard.press("Tab")
    slip.wait_for(state="detached")  # it was about what stood there before
    page.get_by_role("button", name="Discard").click()
    page.get_by_role("tab", name="Gains").click()
    page.get_by_label("bandwidth, Hz").fill("-3")
    page.get_by_role("button", name="Show the difference").click()
    slip = page.locator("#tune").get_by_role("alert")
    slip.wait_for()
    assert slip.inner_text() == "Bandwidth: found -3.0, expected a number above 0"
    page.get_by_role("tab", name="Surroundings").click()
    page.get_by_role("button", name="Add a box").click()
    page.get_by_label("size of box 1").fill("1, 2")
    page.keyboard.press("Tab")
    page.get_by_text("box 1: size: expected three numbers").wait_for()
    page.get_by_role("button", name="Discard").click()
    page.get_by_text("No boxes.").wait_for()
    assert arm.tuning() == before
    assert visitor.errors == []
