"""Any channel of any recording, over each other, with one cursor and one zoom."""

from __future__ import annotations

import pytest
from browsers import until

ARM = "parseFloat(document.querySelector('#explore .arm-reading').textContent.slice(3))"
SEEN = """parseFloat([...document.querySelectorAll("#explore [role=status]")]
  .map((one) => one.textContent.split("Seen: ")[1]).find(Boolean) ?? "nan")"""
LEGEND = "document.querySelector('#explore .u-legend .u-value').textContent"


@pytest.fixture
def page(archive, visit):
    visitor = visit(archive[0])
    visitor.open("explore")
    page = visitor.page
    page.get_by_text("Recordings", exact=True).click()
    page.get_by_label("train_a").check()
    page.keyboard.press("Escape")
    page.locator("#explore .chart canvas").nth(1).wait_for()
    yield page
    assert not visitor.errors
    assert not visitor.foreign()


def reading(page) -> str:
    return page.locator("#explore [role=status]", has_text="samples").inner_text()


def test_one_zoom_and_one_cursor_for_all_plots(page):
    first, second = (page.locator("#explore .u-over").nth(k) for k in (0, 1))
    box = first.bounding_box()
    y = box["y"] + 30
    page.mouse.move(box["x"] + box["width"] / 2, y)
    values = page.locator("#explore .u-legend tr:first-child .u-value")
    assert values.nth(0).inner_text() == values.nth(1).inner_text()
    assert float(values.nth(1).inner_text()) == pytest.approx(30.0, abs=0.3)
    until(page, f"Math.abs({ARM} - 30) < 0.3")
    page.mouse.move(box["x"] + box["width"] / 3, y)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] / 2, y, steps=4)
    page.mouse.up()
    until(page, f"Math.abs({SEEN} - 20) < 0.3")
    second.scroll_into_view_if_needed()
    other = second.bounding_box()
    page.mouse.move(other["x"] + other["width"] / 2, other["y"] + 30)
    until(page, f"Math.abs(Number({LEGEND}) - 25) < 0.2")
    page.get_by_role("button", name="Whole").click()
    page.locator("#explore [role=status]", has_text="Drag over a plot").wait_for()


def test_models_and_a_second_run_lie_over_it(page):
    page.get_by_text("Recordings", exact=True).click()
    page.get_by_label("valid_a").check()
    page.keyboard.press("Escape")
    page.locator("#explore summary", has_text="Models").click()
    page.get_by_label("m0").check()
    page.keyboard.press("Escape")
    page.get_by_label("quantity of plot 2").select_option("model m0: torque of coulomb")
    page.locator("#explore .u-legend", has_text="1 S1, valid_a").nth(1).wait_for()
    page.get_by_label("against").select_option("velocity, differentiated")
    page.locator("#explore .u-axis").first.wait_for()
    assert page.locator("#explore .plot .bad").all_inner_texts() == [""] * 2
    page.get_by_label("against").select_option("time")
    page.get_by_role("button", name="Spectrum", exact=True).click()
    page.get_by_text("Spectrum of model m0: torque of coulomb").wait_for()


def test_a_stretch_is_left_out_of_fits_and_used_again(page):
    leave = page.get_by_role("button", name="Leave this stretch out of fits")
    assert leave.is_disabled()
    page.get_by_role("button", name="Zoom in").click()
    page.locator("#explore [role=status]", has_text="Seen: 15.00 to 45.00").wait_for()
    leave.click()
    tag = page.locator("#explore .tag", has_text="train_a: 15.00 to 45.00 s left out")
    tag.wait_for()
    tag.get_by_role("button").click()
    tag.wait_for(state="detached")
