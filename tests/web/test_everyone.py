"""Everyone can use it: axe finds nothing, tabs go by arrows, STOP lies on top of everything."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np
import pytest
from browsers import DROP, until

from pa10d.figures.evidence import evidence

AXE = gzip.decompress((Path(__file__).parent / "vendor/axe.min.js.gz").read_bytes()).decode()
SECTIONS = ("robot", "investigate", "experiments", "tune", "runs", "explore")
SECTIONS += ("compare", "diagnose", "models")
RULES = {
    "runOnly": {
        "type": "tag",
        "values": ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "best-practice"],
    }
}


COLOURED = ("robot", "runs", "models")  # lights, plots and tables: all inks and papers there are
CONTRAST = {"runOnly": {"type": "rule", "values": ["color-contrast"]}}


def broken_rules(page, rules=RULES) -> list[str]:
    """Every rule that an element breaks, one line each."""
    found = page.evaluate("(rules) => axe.run(document, rules)", rules)
    return [
        f"{rule['id']} ({rule['impact']}): {node['html'][:160]}"
        for rule in found["violations"]
        for node in rule["nodes"][:3]
    ]


@pytest.mark.parametrize(
    ("scheme", "width", "also", "sections"),
    [
        ("dark", 390, "light", COLOURED),
        pytest.param("dark", 390, "light", SECTIONS, marks=pytest.mark.long),
        pytest.param("light", 1440, None, SECTIONS, marks=pytest.mark.long),
    ],
    ids=["dark", "dark everywhere", "light everywhere"],
)
def test_axe_finds_nothing(archive, visit, scheme, width, also, sections):
    """Of another scheme, what depends on it: contrasts."""
    size = {"width": width, "height": 900}
    visitor = visit(archive[0], color_scheme=scheme, viewport=size, bypass_csp=True)
    page = visitor.page
    wrong = {}
    for section in sections:
        visitor.open(section)
        if section == "runs":
            page.get_by_role("button", name="train_a").click()
            page.locator("#run-detail .main-svg").first.wait_for()
        visitor.until_answered()
        if not page.evaluate("'axe' in window"):
            page.evaluate(AXE)
        lines = broken_rules(page)
        if also and section in COLOURED:
            page.emulate_media(color_scheme=also)
            lines += broken_rules(page, CONTRAST)
            page.emulate_media(color_scheme=scheme)
        if lines:
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


@pytest.mark.long
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


def test_with_text_twice_as_large_every_section_and_stop_are_in_sight(archive, visit):
    visitor = visit(archive[0], bypass_csp=True)
    page = visitor.page
    visitor.open("runs")
    page.evaluate("document.documentElement.style.fontSize = '200%'")
    hidden = """() => [...document.querySelectorAll("nav a, #stop")].filter((one) => {
      const box = one.getBoundingClientRect();
      return [0.1, 0.9].some((x) => !one.contains(
        document.elementFromPoint(box.left + x * box.width, box.top + box.height / 2)));
    }).map((one) => one.textContent)"""
    until(page, f"!({hidden})().length")
    until(
        page,
        "document.documentElement.style.getPropertyValue('--head') === `${header.offsetHeight}px`",
    )


@pytest.mark.long
@pytest.mark.parametrize(
    ("size", "letters"), [pytest.param("100%", 12, marks=pytest.mark.long), ("200%", 24)]
)
def test_letters_of_plots_grow_with_the_text(archive, visit, size, letters):
    visitor = visit(archive[0], bypass_csp=True)
    page = visitor.page
    visitor.open("runs")
    page.evaluate("(size) => { document.documentElement.style.fontSize = size; }", size)
    page.get_by_role("button", name="train_a").click()
    tick = page.locator("#run-detail .main-svg .xtick text").first
    tick.wait_for()
    assert tick.evaluate("(one) => getComputedStyle(one).fontSize") == f"{letters}px"
    fits = """() => [...document.querySelectorAll("#run-detail .canvas")].every((one) =>
      one.querySelector(".main-svg").getBoundingClientRect().height <= one.clientHeight + 1)"""
    assert page.evaluate(fits)


def test_messages_are_closed_by_keyboard_and_one_is_back_where_one_was(archive, visit):
    visitor = visit(archive[0], bypass_csp=True)
    page = visitor.page
    visitor.open("explore")
    page.locator("#explore summary").first.focus()
    page.evaluate("""() => {
      const { notice } = globalThis.pa10dModules.get("base/notices.js");
      for (let k = 0; k < 5; k += 1) notice(`Number ${k} went wrong.`, { kind: "error" });
    }""")
    page.get_by_label("Close this message").last.focus()
    for left in (4, 3, 2, 1, 0):
        page.keyboard.press("Enter")
        assert page.locator("#notices .notice").count() == left
    assert page.evaluate("document.activeElement.matches('#explore summary')")


@pytest.mark.long
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


@pytest.mark.parametrize("width", [390, pytest.param(1440, marks=pytest.mark.long)])
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


@pytest.mark.long
def test_evidence_stands_under_each_other_on_a_phone(archive, visit):
    visitor = visit(archive[0], viewport={"width": 390, "height": 800}, bypass_csp=True)
    page = visitor.page
    visitor.open("runs")
    page.get_by_role("button", name="train_a").click()
    page.locator("#run-detail .main-svg").first.wait_for()
    x = np.linspace(-1.0, 1.0, 200)
    shown = evidence(x, "velocity of joint 4, rad/s", np.sign(x), 0.1 * np.cos(x), np.sign(x))
    panels = page.evaluate(
        """async (figure) => {
          const box = document.querySelector("#run-detail .canvas");
          await pa10dPlots.draw(box, figure);
          const size = box._fullLayout;
          return [size.xaxis, size.xaxis2].map((axis) => axis._length / box.clientWidth)
            .concat([size.yaxis.domain, size.yaxis2.domain], size.yaxis2.title.text);
        }""",
        shown,
    )
    left, right, upper, lower, title = panels
    assert left > 0.6
    assert right > 0.6
    assert upper[0] > lower[1]
    assert title == "held-out residual, N·m"


@pytest.mark.long
def test_the_gains_of_a_joint_are_all_seen_on_a_phone(archive, visit):
    visitor = visit(archive[0], viewport={"width": 390, "height": 800})
    visitor.open("tune")
    table = visitor.page.get_by_role("region", name="Gains", exact=True)
    table.locator("tbody tr").first.wait_for()
    assert table.locator("thead th").count() == 4
    assert table.evaluate("(box) => box.scrollWidth - box.clientWidth") <= 0


@pytest.mark.long
@pytest.mark.parametrize("scheme", ["light", pytest.param("dark", marks=pytest.mark.long)])
def test_a_table_that_goes_on_beyond_its_box_shows_it(archive, visit, scheme):
    """Another edge than that of a table which ends there: a shadow, until it is scrolled away."""
    visitor = visit(
        archive[0], viewport={"width": 390, "height": 800}, color_scheme=scheme, bypass_csp=True
    )
    visitor.open("models")
    table = visitor.page.get_by_role("region", name="parameters", exact=True)
    table.locator("tbody tr").first.wait_for()
    table.evaluate("(box) => box.scrollIntoView({ block: 'center' })")
    hidden = table.evaluate("(box) => box.scrollWidth - box.clientWidth")
    assert hidden > 20

    def edge() -> bytes:
        box = table.bounding_box()
        clip = {
            "x": box["x"] + box["width"] - 5,
            "y": max(box["y"] + 3, 300),
            "width": 4,
            "height": 4,
        }
        return visitor.page.screenshot(clip=clip)

    before = edge()
    table.evaluate("(box) => { box.scrollLeft = box.scrollWidth; }")
    assert edge() != before
    card = "getComputedStyle(document.getElementById('header')).backgroundColor"
    plain = visitor.page.evaluate(card)
    table.evaluate("(box, plain) => { box.style.background = plain; }", plain)
    ended = edge()
    table.evaluate("(box) => { box.style.background = ''; }")
    assert edge() == ended


@pytest.mark.long
def test_a_plot_is_there_in_numbers_too(archive, visit):
    visitor = visit(archive[0])
    page = visitor.page
    visitor.open("compare")
    page.locator("#compare-start:enabled").click()
    plot = page.locator("#compare figure.plot", has_text="Measured, modelled").first
    plot.locator(".main-svg").first.wait_for()
    plot.get_by_text("The same in numbers").click()
    table = plot.get_by_role("region", name="in numbers").get_by_role("table")
    table.wait_for()
    heads = table.get_by_role("columnheader").all_inner_texts()
    assert heads == ["line", "points", "first", "last", "least", "greatest"]
    rows = table.get_by_role("rowheader").all_inner_texts()
    assert {"measured", "model"} <= {row.lower() for row in rows}, rows
    shown = plot.locator(".canvas").first.evaluate("""(canvas) => {
      const [one] = canvas._fullData.filter((trace) => trace.visible === true);
      return [one.name, Math.max(...one.y.filter(Number.isFinite))];
    }""")
    row = table.get_by_role("row").filter(has_text=shown[0]).first
    most = float(row.get_by_role("cell").last.inner_text().split(" at ")[0])
    assert most == pytest.approx(shown[1], rel=1e-3)
    assert not visitor.errors


def test_two_tabs_know_the_same(archive, visit, csv_text):
    first, second = visit(archive[0]), visit(archive[0])
    second.open("runs")
    first.open("runs")
    first.page.evaluate(DROP, csv_text)
    first.page.get_by_role("button", name="Import", exact=True).click()
    told = second.page.locator("#runs tbody tr", has_text="dropped")
    told.wait_for()
    first.page.get_by_label("dropped: fit").check()
    second.page.locator("[aria-label='dropped: fit']:checked").wait_for()
    first.page.get_by_role("button", name="dropped").click()
    first.page.get_by_role("button", name="Delete", exact=True).click()
    first.page.get_by_role("button", name="Delete for good").click()
    told.wait_for(state="detached")
    assert not first.errors
    assert not second.errors
