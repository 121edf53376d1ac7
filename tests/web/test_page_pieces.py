"""Small parts of the page, which are pressed and read while everything around them changes."""

from __future__ import annotations

import itertools
import json

import pytest
from browsers import until, until_known

PIECES = """async () => {
  const { el, renew, fill } = await import("/assets/any/base/dom.js");
  const { fixed } = await import("/assets/any/base/units.js");
  const { Scope } = await import("/assets/any/parts/scope.js");
  const button = (text) => el("button", { type: "button" }, text);
  const box = el("div", {}, button("Pause"), el("p", {}, "1 s"));
  document.body.append(box);
  const first = box.firstChild;
  first.focus();
  renew(box, button("Pause"), el("p", {}, "1 s"));
  const kept = box.firstChild === first;
  renew(box, button("Pause"), el("p", {}, "2 s"));
  const renewed = { same: kept, text: box.textContent, focus: document.activeElement.textContent };
  box.remove();

  const words = [], nothing = () => {};
  const pen = { beginPath: nothing, moveTo: nothing, lineTo: nothing, stroke: nothing,
    measureText: (word) => ({ width: 7 * word.length }),
    fillText(word, x, y) { words.push({ word, x, y, right: this.textAlign === "right" }); } };
  const states = ["enabling", "holding", "running", "holding", "disabling", "inactive"];
  const marks = states.map((word, k) => ({ time: 50 + k / 4, word }));
  marks.unshift({ time: 50, word: "the arm has stopped", bad: true });
  const area = { x: (t) => 5 * t, oldest: 0, right: 300, bottom: 200 };
  Scope.prototype.marks.call({}, pen, area, marks);
  const zeros = [fixed(-0.00001, 4), fixed(-0.5, 1), fixed(-0, 3)];
  const { formOf } = await import("/assets/any/parts/form.js");
  const form = formOf({ properties: { amplitude: { type: "number", default: Math.PI / 6 } } });
  const field = form.box.querySelector("input"), shown = field.value, same = form.read();
  field.value = "0.5";
  const asked = { shown, same, changed: form.read() };
  return { renewed, words, zeros, asked };
}"""


@pytest.mark.long
def test_a_button_stays_under_the_pointer_and_words_lie_on_no_other(archive, visit):
    visitor = visit(archive[0])
    visitor.open("models")
    found = visitor.page.evaluate(PIECES)
    assert found["renewed"] == {"same": True, "text": "Pause2 s", "focus": "Pause"}
    assert found["zeros"] == ["0.0000", "-0.5", "0.000"]
    assert found["asked"] == {"shown": "0.523599", "same": {}, "changed": {"amplitude": 0.5}}
    words = found["words"]
    assert words[0]["word"] == "the arm has stopped", "what is bad has its place first"
    assert len(words) >= 4
    for k, one in enumerate(words):
        for other in words[:k]:
            assert one["y"] != other["y"] or not overlap(one, other), (one, other)


def overlap(one: dict, other: dict) -> bool:
    """Of two words of one row, 7 px a letter."""
    (a, b), (c, d) = (
        (w["x"] - 7 * len(w["word"]), w["x"])
        if w["right"]
        else (w["x"], w["x"] + 7 * len(w["word"]))
        for w in (one, other)
    )
    return a < d and c < b


UNDER = """() => [...document.querySelectorAll("#run-detail .legendtext")].filter((key) => {
  const bar = document.querySelector("#run-detail .modebar");
  const a = key.getBoundingClientRect(), b = bar.getBoundingClientRect();
  return a.right > b.left && a.bottom > b.top && a.top < b.bottom;
}).map((key) => key.textContent)"""


@pytest.mark.long
def test_no_name_of_a_legend_lies_under_the_buttons(archive, visit):
    visitor = visit(archive[0], viewport={"width": 480, "height": 900}, has_touch=True)
    page = visitor.page
    visitor.open("runs")
    page.get_by_role("button", name="train_a").click()
    page.locator("#run-detail .legendtext").first.wait_for()
    visitor.until_answered()
    assert page.locator("#run-detail .legendtext").count() == 7
    assert page.evaluate(UNDER) == []


UPRIGHT = """async () => {
  const { ArmScene } = await import("/assets/any/parts/arm_scene.js");
  const { reach } = await import("/assets/any/base/kinematics.js");
  const shape = await (await fetch("/api/v1/robot/shape")).json(), scene = new ArmScene(shape, []);
  scene.resize(480, 340);
  scene.camera.updateMatrixWorld();
  const tip = scene.camera.position.clone().set(0, 0, reach(shape));
  return [tip.clone().project(scene.camera).y, tip.set(0, 0, 0).project(scene.camera).y];
}"""


@pytest.mark.long
def test_an_arm_that_stands_upright_is_in_the_picture_whole(archive, visit):
    visitor = visit(archive[0])
    visitor.open("models")
    top, foot = visitor.page.evaluate(UPRIGHT)
    assert 0.5 < top < 0.9
    assert -0.9 < foot < -0.3


STORY = """(day) => {
  const { change } = globalThis.pa10dModules.get("base/store.js");
  change({ story: { hides: true, day, hidden: null, since_the_night: null } });
  return document.querySelector("#models .guide").textContent;
}"""


@pytest.mark.long
def test_after_the_night_the_guide_asks_what_it_has_brought(archive, visit):
    visitor = visit(archive[0])
    visitor.open("models")
    page = visitor.page
    until_known(page)
    until(page, f"({STORY})(2).includes('It is day 2')")  # once control has begun
    assert "day 2" not in page.evaluate(STORY, 1)
    assert "Ask what has changed since m0" in page.evaluate(STORY, 2)
    page.locator("#models .guide a", has_text="Investigate").click()
    page.locator("#story", has_text="day 2").wait_for()
    asked = page.get_by_label("Ask").locator("option:checked")
    assert asked.inner_text() == "what has changed since m0?", "what the guide says to ask"
    assert page.get_by_role("button", name="Let a night pass").count() == 0
    assert not visitor.errors


def answer(body):
    """A route that is answered with this document."""
    text = json.dumps(body)
    return lambda route: route.fulfill(body=text, content_type="application/json")


TELL = """([state]) => {
  const { change } = globalThis.pa10dModules.get("base/store.js");
  change(state);
  return document.querySelector("section:not([hidden]) .guide").textContent;
}"""


def test_an_arm_that_is_being_connected_is_waited_for(archive, visit):
    """Not sent away to recordings for the first seconds."""
    page = visit(archive[0]).page
    robot = json.loads(page.request.get(f"{archive[0]}/api/v1/robot").text())
    robot |= {"offline_reason": "the control process is starting", "offline_passes": True}
    page.route("**/api/v1/robot", answer(robot))
    page.route("**/api/v1/robot/shape", lambda route: None)  # it, too, may take a while
    page.goto(archive[0])
    page.locator("#robot .guide", has_text="The arm is not there yet").wait_for()
    assert "some seconds" in page.locator("#robot .state-head").inner_text()
    assert "position, rad" in page.locator("#robot thead").inner_text(), "heads from the start"


@pytest.mark.long
def test_an_investigation_that_is_planned_is_the_next_step(archive, visit):
    visitor = visit(archive[0])
    visitor.open("models")
    until_known(visitor.page)
    planned = {"id": "x", "name": "investigation", "status": "waiting", "created": "2026-01-01"}
    said = visitor.page.evaluate(TELL, [{"investigations": [planned]}])
    assert "The investigation ‘investigation’ is planned; nothing has moved for it yet" in said


KNOWN = """async (known) => {
  const { notice } = globalThis.pa10dModules.get("base/notices.js");
  notice("m1 is fitted.", { known });
}"""


@pytest.mark.long
def test_much_to_know_lies_behind_one_line_until_it_is_closed(archive, visit):
    visitor = visit(archive[0])
    page = visitor.page
    page.clock.install()
    visitor.open("models")
    page.evaluate(KNOWN, ["one thing " * 40] * 9)
    message = page.locator(".notice", has_text="m1 is fitted.")
    assert message.bounding_box()["height"] < 120
    page.clock.fast_forward(6500)  # longer than other messages stay
    message.get_by_text("9 things to know of it").click()
    assert message.locator("li:visible").count() == 9
    message.get_by_label("Close this message").click()
    message.wait_for(state="detached")
    assert not visitor.errors


def test_what_the_fit_said_stands_with_its_model(archive, visit):
    visitor = visit(archive[0])
    page = visitor.page
    model = json.loads(page.request.get(f"{archive[0]}/api/v1/models/m0").text())
    page.route(f"**/api/v1/models/{model['id']}", answer({**model, "warnings": ["a bold fit"]}))
    visitor.open("models")
    page.locator("#models").get_by_text("1 thing to know of it").click()
    page.get_by_text("A bold fit.").wait_for()
    assert not visitor.errors


ADVICE = """async (advice) => {
  const { findingsList } = await import("/assets/any/parts/preview.js");
  const finding = { severity: "warning", sentence: "q reaches 68 rad", advice, mends: [] };
  return findingsList([finding]).textContent;
}"""


@pytest.mark.long
def test_advice_is_given_in_words_of_the_page(archive, visit):
    visitor = visit(archive[0])
    visitor.open("models")
    advice = "degrees: --map 'q{n}[deg]=q'; at the motor: --map 'q{n}[1/RATIO]=q' with the ratio"
    assert visitor.page.evaluate(ADVICE, advice).endswith(
        "degrees: unit deg for q…; at the motor: unit 1/RATIO for q… with the ratio "
    )


def test_without_an_arm_recordings_are_investigated(archive, visit):
    visitor = visit(archive[0])
    visitor.open("investigate")
    page = visitor.page
    until(page, "document.querySelector('#source').value === 'runs'")
    assert page.get_by_label("Minutes of motion, at most").is_hidden()
    page.get_by_label("From").select_option("arm")
    page.evaluate(TELL, [{"runs": []}])
    assert page.get_by_label("From").input_value() == "arm", "what somebody chose stays"
    assert not visitor.errors


UNMARKED = """() => {
  const { change, state } = globalThis.pa10dModules.get("base/store.js");
  const compared = { status: "succeeded", request: { model: "m0", runs: ["valid_a"] } };
  change({ runs: state.runs.map((run) => ({ ...run, tags: [] })), comparisons: [compared] });
}"""


@pytest.mark.long
def test_where_no_run_is_marked_those_of_the_model_are_chosen(archive, visit):
    visitor = visit(archive[0])
    visitor.open("diagnose")
    page = visitor.page
    page.evaluate(UNMARKED)
    pickers = page.locator("#diagnose summary")
    until(page, "document.querySelector('#diagnose summary b').textContent === 'train_a'")
    assert pickers.filter(has_text="Judge by").locator("b").text_content() == "valid_a"
    assert page.locator("#diagnose-start").is_enabled()
    assert not visitor.errors


BROKEN = """async () => {
  const { change, watch } = globalThis.pa10dModules.get("base/store.js");
  const heard = [];
  let first = true;
  watch(["tried"], () => { if (first) first = false; else throw new Error("broken"); });
  watch(["tried"], () => heard.push("after"));
  change({ tried: 1 });
  return heard;
}"""


def test_what_goes_wrong_in_one_place_keeps_nobody_else_from_knowing(archive, visit):
    visitor = visit(archive[0])
    visitor.open("models")
    assert visitor.page.evaluate(BROKEN) == ["after", "after"]
    assert any("broken" in error for error in visitor.errors), "and it is told"


PANELS = {
    "data": [
        {"x": [1, 2], "y": [1, 2], "name": "mean"},
        {"x": [1, 2], "y": [3, 4], "name": "mean", "xaxis": "x2", "yaxis": "y2"},
    ],
    "layout": {
        "height": 200,
        "meta": {"panels": {"q": "xaxis", "dq": "xaxis2"}},
        "xaxis": {"domain": [0, 0.45], "title": {"text": "position of joint 4, rad"}},
        "xaxis2": {"domain": [0.55, 1], "anchor": "y2", "title": {"text": "speed, rad/s"}},
        "yaxis": {"domain": [0, 1], "title": {"text": "residual, N·m"}},
        "yaxis2": {"domain": [0, 1], "anchor": "x2"},
    },
}
DRAW = """async (figures) => {
  const made = globalThis.pa10dModules.get("parts/figure.js").plot({ title: "Panels", figures });
  document.querySelector("#models").prepend(made);
  const canvas = made.querySelector(".canvas");
  await canvas.drawNow();
  const { xaxis, xaxis2, yaxis, yaxis2 } = canvas.layout;
  return { wide: [xaxis.domain, xaxis2.domain], high: [yaxis.domain, yaxis2.domain] };
}"""


@pytest.mark.long
@pytest.mark.by_default("1280")
@pytest.mark.parametrize(
    ("width", "wide", "high"),
    [
        (1280, [[0, 0.45], [0.55, 1]], [[0, 1], [0, 1]]),
        (390, [[0, 1], [0, 1]], [[0.5, 1], [0, 0.5]]),
    ],
)
def test_panels_stand_where_there_is_room_and_the_table_names_them(
    archive, visit, width, wide, high
):
    visitor = visit(archive[0], viewport={"width": width, "height": 844})
    visitor.open("models")
    page = visitor.page
    assert page.evaluate(DRAW, PANELS) == {"wide": wide, "high": high}
    page.locator("figure", has_text="Panels").get_by_text("The same in numbers").click()
    table = page.get_by_role("region", name="Panels in numbers").get_by_role("table")
    table.get_by_role("row").first.wait_for()
    rows = [one.inner_text().split("\t")[:2] for one in table.get_by_role("row").all()]
    assert [row[0] for row in rows] == ["against", "position of joint 4, rad", "speed, rad/s"]
    assert [row[1] for row in rows] == ["line", "mean", "mean"]
    assert not visitor.errors


BESIDE = {
    "data": PANELS["data"],
    "layout": {
        "height": 200,
        "margin": {"t": 30, "b": 20},
        "xaxis": {"domain": [0, 0.45]},
        "xaxis2": {"domain": [0.55, 1], "anchor": "y2"},
        "yaxis": {"title": {"text": "amplitude, N·m"}},
        "yaxis2": {"anchor": "x2", "title": {"text": "density, N·m/√Hz"}},
        "annotations": [
            {"text": "orders", "x": 0, "y": 1, "xref": "paper", "yref": "paper"},
            {"text": "hertz", "x": 0.55, "y": 1, "xref": "paper", "yref": "paper"},
        ],
    },
}
OVERLAP = """() => {
  const title = document.querySelector("#models .y2title").getBoundingClientRect();
  const first = document.querySelector("#models .draglayer .xy").getBoundingClientRect();
  return title.left < first.right && title.top < first.bottom && title.bottom > first.top;
}"""


@pytest.mark.long
@pytest.mark.parametrize("width", [pytest.param(1280, marks=pytest.mark.long), 390])
def test_the_title_of_a_second_panel_lies_on_no_other(archive, visit, width):
    visitor = visit(archive[0], viewport={"width": width, "height": 844})
    visitor.open("models")
    page = visitor.page
    page.evaluate(DRAW, BESIDE)
    assert page.evaluate(OVERLAP) is False
    boxes = [page.get_by_text(text, exact=True).bounding_box() for text in ("orders", "hertz")]
    below = boxes[1]["y"] - boxes[0]["y"]
    assert below > 150 if width == 390 else below == pytest.approx(0, abs=2)
    assert not visitor.errors


@pytest.mark.long
@pytest.mark.parametrize("width", [pytest.param(1024, marks=pytest.mark.long), 390])
def test_who_commands_is_to_be_read_beside_all_tabs(archive, visit, width):
    visitor = visit(archive[0], viewport={"width": width, "height": 844})
    page = visitor.page
    robot = json.loads(page.request.get(f"{archive[0]}/api/v1/robot").text())
    robot["lease"] |= {"holder": "browser-01b8fc"}
    page.route("**/api/v1/robot", answer(robot))
    visitor.open("runs")
    page.locator("#lease", has_text="browser-01b8fc commands").wait_for()
    shown, inside = (page.locator(one).bounding_box() for one in ("#lease", ".now"))
    brand, stop = (page.locator(one).bounding_box() for one in (".brand", "#stop"))
    assert shown["x"] >= max(inside["x"], brand["x"] + brand["width"])
    assert shown["x"] + shown["width"] <= stop["x"]
    for whole in ("#lease", "nav"):
        assert page.locator(whole).evaluate("one => one.scrollWidth <= one.clientWidth + 1")


TICKS = """async (far) => {
  const { Chart } = globalThis.pa10dModules.get("parts/chart.js");
  const chart = new Chart(200);
  document.querySelector("#explore").prepend(chart.box);
  await chart.lines({ tables: [[[0, 1, 2], [0, far, 0]]], series: [{ label: "one", color: "red" }],
                      x: "time, s", y: "rad", span: null });
  await new Promise(requestAnimationFrame);
  return chart.plot.axes[1]._values.filter(Boolean).map(Number);
}"""


@pytest.mark.long
@pytest.mark.parametrize("far", [pytest.param(0.005, marks=pytest.mark.long), 20_000.0])
def test_numbers_beside_a_plot_are_those_of_their_lines(archive, visit, far):
    visitor = visit(archive[0])
    visitor.open("explore")
    told = visitor.page.evaluate(TICKS, far)
    steps = {round(b - a, 9) for a, b in itertools.pairwise(told)}
    assert len(told) > 2
    assert len(steps) == 1, told
