"""Exports for controllers of others, against the model: compiled, replayed, interpolated."""

from __future__ import annotations

import csv
import io
import json
import shutil
import subprocess
import zipfile
from dataclasses import replace

import model_examples as examples
import numpy as np
import pytest
import yaml
from scipy.interpolate import RegularGridInterpolator

from pa10d.api.folders import packed
from pa10d.common.errors import UserError
from pa10d.dynamics import robot_from_profile
from pa10d.export.formats import export
from pa10d.export.ros2_control import package_name
from pa10d.export.tables import USELESS
from pa10d.measurement.signals import Lowpass
from pa10d.profile import load_profile
from pa10d.services.models import write_export

CXX = ["g++", "-std=c++17", "-Wall", "-Wextra", "-pedantic", "-Werror", "-O1"]
BEYOND = ("stribeck", "torque_ripple", "load_friction", "payload", "spring")
needs_compiler = pytest.mark.skipif(shutil.which("g++") is None, reason="no g++ on this machine")


def written(model, folder):
    made = export(model, "ros2_control", "free", "a test")
    write_export(made, folder)
    return made


def replayed(program, *motion):
    rows = "\n".join(" ".join(f"{v:.17g}" for v in row) for row in np.hstack(motion))
    said = subprocess.run([program], input=rows, capture_output=True, text=True, check=True).stdout
    return np.array([[float(v) for v in line.split()] for line in said.splitlines()])


@needs_compiler
def test_the_class_gives_the_models_torque_over_random_motions(tmp_path):
    """In a strict compiler; what every effect becomes in C is tried with the header."""
    model = examples.with_effects(examples.textbook("7 of -- 9"), *BEYOND)
    name = package_name(model.name)
    made = written(model, tmp_path)
    assert made.not_carried == ()
    program = tmp_path / "replay"
    source = tmp_path / "src/replay.cpp"
    subprocess.run([*CXX, "-I", tmp_path / "include", "-o", program, source], check=True)
    rng = np.random.default_rng(8)
    most = np.array([1.0, 2.0, 8.0])[:, None, None]
    motion = most * rng.uniform(-1.0, 1.0, (3, 400, model.robot.n))
    assert replayed(program, *motion) == pytest.approx(model.torque(*motion), abs=1e-9)
    assert name in (tmp_path / "package.xml").read_text()


@needs_compiler
def test_the_class_keeps_to_its_limits_and_names_its_interfaces(tmp_path):
    model = examples.textbook("m0")
    written(model, tmp_path)
    name = package_name("m0")
    (tmp_path / "use.cpp").write_text(
        f"""#include <cstdio>
#include "{name}/feed_forward.hpp"
int main() {{
  using namespace {name};
  Parameters half; half.scale = 0.5; half.effort_limit.fill(3.0);
  const Joints q{{{{0.1, 0.2, 0.3, 0.4}}}}, none{{}};
  for (double v : FeedForward(half).update(q, none, none)) std::printf("%.17g ", v);
  for (double v : FeedForward().gravity(q)) std::printf("%.17g ", v);
  for (double v : Parameters().effort_limit) std::printf("%g ", v);
  for (const char *v : kEffortInterfaces) std::printf("%s ", v);
}}"""
    )
    program = tmp_path / "use"
    source = tmp_path / "use.cpp"
    subprocess.run([*CXX, "-I", tmp_path / "include", "-o", program, source], check=True)
    said = subprocess.run([program], capture_output=True, text=True, check=True).stdout.split()
    q, none = np.array([[0.1, 0.2, 0.3, 0.4]]), np.zeros((1, 4))
    torque = model.torque(q, none, none)[0]
    assert np.abs(torque).max() > 6.0  # the limit is met
    numbers = np.array([float(v) for v in said[:8]]).reshape(2, 4)
    expected = np.stack([np.clip(0.5 * torque, -3.0, 3.0), torque])
    np.testing.assert_allclose(numbers, expected, atol=1e-9)
    assert said[8:12] == ["100", "inf", "100", "100"]
    assert said[12:] == ["j1/effort", "j2/effort", "j3/effort", "j4/effort"]


@pytest.mark.skipif(shutil.which("cmake") is None, reason="no cmake on this machine")
@needs_compiler
def test_the_package_builds_where_there_is_no_ros(tmp_path):
    model = examples.textbook("Über model")
    written(model, tmp_path)
    quiet = {"cwd": tmp_path, "check": True, "capture_output": True}
    subprocess.run(["cmake", "-S", ".", "-B", "build"], **quiet)
    subprocess.run(["cmake", "--build", "build"], **quiet)
    motion = np.full((3, 1, 4), 0.2)
    found = replayed(tmp_path / "build/replay", *motion)
    assert found == pytest.approx(model.torque(*motion), abs=1e-9)


def test_parameters_are_those_of_the_robot():
    made = export(examples.textbook("m0"), "ros2_control")
    said = yaml.safe_load(made.files["config/m0_feed_forward.yaml"])
    given = said["m0_feed_forward"]["ros__parameters"]
    assert given["joints"] == ["j1", "j2", "j3", "j4"]
    assert given["effort_limit"] == [100.0, np.inf, 100.0, 100.0]


@pytest.mark.parametrize(
    ("name", "package"),
    [("M1", "m1_feed_forward"), ("7 -- a", "model_7_a_feed_forward"), ("ä", "model_feed_forward")],
)
def test_packages_are_called_as_ros_wants_it(name, package):
    assert package_name(name) == package


def interpolator(text, entry):
    rows = list(csv.reader(io.StringIO(text)))[1:]
    values = np.array(rows, dtype=float)
    shape = [axis["points"] for axis in entry["axes"]]
    grid = [np.unique(values[:, k]) for k in range(len(shape))]
    assert [len(g) for g in grid] == shape
    return RegularGridInterpolator(grid, values[:, -1].reshape(shape))


def test_tables_are_off_by_what_they_say():
    """Read back as somebody else would, in poses of our own."""
    model = examples.textbook()
    made = export(model, "tables", "free")
    told = yaml.safe_load(made.files["tables.yaml"])
    robot, rng = model.robot, np.random.default_rng(11)
    lower, upper = np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi)
    q, rest = rng.uniform(lower, upper, (3000, robot.n)), np.zeros((3000, robot.n))
    holding = model.torque(q, rest, rest)
    names = list(robot.joint_names)
    assert [e["number"] for e in told["holding"]] == [1, 2, 3, 4]
    for entry in told["holding"]:
        j = entry["number"] - 1
        if not entry["axes"]:
            assert np.abs(holding[:, j]).max() < 1e-9
            continue
        at = [names.index(axis["of"]) for axis in entry["axes"]]
        off = interpolator(made.files[entry["file"]], entry)(q[:, at]) - holding[:, j]
        assert np.sqrt(np.mean(off**2)) == pytest.approx(entry["error"]["rms"], rel=0.1)
        assert entry["error"]["rms"] < 0.01 * np.sqrt(np.mean(holding[:, j] ** 2))
        assert np.abs(off).max() < 1.5 * entry["error"]["largest"]
    assert [e["number"] for e in told["friction"]] == [1, 3, 4]
    for entry in told["friction"]:
        j = entry["number"] - 1
        dq = np.zeros_like(q)
        dq[:, j] = rng.uniform(-2.0, 2.0, len(q))
        expected = (model.torque(q, dq, rest) - holding)[:, j]
        off = interpolator(made.files[entry["file"]], entry)(dq[:, [j]]) - expected
        assert np.sqrt(np.mean(off**2)) == pytest.approx(entry["error"]["rms"], rel=0.3)
    said = " ".join(made.not_carried)
    assert "inertia and Coriolis torque not in the export" in said
    assert "friction of joint 2 not in the export: no speed limit" in said


def test_tables_say_what_no_table_holds():
    """Inertia, other joints' speeds, and warmth, of which friction by speed knows nothing."""
    model = examples.with_effects(examples.textbook(), "thermal_friction", "coupling_inertia")
    seen = examples.motion()
    made = export(model, "tables", "free", motions={"held": seen})
    rest, held = np.zeros_like(seen.q), []
    for j in range(model.robot.n):
        dq = rest.copy()
        dq[:, j] = seen.dq[:, j] if np.isfinite(model.robot.velocity[j]) else 0.0
        held.append(model.torque(seen.q, dq, rest)[:, j])
    lowpass = Lowpass(len(seen.t), (len(seen.t) - 1) / (seen.t[-1] - seen.t[0]), model.cutoff)
    missed = lowpass(model.predict(seen) - np.stack(held, axis=1))
    gone = np.sqrt(np.mean(missed[lowpass.settle : -lowpass.settle] ** 2, axis=0))
    assert made.loss is not None
    assert made.loss.rms == pytest.approx(gone, rel=1e-9)
    assert f"j1 {gone[0]:.2g} N·m" in made.files["tables.yaml"].replace("\n  ", " ")
    assert any("thermal_friction" in line for line in made.not_carried)


def test_a_table_over_too_many_joints_says_what_it_leaves_out_or_is_refused():
    """The wrist of a seven-joint arm feels gravity by all joints before it."""
    model = examples.textbook(robot=robot_from_profile(load_profile("pa10-sim")))
    made = export(model, "tables")
    told = yaml.safe_load(made.files["tables.yaml"])
    there = {entry["number"]: entry for entry in told["holding"]}
    assert there[2]["averaged_over"]
    assert there[2]["error"]["rms"] < 0.1 * there[2]["rms"]
    for entry in there.values():
        assert entry["error"]["rms"] <= USELESS * entry["rms"] or entry["rms"] < 1e-6
    refused = [line for line in made.not_carried if "a table over" in line]
    assert not any(f"holding_{j}.csv" in made.files for j in range(1, 8) if j not in there)
    assert len(refused) == 7 - len(there) > 0
    assert all("N·m (RMS, of" in line for line in refused)


def test_a_joint_that_slides_for_ever_has_no_table():
    robot = examples.ROBOT
    endless = replace(robot, upper=np.where(robot.prismatic, np.inf, robot.upper))
    with pytest.raises(UserError, match="format tables: joint 3 slides without limits"):
        export(examples.textbook(robot=endless), "tables")


def test_a_folder_is_packed_the_same_twice_and_written_once(tmp_path):
    made = export(examples.textbook(), "ros2_control")
    one = packed(made.files)
    assert one == packed(dict(reversed(made.files.items())))
    with zipfile.ZipFile(io.BytesIO(one)) as archive:
        assert {n: archive.read(n).decode() for n in archive.namelist()} == dict(made.files)
    (tmp_path / "taken").write_text("a file")
    with pytest.raises(UserError, match="expected a folder that can be written"):
        write_export(made, tmp_path / "taken")
    assert json.dumps(sorted(made.files)).count("include/") == 2
