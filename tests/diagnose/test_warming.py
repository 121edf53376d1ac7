"""Friction that falls with the heat it makes itself: named, sized, and no model of mere time."""

from __future__ import annotations

import numpy as np
import pytest
from two_links import COULOMB, V0, VISCOUS, motion, recordings, textbook

from pa10d.diagnose.procedure import diagnose
from pa10d.effects.base import smooth_sign
from pa10d.regression.equation import prepare

LOSS, T, POWER, JOINT = 0.4, 9.0, 4.0, 1


def lost(t, q, dq, ddq):
    """(N, 2) N·m: T·ẇ = P/P₀ - w with the power P of the friction that is left, by small steps."""
    v, sign = dq[:, JOINT], smooth_sign(dq[:, JOINT], V0)
    cold = COULOMB[JOINT] * sign + VISCOUS[JOINT] * v
    dt, warm = t[1] - t[0], np.zeros(len(t))
    for k in range(len(t) - 1):
        heat = abs((1.0 - LOSS * warm[k]) * cold[k] * v[k]) / POWER
        warm[k + 1] = warm[k] + dt * (heat - warm[k]) / T
    out = np.zeros_like(q)
    out[:, JOINT] = -LOSS * warm * cold
    return out


@pytest.fixture(scope="module")
def found():
    runs = recordings(4, lost, noise=0.02)
    fit, held = ([runs[f"{side}_{k}"] for k in "ab"] for side in ("fit", "valid"))
    return diagnose(textbook(runs), fit, held), runs


@pytest.mark.long
def test_it_is_named_with_what_it_takes(found):
    (finding,) = found[0].findings
    assert (finding.term.effect_id, finding.term.joints) == ("thermal_friction", (JOINT,))
    values = finding.parameters
    assert values["heated"].value == 1.0
    for name, cold in (("dFc", COULOMB), ("dFv", VISCOUS)):
        true = LOSS * cold[JOINT] / POWER
        assert abs(values[name].value - true) < 4.0 * values[name].std_error, name
        assert values[name].random < 0.02 * true
    assert values["T"].value == pytest.approx(T, rel=0.01)
    assert finding.rms_after[JOINT] < 1.1 * found[0].noise_floor[JOINT]


@pytest.mark.long  # effects/test_warm_up has the heat, test_rubbing a search
def test_heat_and_friction_agree_in_the_model(found):
    """Friction that heats is friction that heat has left over: a fixed point."""
    diagnosis, runs = found
    model = diagnosis.model
    run = prepare(runs["valid_a"], model.robot, model.cutoff, model.shift)
    seen = model.contextualise(run.context)
    own = sum(
        t.torque(seen)[:, JOINT]
        for t in model.terms
        if t.effect_id in ("coulomb", "viscous", "thermal_friction")
    )
    assert seen.rubbing[:, JOINT] == pytest.approx(own, abs=0.02 * np.abs(own).max())
    t, q, dq, ddq = motion(402)
    assert np.ptp(lost(t, q, dq, ddq)[:, JOINT]) > 20 * 0.02 * np.abs(own).max()
