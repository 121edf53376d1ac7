"""The model that the page speaks of is the one that it shows, asks about, exports and loads."""

from __future__ import annotations

import dataclasses
import json
import shutil

import pytest
from benches import served

from pa10d.model import Delivery
from pa10d.services.library import open_library

FINDINGS = [
    {"effect": "stribeck", "joints": [4], "next_experiment": None, "confounded_with": []},
    {"effect": "backlash", "joints": [2], "next_experiment": None, "confounded_with": []},
]
DELIVERY = Delivery(
    before=(1.0,) * 7, promised=(*[1.0] * 6, 0.2), achieved=(*[1.0] * 5, 1.5, 0.25),
    worse=(6,), cutoff_hz=10.0, mask="all",
)  # fmt: skip
SEARCH = {
    "id": "20260101-000000000-abcdef", "kind": "diagnose", "status": "succeeded", "progress": 1,
    "message": "done", "error": None, "created": "2026-01-01T00:00:00+00:00", "started": None,
    "finished": "2026-01-01T00:00:00+00:00",
    "request": {"model": "m0", "fit": ["train_a"], "validate": ["valid_a"], "frozen": False},
}  # fmt: skip


@pytest.fixture(scope="module")
def served_copy(archive, tmp_path_factory):
    """A daemon of its own, whose models no other file's tests see: its address and library."""
    folder = tmp_path_factory.mktemp("versions")
    data = folder / "data"
    shutil.copytree(archive[1], data, ignore=shutil.ignore_patterns("daemon*", "*.lock", "jobs"))
    with served(data, f"void-{folder.name}") as url:
        yield url, open_library(data)


@pytest.fixture
def versions(served_copy):
    """A daemon with m0, and m1, in which the first of two findings was added."""
    _, library = served_copy
    for later in ("m2", "m1"):
        if later in [info.name for info in library.models.all()]:
            library.models.delete(later)
    _add(library, "m1", "m0", FINDINGS[0])
    return served_copy


def _add(library, name, parent, finding):
    older = library.models.load(library.models.find(parent))
    change = f"added {finding['effect']} J{finding['joints'][0]}"
    notes = dataclasses.replace(older.notes, delivery=DELIVERY)
    library.models.save(
        dataclasses.replace(older, name=name, parent=parent, change=change, notes=notes)
    )


def _searched(page):
    """A search of m0 that found two things, as the daemon would tell of it."""

    def answer(route):
        whole = {
            **SEARCH,
            "result": {"verdict": "missing", "findings": FINDINGS, "unexplained": []},
        }
        listed = {"total": 1, "next": None, "items": [SEARCH]}
        inside = "/diagnoses/" in route.request.url
        route.fulfill(body=json.dumps(whole if inside else listed), content_type="application/json")

    page.route("**/api/v1/diagnoses*", answer)
    page.route(f"**/api/v1/diagnoses/{SEARCH['id']}", answer)


@pytest.mark.long
def test_what_was_found_and_not_added_comes_before_a_new_search(versions, visit):
    url, library = versions
    visitor = visit(url)
    page = visitor.page
    _searched(page)
    visitor.open("robot")
    guide = page.locator("#robot .guide")
    guide.get_by_text("backlash in joint 2 is not in m1 yet").wait_for()
    assert guide.locator("a").get_attribute("href") == f"#/diagnose/{SEARCH['id']}"
    _add(library, "m2", "m1", FINDINGS[1])
    page.reload()
    guide.get_by_text("m2 has what was missing").wait_for()
    guide.locator("a").click()
    page.locator("#models h2", has_text="m2").first.wait_for()
    page.locator("#models .guide a", has_text="Diagnose").click()
    assert page.locator("#diagnose").get_by_label("Model").input_value() == "m2"
    assert not visitor.errors


@pytest.mark.long
def test_a_version_that_is_clicked_is_the_one_that_is_shown_and_exported(versions, visit):
    visitor = visit(versions[0])
    page = visitor.page
    visitor.open("models")
    title = page.locator("#models .panel h2").nth(1)
    for name in ("m1", "m0", "m1"):
        page.click(f"#models [data-model={name}]")
        page.locator(f"#models [data-model={name}][aria-selected=true]").wait_for()
        assert title.text_content().split()[0] == name
        with page.expect_request("**/export?*") as asked, page.expect_download() as given:
            page.get_by_role("button", name="PYTHON").click()
        assert given.value.suggested_filename == f"{name}.py"
        found = versions[1].models.find(name).id
        assert found in asked.value.url
    assert not visitor.errors


@pytest.mark.long
def test_what_was_promised_stands_beside_what_came_and_can_be_undone(versions, visit):
    visitor = visit(versions[0])
    page = visitor.page
    visitor.open("models")
    page.locator("#models h2", has_text="Promised and achieved").wait_for()
    rows = page.locator("#models details", has_text="Promised and achieved").locator("tbody tr")
    sixth, seventh = rows.nth(5).inner_text(), rows.nth(6).inner_text()
    assert sixth.split("\t")[1:] == ["1", "1", "1.5", "N·m", "worse than before"]
    assert seventh.split("\t")[1:] == ["1", "0.2", "0.25", "N·m", "fell"]
    said = "RMS error on the runs that the search judged by; low-pass 10 Hz, all. Compare has"
    assert page.get_by_text(said).is_visible()
    page.get_by_text("RMS error on valid_a; low-pass").first.wait_for()
    assert (
        "clear of reversals"
        in page.get_by_text("RMS error on valid_a; low-pass").first.inner_text()
    )
    page.get_by_role("button", name="Undo: back to m0").click()
    page.get_by_role("dialog").get_by_role("button", name="Undo").click()
    page.locator("[data-model=m1]").wait_for(state="detached")
    assert [info.name for info in versions[1].models.all()] == ["m0"]
    assert page.locator("#models .panel h2").nth(1).text_content().split()[0] == "m0"
    assert page.locator(".undo:visible").count() == 0
    assert not visitor.errors


@pytest.mark.long
def test_a_rotor_in_a_base_parameter_puts_no_doubt_in_its_value(versions, visit):
    """It was drawn as those that are weak or not determined."""
    visitor = visit(versions[0])
    page = visitor.page
    visitor.open("models")
    rows = page.locator("#models .parameters tbody tr")
    only_rotor = rows.filter(
        has=page.get_by_text("with a rotor, of which the URDF says nothing", exact=True)
    )
    only_rotor.first.wait_for()
    assert only_rotor.locator("xpath=self::*[contains(@class, 'doubtful')]").count() == 0
    weak = rows.filter(has=page.get_by_text("weak", exact=True))
    assert weak.count() == weak.locator("xpath=self::*[contains(@class, 'doubtful')]").count() > 0


def answered(body: str):
    return lambda route: route.fulfill(body=body, content_type="application/json")


@pytest.mark.long
def test_each_finding_can_be_seen_on_the_arm_alone(versions, visit):
    url, _ = versions
    visitor = visit(url)
    page = visitor.page
    _searched(page)
    text = {"block": "text", "text": "…", "muted": False}
    finding = {"mark": "", "blocks": [text] * 3}
    sheet = {
        "sections": [{"block": "section", "title": "Verdict", "blocks": [text]}],
        "findings": [
            {**finding, "title": "Stribeck friction in joint 4"},
            {**finding, "title": "Backlash in joint 2"},
        ],
        "unexplained": [],
    }
    whole = {**SEARCH, "result": {"verdict": "missing", "findings": FINDINGS, "unexplained": []}}
    for address, document in ((f"diagnoses/{SEARCH['id']}/sheet", sheet), ("jobs/2026*", whole)):
        page.route(f"**/api/v1/{address}", answered(json.dumps(document)))
    visitor.open("diagnose")
    view = page.locator("#diagnose figure.arm")
    view.get_by_text("All findings: joint 4, 2.").wait_for()
    view.get_by_role("button", name="Backlash in joint 2").click()
    view.get_by_text("Backlash in joint 2: joint 2.").wait_for()
    assert view.locator("[aria-pressed=true]").all_inner_texts() == ["Backlash in joint 2"]
    assert not visitor.errors
