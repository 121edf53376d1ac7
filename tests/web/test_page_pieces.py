"""Small parts of the page, which are pressed and read while everything around them changes."""

from __future__ import annotations

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


def test_after_the_night_the_guide_asks_what_it_has_brought(archive, visit):
    visitor = visit(archive[0])
    visitor.open("models")
    page = visitor.page
    assert "day 2" not in page.evaluate(STORY, 1)
    told = page.evaluate(STORY, 2)
    assert "It is day 2" in told
    assert "Ask what has changed since m0" in told
    page.locator("#models .guide a", has_text="Investigate").click()
    page.locator("#story", has_text="day 2").wait_for()
    assert page.get_by_role("button", name="Let a night pass").count() == 0
    assert not visitor.errors
