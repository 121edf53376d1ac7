"""Any channel of any recording, over each other, with one cursor and one zoom."""

from __future__ import annotations

import time

import httpx
import numpy as np
import pytest
from browsers import DROP, until

from pa10d.services.library import open_library

ARM = "parseFloat(document.querySelector('#explore .arm-reading').textContent.slice(3))"
SEEN = """parseFloat([...document.querySelectorAll("#explore [role=status]")]
  .map((one) => one.textContent.split("Seen: ")[1]).find(Boolean) ?? "nan")"""
DRAWN = "!document.querySelector('#explore .chart[data-waiting]')"
LEGEND = "document.querySelector('#explore .u-legend .u-value').textContent"


def plotted(visitor):
    """Its page, once a recording is drawn."""
    visitor.open("explore")
    page = visitor.page
    page.get_by_text("Recordings", exact=True).click()
    page.get_by_label("train_a").check()
    page.keyboard.press("Escape")
    page.locator("#explore .chart canvas").nth(1).wait_for()
    until(page, DRAWN)
    return page


@pytest.fixture
def page(archive, visit):
    visitor = visit(archive[0])
    yield plotted(visitor)
    assert not visitor.errors
    assert not visitor.foreign()


def reading(page) -> str:
    return page.locator("#explore [role=status]", has_text="samples").inner_text()


def test_an_arm_that_comes_late_stands_where_the_cursor_is(archive, visit):
    """It stood at the beginning, "the arm at the cursor", until the cursor moved again."""
    visitor, late = visit(archive[0]), []
    visitor.page.route("**/*points=2400*", lambda route: late.append(route))
    page = plotted(visitor)
    box = page.locator("#explore .u-over").first.bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + 30)
    until(page, f"Math.abs(Number({LEGEND}) - 30) < 0.3")
    end = time.monotonic() + 30
    while not late:
        assert time.monotonic() < end, "nobody asks for the arm's motion"
        page.wait_for_timeout(50)
    late[0].continue_()
    until(page, f"Math.abs({ARM} - 30) < 0.3")
    assert not visitor.errors


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


@pytest.mark.long
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


@pytest.mark.long
def test_a_list_that_is_filled_again_leaves_the_keyboard_where_it_was(archive, visit):
    page, late = (visitor := visit(archive[0])).page, []
    page.route("**/faults*", lambda route: late.append(route))
    visitor.open("explore")
    page.get_by_text("Recordings", exact=True).click()
    page.get_by_label("train_a").check()
    first = "document.querySelector('#explore .choices input')"
    page.evaluate(f"{first}.dataset.old = 'yes'")
    late[0].continue_()
    until(page, f"!{first}.dataset.old")
    page.keyboard.press("Escape")
    assert page.locator("#explore details[open]").count() == 0
    assert not visitor.errors


def test_a_stretch_is_left_out_of_fits_and_used_again(page):
    leave = page.get_by_role("button", name="Leave this stretch out of fits")
    assert leave.is_disabled()
    page.get_by_role("button", name="Zoom in").click()
    page.locator("#explore [role=status]", has_text="Seen: 15.00 to 45.00").wait_for()
    leave.click()
    tag = page.locator("#explore .tag", has_text="train_a: 15.00 to 45.00 s left out")
    tag.wait_for()
    assert leave.is_disabled(), "it is left out already"
    tag.get_by_role("button").click()
    tag.wait_for(state="detached")
    assert leave.is_enabled()


def numbers(page) -> dict[str, list[str]]:
    """The table of what is drawn, by its rows."""
    rows = page.get_by_role("region", name="values that are drawn").locator("tbody tr")
    rows.first.wait_for()
    cells = [row.split("\t") for row in rows.all_inner_texts()]
    return {row[0]: row[1:] for row in cells}


@pytest.mark.long
def test_quantities_and_models_lie_over_each_other_in_one_plot(page):
    page.locator("#explore summary", has_text="Models").click()
    page.get_by_label("m0").check()
    page.keyboard.press("Escape")
    over = page.get_by_label("lay over plot 2")
    over.locator("option", has_text="model m0: torque").first.wait_for(state="attached")
    offered = over.locator("option").all_inner_texts()
    assert "model m0: residual" in offered
    assert "position" not in offered, "another unit"
    for name in ("model m0: torque", "model m0: residual"):
        over.select_option(name)
        page.locator("#explore .u-legend", has_text=f"1 S1, {name}").wait_for()
    second = page.locator("#explore .u-legend").nth(1)
    assert second.locator(".u-series").count() == 4  # time and three
    page.get_by_role("button", name="model m0: torque away from plot 2").press("Enter")
    until(page, "document.querySelectorAll('#explore .u-legend')[1].rows.length === 3")


@pytest.mark.long
def test_a_quantity_against_one_of_another_joint(page):
    with page.expect_response(lambda r: "columns" in r.url and "channel=tau1&channel=q2" in r.url):
        page.get_by_label("against").select_option("position of 2 S2")
    until(page, DRAWN)
    assert page.locator("#explore .plot .bad").all_inner_texts() == [""] * 2
    assert page.locator("#explore .u-over").count() == 2


@pytest.mark.long
def test_two_cursors_by_hand_and_by_keys_read_what_was_recorded(page, archive):
    first = page.locator("#explore .u-over").first
    box = first.bounding_box()
    page.mouse.click(box["x"] + box["width"] / 3, box["y"] + 40)
    page.keyboard.down("Shift")
    page.mouse.click(box["x"] + box["width"] / 2, box["y"] + 40)
    page.keyboard.up("Shift")
    a, b = (float(page.get_by_label(f"cursor {x}, s").input_value()) for x in "AB")
    assert (a, b) == (pytest.approx(20, abs=0.3), pytest.approx(30, abs=0.3))
    page.get_by_label("cursor A, s").fill("12")
    page.keyboard.press("Tab")
    page.get_by_label("cursor B, s").fill("14")
    page.keyboard.press("Tab")
    library = open_library(archive[1])
    run = library.runs.recording(library.runs.find("train_a"))
    q = np.interp([12.0, 14.0], run.t - run.t[0], run.q[:, 0])
    label = "position: 1 S1"
    until(page, f"[...document.querySelectorAll('#explore .numbers tbody tr')].some((row) => "
          f"row.cells[0].textContent === {label!r} && "
          f"Math.abs(Number(row.cells[3].textContent) - {q[1] - q[0]}) < 2e-3)")  # fmt: skip
    at_a, at_b, _, low, high, unit = numbers(page)[label]
    assert [float(at_a), float(at_b)] == pytest.approx(q, abs=2e-3)
    assert [float(low), float(high)] == pytest.approx(
        [run.q[:, 0].min(), run.q[:, 0].max()], rel=1e-3
    )
    assert unit == "rad"
    page.get_by_role("button", name="Zoom to A–B").press("Enter")
    page.locator("#explore [role=status]", has_text="Seen: 12.00 to 14.00").wait_for()
    page.get_by_role("button", name="Order spectrum").press("Enter")
    page.get_by_text("Order spectrum of torque measured, 12.00 to 14.00 s").wait_for()


@pytest.mark.long
def test_a_click_counts_though_its_plot_is_made_anew_under_the_button(page):
    box = page.locator("#explore .u-over").first.bounding_box()
    page.mouse.move(box["x"] + box["width"] / 3, box["y"] + 40)
    page.mouse.down()
    page.evaluate("document.querySelector('#explore .u-over').dataset.old = 'yes'")
    page.get_by_label("quantity of plot 1").select_option("velocity, differentiated")
    until(page, "!document.querySelector('#explore .u-over').dataset.old")
    page.mouse.up()
    assert float(page.get_by_label("cursor A, s").input_value()) == pytest.approx(20, abs=0.3)


@pytest.mark.long
def test_a_file_that_is_dropped_here_is_seen_here(archive, visit, csv_text):
    visitor = visit(archive[0])
    page = visitor.page
    visitor.open("explore")
    page.evaluate(DROP, csv_text)
    page.get_by_role("button", name="Import", exact=True).click()
    page.locator("#explore [role=status]", has_text="dropped: 500 samples").wait_for()
    page.locator("#explore .chart canvas").nth(1).wait_for()
    httpx.delete(f"{archive[0]}/api/v1/runs/dropped", trust_env=False).raise_for_status()
    assert not visitor.errors
