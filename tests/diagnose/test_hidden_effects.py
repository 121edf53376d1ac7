"""The simulated arm hides an effect; the diagnosis names it, its joint and its size.

An effect counts as visible where being told of it removes a tenth of some joint's held-out RMS;
smaller ones are drawn anew.
"""

from __future__ import annotations

import numpy as np
import pytest
from hidden_arms import (
    Arm,
    arm,
    asks_what_changed,
    drawn,
    error_when_told,
    joints_of,
    random_effect_of,
    true_parameters,
)
from scipy.stats import norm

from pa10d.diagnose.outcome.diagnosis import Diagnosis
from pa10d.effects import all_effects

VISIBLE = 0.9
EFFECTS = sorted(e.id for e in all_effects().values() if e.question != "textbook")
SEEDS = (1, 2)

SURE = float(norm.isf(0.01 / 2 / 100))
"""Standard errors that none of some 100 parameters exceeds in 99 of 100 runs of these tests."""


def visible_arm(name: str, seed: int) -> tuple[Arm, np.ndarray]:
    """An arm with the effect, drawn until it shows; and the error of a fit that is told."""
    for attempt in range(5):
        hidden = drawn(name, seed + 100 * attempt)
        found = arm(1000 * seed + len(name) + attempt, [hidden], frozen=asks_what_changed(name))
        told = error_when_told(found)
        if np.min(told / found.error_as_given()) < VISIBLE:
            return found, told
    pytest.fail(f"{name}: no visible case among five")


@pytest.mark.long
@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("name", EFFECTS)
def test_a_hidden_effect_is_named_first_with_joint_and_size(name, seed):
    hidden_in, told = visible_arm(name, seed)
    (hidden,) = hidden_in.hidden
    found = hidden_in.diagnose()
    assert found.verdict == "missing", f"{hidden} is not found"
    assert places(found)[0] == (name, joints_of(hidden)), f"{hidden}"
    _within_errors(found, hidden_in)
    _as_good_as_told(found, told)


def places(found: Diagnosis) -> list[tuple[str, tuple[int, ...]]]:
    return [(f.term.effect_id, f.term.joints) for f in found.findings]


def _within_errors(found: Diagnosis, hidden_in: Arm) -> None:
    for hidden in hidden_in.hidden:
        place = (hidden["effect"], joints_of(hidden))
        reported = found.findings[places(found).index(place)].parameters
        for key, true in true_parameters(hidden, hidden_in.truth).items():
            value, error = reported[key].value, reported[key].std_error
            assert abs(value - true) <= max(SURE * error, 1e-9 * abs(true)), (
                f"{place} {key}: {value:.5g} ± {error:.2g}, true {true:.5g}"
            )


def _as_good_as_told(found: Diagnosis, told: np.ndarray) -> None:
    assert np.all(found.findings[-1].rms_after <= 1.1 * told), (
        f"{found.findings[-1].rms_after / told} times the error of a fit that is told the truth"
    )


@pytest.mark.long
@pytest.mark.parametrize(("joint", "dmu"), [(2, 0.05), (4, 0.06), (4, 0.0)])
def test_load_friction_says_whether_the_motor_drives_where_it_matters(joint, dmu):
    hidden = {"effect": "load_friction", "joint": joint, "mu": 0.08} | ({"dmu": dmu} if dmu else {})
    hidden_in = arm(520 + joint, [hidden])
    found = hidden_in.diagnose()
    assert places(found) == [("load_friction", joints_of(hidden))]
    assert ("dmu" in found.findings[0].parameters) is bool(dmu)
    _within_errors(found, hidden_in)


TWO_AT_ONCE = [
    ("stribeck", "spring", 1),
    ("load_friction", "torque_ripple", 2),
    ("nonlinear_viscous", "position_friction", 3),
    ("coupling_friction", "torque_offset", 4),
]


@pytest.mark.long
@pytest.mark.parametrize(("first", "second", "seed"), TWO_AT_ONCE)
def test_two_effects_at_once(first, second, seed):
    hidden_in = arm(500 + seed, [drawn(first, seed), drawn(second, seed)])
    told = error_when_told(hidden_in)
    found = hidden_in.diagnose()
    expected = {(h["effect"], joints_of(h)) for h in hidden_in.hidden}
    assert expected <= set(places(found)[:3])
    assert len(found.findings) == 2
    _within_errors(found, hidden_in)
    _as_good_as_told(found, told)


@pytest.mark.long
@pytest.mark.parametrize("name", ["payload", "encoder_offset"])
def test_two_changes_at_once(name):
    """A model from before; since then the base was tilted as well."""
    hidden_in = arm(560, [drawn("base_tilt", 5), drawn(name, 5)], frozen=True)
    told = error_when_told(hidden_in)
    found = hidden_in.diagnose()
    assert {(h["effect"], joints_of(h)) for h in hidden_in.hidden} <= set(places(found)[:3])
    _as_good_as_told(found, told)


@pytest.mark.long
@pytest.mark.parametrize("name", ["stribeck", "torque_ripple", "contact"])
def test_the_same_effect_on_two_joints(name):
    one, other = (random_effect_of(name, joint) for joint in (2, 6))
    hidden_in = arm(600, [one, other])
    told = error_when_told(hidden_in)
    found = hidden_in.diagnose()
    assert set(places(found)) == {(name, (1,)), (name, (5,))}
    _within_errors(found, hidden_in)
    _as_good_as_told(found, told)


OUTSIDE = [("gyroscope", 1), ("cable_drag", 2), ("cross_friction", 3)]


@pytest.mark.long
@pytest.mark.parametrize(("name", "seed"), OUTSIDE)
def test_what_no_library_has_is_called_unknown(name, seed):
    hidden_in = arm(700 + seed, [drawn(name, seed)])
    joint = joints_of(hidden_in.hidden[0])[0] + 1
    found = hidden_in.diagnose()
    assert places(found) == []
    assert found.verdict == "unknown"
    first, *others = found.unexplained
    assert first.joint + 1 == joint
    assert first.variables
    # shared bodies bend towards it: what that leaves on other joints is real, and follows nothing
    assert not any(u.variables for u in others)
