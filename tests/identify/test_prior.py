"""What is known of the bodies decides what the motion leaves open, and nothing else."""

from __future__ import annotations

import numpy as np
import pytest
from synthetic import estimates, fourier, pa10_truth, recording

from pa10d.common.errors import UserError
from pa10d.effects import Value
from pa10d.identify import identify
from pa10d.identify.prior import Prior
from pa10d.model.parameters import flags, parameter_list
from pa10d.regression.equation import prepare
from pa10d.regression.layout import textbook

TRUTH = pa10_truth(3)


def recorded(seed: int, moving=(True, True, True), noise: float = 0.3):
    t, q, dq, ddq = fourier(3, 12.0, 250.0, seed=seed)
    still = np.array(moving, dtype=float)
    motion = t, q * still, dq * still, ddq * still
    errors = noise * np.random.default_rng(seed).normal(size=q.shape)
    return recording(TRUTH, motion, errors, f"run {seed}")


@pytest.fixture(scope="module")
def poor():
    """One joint of three moves."""
    return recorded(3, (False, True, False))


def fitted(run, **how):
    return identify([run], TRUTH.robot, name="m", cutoff=10.0, **how)


def error_elsewhere(model) -> float:
    """N·m RMS at joint 2, whose friction is known, on a motion of all joints."""
    run = recorded(8, noise=0.0)
    told = model.predict(prepare(run, TRUTH.robot, model.cutoff).context)
    return float(np.sqrt(np.mean((told - run.tau)[500:-500, 1] ** 2)))


def test_what_the_motion_shows_is_left_as_it_is():
    run = recorded(3)
    free, told = fitted(run), fitted(run, prior=30.0)
    errors = np.sqrt(np.diag(free.covariance))[: len(free.h)]
    assert np.abs((told.h - free.h) / errors).max() < 0.2
    off = estimates(told) - TRUTH.values(told)
    assert np.abs(off / np.sqrt(np.diag(told.covariance))[: len(off)]).max() < 4.0


def test_what_the_motion_leaves_open_is_the_urdfs_give_or_take(poor):
    free, told = fitted(poor), fitted(poor, prior=30.0)
    assert error_elsewhere(free) < 0.05, "anybody has the file"
    assert error_elsewhere(told) < 0.05
    flagged = [{one.name: one.flags for one in parameter_list(model)} for model in (free, told)]
    for flag, entries in zip(("not determined", "from the prior"), flagged, strict=True):
        assert entries["my3"] == entries["Izz3"] == [flag]
        assert entries["mz3"] == entries["coulomb J2: Fc"] == []
    assert flagged[1]["rotor_inertia J3: Ia"] == ["not determined"], "no URDF knows rotors"
    assert told.notes.prior.percent == 30.0


def test_nothing_is_taken_for_known_where_a_rotor_is_one_with_its_link(poor):
    prior = Prior.of(textbook(TRUTH.robot), 10.0)
    names = [one.name for one in parameter_list(fitted(poor))]
    bases = len(prior.layout.base)
    assert [n for n, s in zip(names[:bases], prior.std_errors, strict=False) if np.isinf(s)] == [
        "Ixx2", "Izz2", "Ixx3", "Iyy3"
    ]  # fmt: skip


def test_an_impossible_prior_is_refused(poor):
    with pytest.raises(UserError, match=r"prior: found -1 %, expected more than 0"):
        fitted(poor, prior=-1.0)


def test_what_was_as_unsure_before_is_said_to_be_from_the_prior():
    assert flags(Value(0.0, 1.0, "kg"), before=1.0) == ["from the prior"]
    assert flags(Value(0.0, 0.5, "kg"), before=1.0) == ["weak"]
    assert flags(Value(9.0, 0.5, "kg"), before=1.0) == []
    assert flags(Value(9.0, 0.5, "kg"), before=None) == []
