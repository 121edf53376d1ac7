"""Everyone can use it: axe finds nothing, tabs go by arrows, STOP lies on top of everything."""

from __future__ import annotations

import gzip
from pathlib import Path

import pytest

AXE = gzip.decompress((Path(__file__).parent / "vendor/axe.min.js.gz").read_bytes()).decode()
SECTIONS = ("robot", "investigate", "experiments", "tune", "runs", "explore")
SECTIONS += ("compare", "diagnose", "models")
RULES = {
    "runOnly": {
        "type": "tag",
        "values": ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "best-practice"],
    }
}


def broken_rules(page) -> list[str]:
    """Every rule that an element breaks, one line each."""
    found = page.evaluate("(rules) => axe.run(document, rules)", RULES)
    return [
        f"{rule['id']} ({rule['impact']}): {node['html'][:160]}"
        for rule in found["violations"]
        for node in rule["nodes"][:3]
    ]


@pytest.mark.parametrize(("scheme", "width"), [("light", 1440), ("dark", 390)])
def test_axe_finds_nothing(archive, visit, scheme, width):
    size = {"width": width, "height": 900}
    visitor = visit(archive[0], color_scheme=scheme, viewport=size, bypass_csp=True)
    page = visitor.page
    wrong = {}
    for section in SECTIONS:
        visitor.open(section)
        if section == "runs":
            page.get_by_role("button", name="train_a").click()
            page.locator("#run-detail .main-svg").first.wait_for()
        visitor.until_answered()
        if not page.evaluate("'axe' in window"):
            page.evaluate(AXE)
        if lines := broken_rules(page):
            wrong[section] = lines
    assert not wrong, "\n".join(
        f"{name}: {line}" for name, lines in wrong.items() for line in lines
    )


FIRST_LIGHT = 60_000, 20  # bytes and requests: 1.2 s at 400 kbit/s, and few rounds


def test_a_slow_link_carries_little_before_a_section_stands(archive, visit):
    visitor = visit(archive[0])
    network = visitor.context.new_cdp_session(visitor.page)
    network.send("Network.enable")
    carried = []
    network.on("Network.loadingFinished", lambda end: carried.append(end["encodedDataLength"]))
    visitor.open("explore")
    assert sum(carried) < FIRST_LIGHT[0]
    assert len(carried) < FIRST_LIGHT[1]


def test_with_text_twice_as_large_the_numbers_of_a_list_stay_in_their_panel(archive, visit):
    visitor = visit(archive[0], viewport={"width": 1280, "height": 900}, bypass_csp=True)
    page = visitor.page
    visitor.open("experiments")
    page.locator(".set li").first.wait_for()
    page.evaluate("document.documentElement.style.fontSize = '200%'")
    room, needed = page.evaluate("""() => {
      const list = document.querySelector(".set"), style = getComputedStyle(list);
      const pen = document.createElement("canvas").getContext("2d");
      pen.font = style.font;
      return [parseFloat(style.paddingLeft), pen.measureText("5. ").width];
    }""")
    assert room >= needed


def test_tabs_go_by_arrow_keys(archive, visit):
    visitor = visit(archive[0])
    page = visitor.page
    visitor.open("experiments")
    page.locator("[role=tab][aria-selected=true]").focus()
    chosen = "document.querySelector('#experiments [role=tab][aria-selected=true]')"
    before = page.evaluate(f"{chosen}.dataset.kind")
    page.keyboard.press("ArrowDown")
    after = page.evaluate(f"{chosen}.dataset.kind")
    assert after != before
    assert page.evaluate(f"document.activeElement === {chosen}")
    assert page.locator("#experiments [role=tab][tabindex='0']").count() == 1
    page.keyboard.press("End")
    assert page.evaluate(f"{chosen} === {chosen}.parentElement.lastElementChild")
    page.keyboard.press("Home")
    assert page.evaluate(f"{chosen} === {chosen}.parentElement.firstElementChild")


@pytest.mark.parametrize("width", [390, 1440])
def test_stop_lies_on_top_of_everything_everywhere(archive, visit, width):
    visitor = visit(archive[0], viewport={"width": width, "height": 800})
    page = visitor.page
    for section in SECTIONS:
        visitor.open(section)
        for down in (0, 500):
            page.evaluate("(down) => scrollBy(0, down)", down)
            box = page.locator("#stop").bounding_box()
            for x, y in ((0.1, 0.2), (0.5, 0.5), (0.9, 0.8)):
                at = [box["x"] + x * box["width"], box["y"] + y * box["height"]]
                assert page.evaluate("([x, y]) => document.elementFromPoint(x, y).id", at) == "stop"
