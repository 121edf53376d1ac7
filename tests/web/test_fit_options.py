"""How a model is fitted, said on the page: terms, cut-off, runs, stretches, priors."""

from __future__ import annotations

import json

import pytest

from pa10d.client import Client


def test_what_is_chosen_is_what_is_asked_for(archive, visit):
    visitor = visit(archive[0])
    page = visitor.page
    visitor.open("models")
    fit = page.locator("#fit-start")
    fit.wait_for()
    page.locator("#models summary", has_text="Options").click()
    page.get_by_label("cut-off").fill("8")
    page.get_by_label("bodies as in the URDF within").fill("30")
    page.get_by_label("parameters you know").fill("Fc3 = 12 ± 2\nlink J7: m = 1.5 +- 1 %\n")
    page.get_by_label("only faster than").fill("0.1")
    page.get_by_text("Further terms").click()
    page.get_by_role("checkbox", name="Torque offset").check()
    assert page.get_by_role("checkbox", name="Coulomb friction", exact=True).count() == 0
    page.keyboard.press("Escape")
    for begin, end in (("20", "10"), ("10", "20"), ("30.5", "31")):
        page.get_by_label("from, s").fill(begin)
        page.get_by_label("to, s", exact=True).fill(end)
        page.get_by_role("button", name="Leave it out").click()
    page.locator(".notice.error", has_text="expected two times from 0 to").wait_for()
    left = page.get_by_role("list", name="left out of this fit")
    assert left.get_by_role("listitem").count() == 2
    page.get_by_role("button", name="use train_a: 30.50 to 31.00 s after all").click()

    asked = {}

    def answer(route):
        asked.update(json.loads(route.request.post_data))
        route.fulfill(status=409, body=json.dumps({"detail": "enough"}))

    page.route("**/api/v1/models", answer)
    fit.click()
    page.locator(".notice.error", has_text="enough").wait_for()
    with Client(archive[0]) as client:
        (run,) = [run["id"] for run in client.runs() if run["name"] == "train_a"]
    assert asked == {
        "runs": [run], "name": "m1", "cutoff": 8, "with_effects": ["torque_offset"], "prior": 30,
        "given": ["Fc3 = 12 ± 2", "link J7: m = 1.5 +- 1 %"],
        "faster_than": [0.1], "left_out": [{"run": run, "begin": 10, "end": 20}],
    }  # fmt: skip
    assert not [one for one in visitor.errors if "409" not in one]


@pytest.mark.long
def test_no_run_no_fit_and_one_that_is_ticked_is_enough(archive, visit):
    page = (visitor := visit(archive[0])).page
    visitor.open("models")
    start = page.locator("#fit-start")
    page.locator("#models .picker.runs summary", has_text="Fit to").click()
    page.locator("#models").get_by_label("train_a").first.uncheck()
    assert start.is_disabled()
    page.locator("#models").get_by_label("valid_a").first.check()
    assert start.is_enabled()
    assert not visitor.errors


@pytest.mark.long
def test_parameters_are_sorted_by_what_is_pressed(archive, visit):
    page = (visitor := visit(archive[0])).page
    visitor.open("models")
    table = page.get_by_role("region", name="parameters")
    rows = table.locator("tbody tr")
    rows.first.wait_for()

    def column(k: int) -> list[str]:
        return [row.split("\t")[k] for row in rows.all_inner_texts()]

    heads = table.get_by_role("columnheader").all_inner_texts()
    assert heads[:6] == ["parameter", "value", "± standard error", "error, % of value",
                         "95 % interval", "URDF"]  # fmt: skip
    table.get_by_role("button", name="parameter").press("Enter")
    assert column(0) == sorted(column(0))
    for way in (1, -1):
        table.get_by_role("button", name="± standard error").press("Enter")
        errors = [float(cell) for cell in column(2) if cell != "–"]
        assert errors == sorted(errors)[::way]
    sorted_by = table.locator("th[aria-sort]")
    assert (sorted_by.count(), sorted_by.get_attribute("aria-sort")) == (1, "descending")
    assert any(cell not in ("–", "") for cell in column(5)), "the URDF's value beside it"
    page.get_by_label("show what each is made of").check()
    table.locator("th small, td small", has_text=" + ").first.wait_for()
    assert not visitor.errors
