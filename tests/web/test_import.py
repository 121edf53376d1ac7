"""A file that is dropped onto the page is shown first: understood, corrected, imported, or left."""

from __future__ import annotations

import base64
import io
import re

import httpx
import numpy as np
import pytest
from browsers import until
from test_everyone import AXE, broken_rules

DROP = """async ([name, text]) => {
  const data = new DataTransfer();
  for (const one of [].concat(name)) data.items.add(new File([text], one));
  const drop = new DragEvent("drop", { dataTransfer: data, bubbles: true });
  document.querySelector(".drop").dispatchEvent(drop);
}"""


BYTES = """([name, text]) => {
  const data = new DataTransfer();
  data.items.add(new File([Uint8Array.from(atob(text), (c) => c.charCodeAt(0))], name));
  const drop = new DragEvent("drop", { dataTransfer: data, bubbles: true });
  document.querySelector(".drop").dispatchEvent(drop);
}"""


CUT = """(arrow) => [...document.querySelectorAll(".preview select")].filter((box) => {
  const pen = document.createElement("canvas").getContext("2d"), style = getComputedStyle(box);
  pen.font = style.font;
  const room = box.clientWidth - parseFloat(style.paddingLeft) - parseFloat(style.paddingRight);
  return pen.measureText(box.selectedOptions[0].text).width > room - arrow;
}).map((box) => box.selectedOptions[0].text)"""


@pytest.fixture(scope="module")
def strange() -> str:
    """A logger's own names: ms, degrees that its columns do not name, a commanded torque."""
    t = np.arange(2000) / 200.0
    phase = t[:, None] * np.linspace(1.5, 3.0, 7)
    q = 60.0 * np.sin(phase)
    names = ["stamp", *(f"axis_{j}_pos" for j in range(1, 8))]
    names += [*(f"axis_{j}_torque_cmd" for j in range(1, 8)), *(f"trq{j}" for j in range(1, 8))]
    tau = 5.0 * np.sin(phase) + 0.4 * np.cos(phase)
    speeds = np.radians(np.gradient(q, t, axis=0))  # in rad/s: they tell what q is in
    names += [f"dq{j}" for j in range(1, 8)]
    table = np.column_stack([1e3 * t, q, tau, 0.95 * tau + 0.02 * np.sin(40 * phase), speeds])
    rows = [";".join(f"{v:.6g}" for v in row) for row in table]
    return "\n".join([";".join(names), *rows])


@pytest.fixture
def page(archive, visit):
    visitor = visit(archive[0], bypass_csp=True)
    visitor.open("runs")
    yield visitor.page
    assert not visitor.errors


def shown(page):
    """The dialogue, once it has looked at everything."""
    page.locator(".preview").wait_for()
    until(page, "document.querySelector('.preview')?.getAttribute('aria-busy') === 'false'")
    return page.locator(".preview")


@pytest.mark.long
def test_a_guess_is_corrected_and_imported(page, archive, strange):
    page.evaluate(DROP, ["log.txt", strange])
    box = shown(page)
    assert page.evaluate("document.activeElement.textContent") == "Before log.txt is imported"
    assert page.get_by_label("axis_1_pos: read as").input_value() == "q1"
    assert page.get_by_label("axis_1_pos: unit").input_value() == "deg"
    assert page.get_by_label("stamp: unit").input_value() == "ms"
    assert page.get_by_label("axis_7_torque_cmd: read as").input_value() == ""
    assert box.locator("tbody svg polyline").count() == 29
    ink = "getComputedStyle(document.querySelector('.preview polyline')).stroke"
    assert page.evaluate(ink).startswith("rgb"), "the course of a column is to be seen"
    row = box.locator("tbody tr", has_text="axis_1_pos")
    assert "-1.047 … 1.047 rad" in row.inner_text()
    assert "--map 'stamp[ms]=time' 'axis_{n}_pos[deg]=q'" in box.locator("code").text_content()

    page.get_by_label("axis_1_pos: unit").fill("1")  # as if it were rad
    for joint in range(2, 8):
        page.get_by_label(f"axis_{joint}_pos: unit").fill("1")
    box.locator(".levels .error", has_text="look like degrees").wait_for()
    assert box.get_by_role("button", name="Import", exact=True).is_disabled()
    assert box.get_by_role("button", name="Import it all the same").is_visible()
    box.locator(".levels .error").get_by_role("button", name="Mend it").click()
    until(page, "!document.querySelector('.preview .levels .error')")
    assert page.get_by_label("axis_1_pos: unit").input_value() == "deg"

    page.get_by_label("trq1: read as").select_option("")
    box.locator("p.bad", has_text="no column tau1").wait_for()
    page.get_by_label("axis_1_torque_cmd: read as").select_option("tau1")
    box.locator(
        ".levels .warning", has_text="axis_1_torque_cmd: a torque that was asked"
    ).wait_for()
    shown(page)
    box.get_by_role("button", name="Import", exact=True).click()
    page.locator("#runs tbody tr", has_text="log").wait_for()
    page.locator(".notice", has_text="Imported log").wait_for()
    run = httpx.get(f"{archive[0]}/api/v1/runs/log", trust_env=False).json()
    assert "commanded" in [finding["code"] for finding in run["findings"]]

    page.get_by_role("button", name="log", exact=True).click()
    known = page.locator("#run-detail .known")
    known.locator("li.warning", has_text="a torque that was asked for").wait_for()
    known.get_by_role("button", name="Check it now").click()
    known.locator("li.info", has_text="2000 samples at 200 Hz").wait_for()
    httpx.delete(f"{archive[0]}/api/v1/runs/log", trust_env=False).raise_for_status()


def test_an_episode_is_chosen_looked_at_and_imported(page, archive):
    """Of a data set that has three; the longest is shown first."""
    page.evaluate(BYTES, ["set.parquet", base64.b64encode(episodes(300, 900, 500)).decode()])
    box = shown(page)
    which = page.get_by_label("episode", exact=True)
    assert which.input_value() == "1"
    there = ["0 · 300 frames", "1 · 900 frames", "2 · 500 frames"]
    assert which.locator("option").all_text_contents() == there
    which.select_option("2")
    box.locator("p", has_text="500 samples").wait_for()
    shown(page)
    assert "--episode 2" in box.locator("code").text_content()
    this_one = re.compile("^Import( it all the same)?$")
    box.get_by_role("button", name=this_one).locator("visible=true").last.click()
    page.locator("#runs tbody tr", has_text="set-2").wait_for()
    run = httpx.get(f"{archive[0]}/api/v1/runs/set-2", trust_env=False).json()
    assert run["samples"] == 500
    httpx.delete(f"{archive[0]}/api/v1/runs/set-2", trust_env=False).raise_for_status()


@pytest.mark.long
def test_every_episode_becomes_a_run(page, archive):
    """But one that is too short to be one."""
    page.evaluate(BYTES, ["set.parquet", base64.b64encode(episodes(300, 2, 500)).decode()])
    shown(page).get_by_role("button", name="Import all 3 episodes").click()
    said = page.locator(".notice", has_text="Imported 2 of 3 episodes.")
    said.get_by_text("Episode 1: set.parquet").wait_for()
    for name, samples in (("set-0", 300), ("set-2", 500)):
        page.locator("#runs tbody tr", has_text=name).wait_for()
        run = httpx.get(f"{archive[0]}/api/v1/runs/{name}", trust_env=False).json()
        assert run["samples"] == samples
        httpx.delete(f"{archive[0]}/api/v1/runs/{name}", trust_env=False).raise_for_status()


@pytest.mark.long
def test_a_log_of_two_buses_asks_for_one(page):
    lines = []
    for k in range(400):
        for c in (0, 1):
            at = 1000.0 + 0.005 * k + 0.001 * c
            lines.append(f"({at:.6f}) can{c} 080#")
            for j in range(7):
                count = round(1e5 * np.sin(0.02 * k + j) + 1e5 * c).to_bytes(
                    4, "little", signed=True
                )
                data = (count + bytes([k % 50, 0, 0x27, 6])).hex().upper()
                lines.append(f"({at + 1e-4 * (j + 1):.6f}) can{c} {0x181 + j:03X}#{data}")
    page.evaluate(DROP, ["bus.log", "\n".join(lines) + "\n"])
    box = page.locator(".preview")
    box.locator("p.bad", has_text="it holds 2 recordings: choose the bus").wait_for()
    assert box.get_by_role("button", name="Import", exact=True).is_disabled()
    page.get_by_label("bus", exact=True).select_option("can1")
    box.locator("p", has_text="400 samples").wait_for()
    shown(page)
    assert not box.locator("p.bad").is_visible()
    assert "--topic can1" in box.locator("code").text_content()
    box.get_by_role("button", name="Leave it").click()


def episodes(*lengths: int) -> bytes:
    """A file of a LeRobot data set, 100 frames a second."""
    import pyarrow as pa
    from pyarrow import parquet

    t = np.concatenate([np.arange(n) / 100.0 for n in lengths])
    phase = t[:, None] * np.linspace(1.5, 3.0, 7)
    columns = {f"q{j + 1}": 0.6 * np.sin(phase[:, j]) for j in range(7)}
    columns |= {f"tau{j + 1}": 5.0 * np.sin(phase[:, j]) for j in range(7)}
    number = np.repeat(np.arange(len(lengths)), lengths)
    out = io.BytesIO()
    parquet.write_table(pa.table({"timestamp": t, "episode_index": number, **columns}), out)
    return out.getvalue()


@pytest.mark.long
def test_it_goes_by_keyboard_and_can_be_left(page, archive, strange):
    before = len(httpx.get(f"{archive[0]}/api/v1/runs", trust_env=False).json()["items"])
    page.evaluate(DROP, ["log.txt", strange])
    shown(page)
    page.keyboard.press("Tab")
    names = []
    for _ in range(80):
        names.append(
            page.evaluate("document.activeElement.ariaLabel || document.activeElement.textContent")
        )
        if names[-1] == "Leave it":
            break
        page.keyboard.press("Tab")
    assert {"stamp: read as", "stamp: unit", "columns of log.txt", "Import"} <= set(names)
    page.keyboard.press("Enter")
    page.locator(".preview").wait_for(state="detached")
    after = httpx.get(f"{archive[0]}/api/v1/runs", trust_env=False).json()["items"]
    assert len(after) == before


@pytest.mark.long
def test_several_files_alike_are_asked_once(page, archive, strange):
    page.evaluate(DROP, [["a.txt", "b.txt", "c.txt"], strange])
    box = shown(page)
    box.get_by_role("button", name="Import this and the 2 others alike").click()
    for name in ("a", "b", "c"):
        page.locator("#runs tbody tr").get_by_role("button", name=name, exact=True).wait_for()
        httpx.delete(f"{archive[0]}/api/v1/runs/{name}", trust_env=False).raise_for_status()


@pytest.mark.long
def test_a_file_that_is_dropped_while_another_is_read_waits_for_it(page, strange):
    sent = []
    page.route("**/api/v1/recordings?*", lambda route: sent.append(route))
    page.evaluate(DROP, ["a.txt", strange])
    page.locator(".drop", has_text="Reading a.txt").wait_for()
    page.evaluate(DROP, ["b.txt", strange])
    page.locator(".notice", has_text="One file after the other").wait_for()
    [first] = sent
    first.continue_()
    page.unroute("**/api/v1/recordings?*")
    assert "Before a.txt" in shown(page).locator("h2").inner_text()
    kept = []
    page.route("**/api/v1/recordings/*/import", lambda route: kept.append(route))
    page.get_by_role("button", name="Import", exact=True).click()
    page.locator(".drop", has_text="Importing a.txt").wait_for()
    kept[0].abort()
    page.locator(".drop", has_text="a.txt waits for you below").wait_for()
    page.locator(".notice.error").get_by_label("Close this message").click()
    page.get_by_role("button", name="Leave it").click()
    page.locator(".drop", has_text="Drop recordings here").wait_for()
    page.evaluate(DROP, ["b.txt", strange])
    assert "Before b.txt" in shown(page).locator("h2").inner_text()
    page.get_by_role("button", name="Leave it").click()


@pytest.mark.long
def test_a_file_that_is_no_longer_kept_can_be_left(page, archive, strange):
    page.evaluate(DROP, ["log.txt", strange])
    with page.expect_response("**/preview") as answer:
        shown(page)
    kept = answer.value.json()["id"]
    httpx.delete(f"{archive[0]}/api/v1/recordings/{kept}", trust_env=False).raise_for_status()
    page.get_by_role("button", name="Leave it").click()
    page.locator(".preview").wait_for(state="detached")


@pytest.mark.long
@pytest.mark.parametrize(
    ("scheme", "width"), [pytest.param("light", 1440, marks=pytest.mark.long), ("dark", 390)]
)
def test_everyone_can_use_it(archive, visit, strange, scheme, width):
    size = {"width": width, "height": 900}
    visitor = visit(archive[0], color_scheme=scheme, viewport=size, bypass_csp=True)
    visitor.open("runs")
    page = visitor.page
    page.evaluate(DROP, ["log.txt", strange])
    shown(page)
    page.evaluate(AXE)
    assert broken_rules(page) == []
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert page.evaluate(CUT, 16) == [], "what a column is read as can be read"
    page.get_by_role("button", name="Leave it").click()
    page.locator(".preview").wait_for(state="detached")
    assert not visitor.errors
