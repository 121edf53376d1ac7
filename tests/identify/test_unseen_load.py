"""Friction that is larger while the motor drives reads as load: the weight's doubt knows."""

from __future__ import annotations

import numpy as np
import pytest
from pendulum import EXACT, PENDULUM, swing

from pa10d.diagnose.procedure import diagnose
from pa10d.identify import identify

WEIGHT = EXACT.mass * EXACT.com[2]  # kg·m


def runs(driving, driven):
    return [
        swing(name, 1.0, 0.02, k, driving=driving, driven=driven) for k, name in enumerate("ab")
    ]


def first_moment(driving, driven):
    """Value and standard error that noise alone would leave, and the whole one, kg·m."""
    model = identify(
        runs(driving, driven), PENDULUM, name="m0", cutoff=2.0, with_effects=["load_friction"]
    )
    value = model.base_values[model.parameter_names().index("mz1")]
    return value.value, value.std_error


@pytest.mark.by_default("0.2-0.2")
@pytest.mark.parametrize(("driving", "driven"), [(0.4, 0.0), (0.2, 0.2), (0.0, 0.0)])
def test_the_weight_is_within_what_it_states(driving, driven):
    value, error = first_moment(driving, driven)
    assert abs(value - WEIGHT) < 2.0 * error


@pytest.mark.long
def test_the_doubt_is_that_of_what_may_go_one_way_only():
    """A fifth of what is read rubs: anything between none and that may be no load."""
    share = 0.2 / np.sqrt(3.0)
    value, error = first_moment(0.2, 0.2)
    assert error == pytest.approx(np.hypot(share, 0.05) * abs(value), rel=0.1)
    value, error = first_moment(0.0, 0.0)
    assert error < 0.06 * abs(value)


@pytest.mark.long
def test_a_diagnosis_says_that_the_weight_may_be_less():
    fit = runs(0.4, 0.0)
    model = identify(fit, PENDULUM, name="m0", cutoff=2.0)
    found = diagnose(model, fit, [swing("c", 1.0, 0.02, 7, driving=0.4)])
    assert [f.term.effect_id for f in found.findings] == ["load_friction"]
    (said,) = (w for w in found.warnings if "lighter" in w)
    most = float(said.removeprefix("what joint 1 carries may be up to ").split(" ")[0]) / 100.0
    value = found.model.base_values[found.model.parameter_names().index("mz1")].value
    assert most == pytest.approx(1.0 - WEIGHT / value, abs=0.02)  # nothing rubs while it is driven
