"""What the page shows beside its story: what cannot be read, what stands around, and when."""

from __future__ import annotations

import itertools
import json
import re
from pathlib import Path

import numpy as np
import pytest
import yaml

import pa10d
from pa10d.common.jsonable import plain
from pa10d.daemon.daemon import MOVING
from pa10d.profile import find_profile
from pa10d.services.shape import shape

JOINTS = ((1, "S1"), (2, "S2"), (3, "E1"))
TICKS = """async ([width, seconds]) => {
  const { Scope } = await import("/assets/any/parts/scope.js");
  const about = { title: "t", unit: "u", least: 1, value: (row) => row[0] };
  const scope = new Scope(about, 1, new Set());
  document.body.append(scope.box);
  scope.canvas.style.width = `${width}px`;
  const said = [], pen = scope.canvas.getContext("2d"), write = pen.fillText.bind(pen);
  pen.fillText = (text, x, y) => {
    const size = pen.measureText(text).width;
    const left = { left: x, right: x - size, center: x - size / 2 }[pen.textAlign];
    said.push({ text, left, right: left + size, y });
    write(text, x, y);
  };
  const rows = [[seconds, [0]]];
  scope.draw({ rows, seconds, newest: seconds, seen: () => rows, marks: [] }, null);
  scope.box.remove();
  return said.filter((one) => one.text === "now" || one.text.endsWith(" s"));
}"""
DRAWN = """async (boxes) => {
  const { ArmScene } = await import("/assets/any/parts/arm_scene.js");
  const told = await (await fetch("/api/v1/robot/shape")).json();
  const triangles = (scene) => {
    scene.pose(scene.shape.joints.map(() => 0));
    scene.renderer.render(scene.scene, scene.camera);
    return scene.renderer.info.render.triangles;
  };
  const made = (around) => new ArmScene({ ...told, boxes: around }, []);
  const bare = made([]), full = made(boxes);
  const corners = full.surroundings.map(({ root }) => {
    root.updateMatrixWorld(true);
    const at = root.children[0].geometry.attributes.position, m = root.matrixWorld.elements;
    return Array.from({ length: at.count }, (_, k) => [0, 1, 2].map((row) =>
      m[row] * at.getX(k) + m[4 + row] * at.getY(k) + m[8 + row] * at.getZ(k) + m[12 + row]));
  });
  return { more: triangles(full) - triangles(bare), corners };
}"""


@pytest.fixture
def damaged(archive):
    """Entries of the store that cannot be read, beside those that can."""
    _, data = archive
    run, model = data / "runs" / "stray", data / "models" / "bad.yaml"
    run.mkdir()
    (run / "run.json").write_text('{"id": "stray", "name": 7}')
    model.write_text("- 1")
    yield data
    (run / "run.json").unlink()
    run.rmdir()
    model.unlink()


def test_what_cannot_be_read_is_said_where_the_others_are_listed(archive, damaged, visit):
    visitor = visit(archive[0])
    page = visitor.page
    for section, place in (("runs", "runs/stray"), ("models", "models/bad.yaml")):
        visitor.open(section)
        line = page.locator(f"#{section} .aside")
        line.locator("summary", has_text="cannot be read").wait_for()
        assert not line.get_by_text(place, exact=True).is_visible(), "quiet until it is opened"
        line.locator("summary").click(position={"x": 20, "y": 8})
        line.locator("dt", has_text=place).wait_for()
        assert place in line.locator("dd").inner_text()
        assert str(damaged) not in line.inner_text()
    line.get_by_role("button").click()
    line.wait_for(state="hidden")
    page.reload()
    page.locator("#models [data-model=m0]").wait_for()
    assert not line.is_visible(), "closed until something changes"
    assert not visitor.errors


@pytest.fixture
def boxed(tmp_path):
    """A profile with a box that is turned by 0.5 rad about z, and a floor below the base."""
    source = find_profile("pa10-sim")
    profile = yaml.safe_load(source.read_text())
    profile["urdf"] = str(source.parent / profile["urdf"])
    box = {"name": "table", "size": [0.6, 1.2, 0.5], "xyz": [0.9, 0.1, 0.15], "rpy": [0, 0, 0.5]}
    profile["environment"] = {"floor": -0.1, "boxes": [box]}
    path = tmp_path / "boxed.yaml"
    path.write_text(yaml.safe_dump(profile))
    return path


@pytest.mark.long
def test_the_boxes_of_the_profile_are_drawn_where_they_stand(archive, boxed, visit):
    told = shape("", str(boxed))
    assert told.floor == -0.1
    assert [box.name for box in told.boxes] == ["table"]
    visitor = visit(archive[0])
    visitor.open("models")
    found = visitor.page.evaluate(DRAWN, plain(told.boxes))
    assert found["more"] >= 12, "triangles that the browser draws"
    drawn = np.array(found["corners"][0])
    cos, sin = np.cos(0.5), np.sin(0.5)
    half = [np.array([x, y, z]) for x in (-0.3, 0.3) for y in (-0.6, 0.6) for z in (-0.25, 0.25)]
    expected = [[0.9 + cos * x - sin * y, 0.1 + sin * x + cos * y, 0.15 + z] for x, y, z in half]
    away = np.linalg.norm(drawn[:, None] - np.array(expected), axis=2)
    assert away.min(axis=1).max() < 1e-6, "every corner that is drawn is one of the box"
    assert away.min(axis=0).max() < 1e-6, "and every corner of the box is drawn"
    assert not visitor.errors


@pytest.mark.long
def test_words_at_the_axis_of_time_never_touch(archive, visit):
    visitor = visit(archive[0])
    visitor.open("models")
    assert not visitor.page.locator("#models .aside").is_visible(), "nothing is damaged there"
    for seconds in (60, 10):
        for width in (230, 320, 420, 900):
            words = sorted(visitor.page.evaluate(TICKS, [width, seconds]), key=lambda w: w["left"])
            assert words[-1]["text"] == "now"
            assert len(words) >= 3, (width, seconds)
            for one, other in itertools.pairwise(words):
                assert other["left"] - one["right"] >= 4, (width, seconds, one, other)


@pytest.mark.long
def test_words_at_the_axis_of_time_grow_with_the_text(archive, visit):
    visitor = visit(archive[0], bypass_csp=True)
    visitor.open()
    small = visitor.page.evaluate(TICKS, [600, 60])
    visitor.page.evaluate("document.documentElement.style.fontSize = '200%'")
    large = visitor.page.evaluate(TICKS, [600, 60])
    assert 2 <= len(large) < len(small), "fewer of them, each of twice the size"


def test_nothing_that_the_page_asks_for_is_missing(archive, visit):
    visitor = visit(archive[0])
    missing = []
    visitor.page.on("response", lambda r: r.status >= 400 and missing.append(r.url))
    visitor.page.on("console", lambda m: "404" in m.text and missing.append(m.location))
    for section in ("robot", "investigate", "experiments", "tune", "runs", "explore", "models"):
        visitor.open(section)
        visitor.until_answered()
    visitor.page.goto(f"{archive[0]}/docs")
    visitor.until_answered()
    assert not missing
    icon = visitor.page.request.get(f"{archive[0]}/favicon.ico")
    assert (icon.status, icon.headers["content-type"]) == (200, "image/svg+xml")


def test_page_and_daemon_know_the_same_jobs_that_move_the_arm():
    source = (Path(pa10d.__file__).parent / "web/base/condition.js").read_text()
    [listed] = re.findall(r"MOVES = (\[.*?\]);", source)
    assert json.loads(listed) == list(MOVING)


@pytest.mark.long
def test_what_drives_remember_is_asked_when_somebody_looks(arm, visit):
    visitor = visit(arm.url)
    visitor.open("robot")
    page = visitor.page
    assert not [one for one in visitor.asked if "robot/errors" in one]
    page.locator("#memories summary").click()
    rows = page.locator("#memories tbody tr")
    rows.first.wait_for()
    assert rows.all_inner_texts() == [f"{k} {name}\tnone\tnone" for k, name in JOINTS]
    assert page.get_by_role("button", name="Empty them").count() == 0
    assert not visitor.errors
