"""``pa10d case-study`` over HTTP and CAN: the quick one and the whole of it."""

from __future__ import annotations

import json
import re
import subprocess
import sys

import numpy as np
import pytest

pytestmark = pytest.mark.long
HELP = {"4s": {"pid", "computed_torque"}, "40s": {"pid", "computed_torque"}}


def told(folder, *options):
    report = folder / "report.html"
    command = [sys.executable, "-m", "pa10d", "case-study", "--json", "--report", str(report)]
    done = subprocess.run(
        [*command, "--data", str(folder / "data"), *options],
        stdout=subprocess.PIPE, check=True, text=True,
    )  # fmt: skip
    return json.loads(done.stdout), report.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def quick(tmp_path_factory):
    """Its friction rises towards standstill in joint 2 alone."""
    return told(tmp_path_factory.mktemp("quick"), "--quick", "--seed", "1")


@pytest.mark.timeout(900)
def test_the_answer_has_what_is_promised(quick):
    found, _ = quick
    assert found["inertial_base_parameters"] == 22
    assert found["condition_number"] < 60
    assert found["feasible"] is True
    for key in ("boundary_velocity", "rms_set_a", "rms_set_b"):
        assert len(found[key]) == 4
    for pace, laws in HELP.items():
        assert laws <= set(found["tracking_rms"][pace])
    assert found["report"].endswith("report.html")


def test_only_the_joint_with_more_friction_at_low_speed_has_a_boundary(quick):
    boundary = np.array(quick[0]["boundary_velocity"])
    assert boundary[1] > 0.05
    assert np.all(boundary[[0, 2, 3]] < 0.03)


def test_fast_samples_make_the_better_model_there(quick):
    found, _ = quick
    assert found["rms_set_a"][1] < 0.9 * found["rms_set_b"][1]


def test_the_model_follows_better_than_pid_and_the_completed_one_best(quick):
    fast, slow = (quick[0]["tracking_rms"][pace] for pace in ("4s", "40s"))
    assert np.all(np.array(fast["computed_torque"]) < 0.6 * np.array(fast["pid"]))
    complete = np.array(slow["computed_torque_with_effects"])
    assert complete[1] < 0.8 * slow["computed_torque"][1]


def test_the_missing_friction_is_named(quick):
    (finding,) = quick[0]["findings"]
    assert (finding["effect"], finding["joints"]) == ("stribeck", [2])
    (hidden,) = quick[0]["hidden"]
    rise = finding["parameters"]["Fs"]
    assert rise["value"] == pytest.approx(hidden["Fs"], rel=0.3)


def test_the_report_stands_alone_and_has_every_step(quick):
    page = re.sub(r"<script.*?</script>", "", quick[1], flags=re.S)
    assert not re.search(r'(src|href)="(https?:)?//', page)
    titles = re.findall(r'data-title="([^"]+)"', page)
    assert [t.split(":")[0] for t in titles] == [
        "At a glance", "Beside the paper", "Boundary velocity",
        "Exciting trajectory and pre-processing", "Estimates side by side",
        "Torque reconstruction", "Verification", "Verification",
        "The low-speed model that the paper asks for",
    ]  # fmt: skip
    assert not re.search(r"\b(nan|None|inf)\b", page)


@pytest.mark.timeout(3000)
def test_the_whole_study_meets_what_was_promised(tmp_path):
    found, _ = told(tmp_path, "--seed", "2")
    assert found["inertial_base_parameters"] == 22
    assert found["condition_number"] <= 45
    assert found["feasible"]
    a, b = np.array(found["rms_set_a"]), np.array(found["rms_set_b"])
    assert np.sum(a <= b) >= 3
    fast = {how: np.array(rms) for how, rms in found["tracking_rms"]["4s"].items()}
    assert np.all(fast["computed_torque"] < 0.6 * fast["pid"])
    slow = {how: np.array(rms) for how, rms in found["tracking_rms"]["40s"].items()}
    assert np.all(slow["computed_torque_with_effects"] < slow["computed_torque"])
    assert {(f["effect"], *f["joints"]) for f in found["findings"]} == {
        ("stribeck", j) for j in (1, 2, 3, 4)
    }
