"""A torque whose channel shows next to nothing is no torque of none: it says nothing of the arm,
and nothing is said of its joint."""

from __future__ import annotations

import numpy as np
import pytest
from synthetic import estimates, fourier, pa10_truth, recording

from pa10d.compare import compare
from pa10d.diagnose.regression.sides import two_sides
from pa10d.identify import identify
from pa10d.judgement import in_band, judge
from pa10d.measurement.clipped import clipped, shows_nothing

NOISE = 0.05


def dulled(run, joint):
    """Its amplifier counts in steps that the torque hardly ever reaches."""
    tau = run.tau.copy()
    step = 0.8 * min(tau[:, joint].max(), -tau[:, joint].min())
    tau[:, joint] = 0.0 + np.trunc(tau[:, joint] / step) * step
    return type(run)(run.name, run.t, run.q, tau)


@pytest.fixture(scope="module")
def seen():
    """Truth, the run with the second of two torques dulled, and the model of it."""
    truth = pa10_truth(2)
    rng = np.random.default_rng(1)
    motion = fourier(2, 12.0, 100.0)
    run = dulled(recording(truth, motion, rng.normal(0, NOISE, (1200, 2))), 1)
    return truth, run, identify([run], truth.robot, name="m0")


def test_a_channel_that_mostly_shows_one_value_while_its_joint_moves_shows_nothing():
    t = np.linspace(0.0, 20.0, 2000)
    torque = np.trunc(1.1 * np.sin(3.0 * t))
    assert shows_nothing(np.sin(t), torque)
    assert not shows_nothing(0.0 * t, torque), "at rest, nobody asks"
    assert not shows_nothing(np.sin(t), 0.0 * t), "nothing drives it"
    assert not shows_nothing(np.sin(t), np.trunc(5.0 * np.sin(3.0 * t))), "coarse, but it shows"


def test_it_is_known_nowhere(seen):
    assert clipped(seen[1].q, seen[1].tau)[:, 1].all()
    assert not clipped(seen[1].q, seen[1].tau)[:, 0].any()


def test_the_other_joint_is_fitted_as_if_it_were_not_there(seen):
    truth, run, model = seen
    own = [term for term in model.terms if term.joints == (0,)]
    rubs = {term.effect_id: float(term.coefficients[0]) for term in own}
    assert rubs["coulomb"] == pytest.approx(truth.coulomb[0], rel=0.02)
    assert rubs["viscous"] == pytest.approx(truth.viscous[0], rel=0.02)
    assert judge(model, [run]).rms[0] < 1.5 * NOISE
    assert np.isfinite(estimates(model)).all()
    said = " ".join(model.notes.warnings)
    assert "joint 2: its torque is known nowhere in these runs" in said
    assert "coulomb J2" not in said, "no motion would show it"


def test_nothing_is_said_of_its_joint(seen):
    _, run, model = seen
    (told,) = compare(model, [run]).runs
    assert any("The torque of joint 2 is known nowhere" in line for line in told.spread)
    assert not [place for place in told.where if place.joint == 1]
    _, held, _ = two_sides(in_band(model), [run], [])
    assert "joint 2 has a torque that is known nowhere" in held.silent[1]
