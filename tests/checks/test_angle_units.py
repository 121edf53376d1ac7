"""Degrees or angles at the motor: told by speeds, limits, gears or weight, or both are said."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from one_ur5e import recorded, ur5e

from pa10d.checks import Known, check_recording
from pa10d.services.import_preview import preview_recording
from pa10d.services.robots import load_robot

CODES = {"degrees", "motor_side", "angle_unit"}
RATIOS = (101.0, 101.0, 101.0, 50.0, 50.0, 50.0)
GEARED = " ".join(f"'q{j}[1/{ratio:g}]=q{j}'" for j, ratio in enumerate(RATIOS, 1))


@pytest.fixture(scope="module")
def robot():
    return ur5e()


@pytest.fixture(scope="module")
def clean():
    return replace(recorded(30.0), dq=None)


@pytest.fixture(scope="module")
def speeds(clean):
    return np.gradient(clean.q, axis=0) * clean.rate


def _said(run, robot, **known):
    found = check_recording(run, None, robot, delay=False, known=Known(**known))
    return [f for f in found if f.code in CODES]


def _shown(run, **changes):
    """So that weight tells nothing: torques of something else."""
    noise = np.random.default_rng(2).normal(0, 1, run.tau.shape)
    return replace(run, tau=noise, **changes)


def test_a_clean_recording_is_silent(clean, robot):
    assert _said(clean, robot) == []


def test_speeds_in_radians_tell_degrees(clean, robot, speeds):
    (said,) = _said(_shown(clean, q=np.degrees(clean.q), dq=speeds), robot)
    assert said.code == "degrees"
    assert said.severity == "error"
    assert "by dq" in said.sentence
    assert said.mends[0].option == "'q{n}[deg]=q'"


def test_speeds_tell_the_gear(clean, robot, speeds):
    (said,) = _said(_shown(clean, q=80 * clean.q, dq=speeds), robot)
    assert said.code == "motor_side"
    assert "by dq with a ratio of 80" in said.sentence
    assert [mend.option for mend in said.mends] == ["'q{n}[1/80]=q'"]


def test_a_profile_s_gears_stand_in_the_line(clean, robot, speeds):
    (said,) = _said(_shown(clean, q=clean.q * RATIOS, dq=speeds), robot, ratios=RATIOS)
    assert said.code == "motor_side"
    assert said.advice == f"q must be at the joint: --map {GEARED}"
    assert all(mend.complete for mend in said.mends)


def test_limits_tell_what_cannot_be_degrees(clean, robot):
    (said,) = _said(_shown(clean, q=1000 * clean.q), robot)
    assert said.code == "motor_side"
    assert "too far for degrees" in said.sentence
    assert "RATIO" in said.advice


def test_a_zero_that_lies_elsewhere_tells_no_unit(clean, robot):
    (said,) = _said(_shown(clean, q=np.degrees(clean.q) + 900), robot)
    assert said.code == "angle_unit"


def test_torques_in_the_columns_of_angles_are_not_only_called_degrees(clean, robot):
    noise = np.random.default_rng(3).normal(0, 0.5, clean.tau.shape)
    rubbed = clean.tau + noise + 2.0 * np.sign(np.gradient(clean.q, axis=0))
    (said,) = _said(replace(clean, q=rubbed, tau=clean.q), robot)
    assert "q and tau in each other's columns, degrees" in said.sentence
    assert said.advice.startswith("exchanged: --map tau1=q1 tau2=q2")
    (said,) = _said(replace(clean, q=np.degrees(clean.q), tau=0.01 * rubbed), robot)
    assert "each other's" not in said.sentence, "an angle is smooth in any unit"


@pytest.mark.parametrize("ratios", [None, RATIOS])
def test_weight_tells_degrees(clean, robot, ratios):
    (said,) = _said(replace(clean, q=np.degrees(clean.q)), robot, ratios=ratios)
    assert said.code == "degrees"
    assert "by the arm's weight" in said.sentence


def test_weight_tells_the_motor_s_side(clean, robot):
    (said,) = _said(replace(clean, q=clean.q * RATIOS), robot, ratios=RATIOS)
    assert said.code == "motor_side"
    assert "by the arm's weight" in said.sentence


@pytest.mark.parametrize("ratios", [None, RATIOS])
def test_where_nothing_tells_both_are_said(clean, robot, ratios):
    (said,) = _said(_shown(clean, q=clean.q * RATIOS), robot, ratios=ratios)
    assert said.code == "angle_unit"
    assert said.severity == "error"
    assert "degrees: --map 'q{n}[deg]=q'; at the motor: --map" in said.advice
    assert (GEARED in said.advice) is (ratios is not None)
    assert not any(mend.complete for mend in said.mends)


def test_one_joint_in_degrees_is_offered_alone(clean, robot):
    """Of a log in radians but for one joint: what mends it would divide the others by 57."""
    q = clean.q.copy()
    q[:, 1] = np.degrees(q[:, 1])
    (said,) = _said(_shown(clean, q=q), robot)
    assert "--map 'q{n}[deg]=q', or --map 'q2[deg]=q2' where joint 2 alone; " in said.advice


def test_angles_at_the_motor_are_not_called_degrees_by_their_weight(clean, robot):
    (said,) = _said(replace(clean, q=clean.q * RATIOS), robot)
    assert said.code == "angle_unit"


def test_who_states_degrees_is_not_told_that_they_are(clean, robot):
    stated = frozenset(range(6))
    (said,) = _said(replace(clean, q=80 * clean.q), robot, stated=stated)
    assert said.code == "motor_side"
    assert "[deg]" not in said.advice


@pytest.mark.parametrize("gears", [False, True])
def test_a_preview_takes_degrees_with_a_word_and_never_behind_known_gears(
    tmp_path, clean, robot, gears
):
    run = _shown(clean, q=np.degrees(clean.q))
    profile = load_robot("ur5e")[0]
    if not gears:
        profile = profile.model_copy(update={"drives": None})
    names = ["time", *(f"q{j}" for j in range(1, 7)), *(f"tau{j}" for j in range(1, 7))]
    rows = np.column_stack([run.t, run.q, run.tau]).tolist()
    path = tmp_path / "log.csv"
    path.write_text("\n".join([",".join(names), *(",".join(map(repr, row)) for row in rows)]))
    found = preview_recording(path, profile, robot, thorough=False)
    units = {c.unit for c in found.columns if c.field.startswith("q")}
    codes = {f.finding.code for f in found.findings}
    if profile.drives:
        assert units == {""}
        assert "angle_unit" in codes
    else:
        assert units == {"deg"}
        assert any("taken for degrees here" in remark for remark in found.remarks)


def test_whole_numbers_beyond_a_turn_are_an_encoders(clean, robot):
    """Twelve bits of a servo: "degrees, or angles at the motor"."""

    def codes(q):
        found = check_recording(replace(clean, q=q), None, robot, delay=False)
        return [f.code for f in found if f.code in CODES | {"counts"}]

    assert codes(np.round(clean.q / (2 * np.pi) * 4096) + 2048) == ["counts"]
    assert "counts" not in codes(np.round(np.degrees(clean.q)))
