"""The arm that is drawn stands as the real one would."""

from __future__ import annotations

import base64
import time

import numpy as np
import pinocchio as pin
import pytest
from browsers import until

from pa10d.services.robots import load_robot
from pa10d.services.shape import mesh, shape

FRAMES = """async (poses) => {
  const { frames } = await import("/assets/any/base/kinematics.js");
  const shape = await (await fetch("/api/v1/robot/shape")).json();
  return poses.map((q) => frames(shape, q));
}"""


def test_its_frames_are_pinocchios(archive, visit):
    url, _ = archive
    visitor = visit(url)
    visitor.open("robot")
    robot = load_robot("pa10-sim")[1]
    poses = np.random.default_rng(4).uniform(-2, 2, (5, robot.n))
    drawn = np.array(visitor.page.evaluate(FRAMES, poses.tolist())).reshape(5, robot.n, 4, 4)
    model, index = robot.pinocchio()
    data = model.createData()
    for q, frames in zip(poses, drawn, strict=True):
        pin.forwardKinematics(model, data, q[index])
        for i, j in enumerate(index):
            assert np.allclose(frames[j], data.oMi[i + 1].homogeneous, atol=1e-9)


def test_a_replay_follows_slider_and_cursor(archive, visit):
    visitor = visit(archive[0])
    page = visitor.page
    visitor.open("runs")
    page.get_by_role("button", name="train_a").click()
    picture = page.locator("#run-detail .arm-stage canvas")
    picture.wait_for()
    page.locator("#run-detail .main-svg").first.wait_for()
    reading = page.locator("#run-detail .arm-reading")
    reading.filter(has_text="At 0.00 s").wait_for()
    before, text = picture.screenshot(), reading.inner_text()
    page.get_by_label("time in the recording").fill("33")
    reading.filter(has_text="At 33.00 s").wait_for()
    end = time.monotonic() + 30
    while picture.screenshot() == before:
        assert time.monotonic() < end, "the arm does not move in the picture"
    assert reading.inner_text().split()[3:] != text.split()[3:]
    box = page.locator("#run-detail .nsewdrag").first.bounding_box()
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    page.mouse.move(box["x"] + 0.25 * box["width"], box["y"] + 0.5 * box["height"])
    shown = "document.querySelector('#run-detail .arm-reading').textContent"
    until(page, f"Math.abs(parseFloat({shown}.split(' ')[1]) - 15) < 1")
    assert not visitor.errors
    assert not visitor.foreign()


@pytest.mark.long
def test_the_library_is_not_fetched_before_the_arm_is_looked_at(archive, visit):
    visitor = visit(archive[0])
    visitor.open("models")
    visitor.until_answered()
    assert not [address for address in visitor.asked if "vendor" in address]


@pytest.mark.long
def test_a_plan_is_seen_before_it_moves(arm, visit):
    visitor = visit(arm.url)
    page = visitor.page
    visitor.open("experiments")
    page.click("[data-kind=tracking]")
    page.get_by_role("button", name="Check").click()
    page.get_by_text("The plan, before anything moves").wait_for(timeout=120_000)
    page.locator(".checks .arm-stage canvas").wait_for()
    rows = page.locator(".checks table tbody tr")
    assert rows.count() == 3
    assert "rad" in rows.first.inner_text()
    assert "mm between" in page.locator(".checks .levels").first.inner_text()
    before = page.locator(".checks .arm-reading").inner_text()
    page.get_by_role("button", name="Play the plan").click()
    until(page, f"document.querySelector('.checks .arm-reading').textContent !== {before!r}")
    assert not visitor.errors


URDF = """<robot name="two">
<link name="base"><visual><geometry><box size="0.3 0.3 0.1"/></geometry></visual></link>
<link name="a">
<inertial><mass value="2"/><origin xyz="0 0 0.2"/>
<inertia ixx="0.02" iyy="0.02" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
<visual><geometry><mesh filename="package://anything/flat.stl" scale="1 1 2"/></geometry></visual>
<visual><geometry><mesh filename="package://anything/none.dae"/></geometry></visual></link>
<joint name="j1" type="revolute"><parent link="base"/><child link="a"/><origin xyz="0 0 0.1"/>
<axis xyz="0 0 1"/><limit lower="-2" upper="2" velocity="2" effort="50"/></joint></robot>"""
STL = """solid flat
facet normal 0 0 1
outer loop
vertex 0 0 1
vertex 1 0 1
vertex 0 1 1
endloop
endfacet
endsolid flat
"""


def test_meshes_are_found_scaled_and_what_is_missing_is_said(tmp_path):
    (tmp_path / "two.urdf").write_text(URDF)
    (tmp_path / "flat.stl").write_text(STL)
    path = str(tmp_path / "two.urdf")
    seen = shape("", path)
    assert [one.link for one in seen.meshes] == [-1, 0]
    assert [one.triangles for one in seen.meshes] == [12, 1]
    assert seen.notes == ["link a: its mesh package://anything/none.dae is not there"]
    raw = base64.b64decode(mesh("", path, 1))
    assert np.frombuffer(raw[:8], "<u4").tolist() == [3, 1]
    corners = np.frombuffer(raw[8:44], "<f4").reshape(3, 3)
    assert sorted(corners.tolist()) == [[0, 0, 2], [0, 1, 2], [1, 0, 2]]
