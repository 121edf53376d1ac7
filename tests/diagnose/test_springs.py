"""A spring within the band of the motion is named, though rigid bodies have bent to its swing."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from how_often import how_often
from springs_in_band import spring_arm
from two_links import COULOMB, ROTOR, V0, VISCOUS, motion, robot, state_of

from pa10d.diagnose.regression.flexible import Flexible, JointSpring, _thinned
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.springs import _with_spring
from pa10d.diagnose.search.steps import Search
from pa10d.diagnose.search.suspects import suspects
from pa10d.diagnose.search.with_numbers import needed_beside_springs
from pa10d.dynamics import inverse_dynamics
from pa10d.effects import effect
from pa10d.effects.base import smooth_sign
from pa10d.measurement.recording import Recording
from pa10d.model import Term

STIFFNESS = 9.0  # N·m/rad at the second joint: its link swings at some 1.8 Hz, moved at up to 0.9
DAMPING = 0.05  # N·m·s/rad
NOISE = 0.02
NAMES = ("fit_a", "fit_b", "valid_a", "valid_b")


def a_run(name: str, seed: int) -> Recording:
    """The links' motion is drawn; the second motor is ahead of its link by what winds its spring,
    K·δ + C·δ̇ = load: load over stiffness, less C/K times its rate, and so on."""
    t, q, dq, ddq = motion(seed)
    load = inverse_dynamics(robot(), robot().parameters, q, dq, ddq)
    rates = [load[:, 1]]
    for _ in range(5):
        rates.append(np.gradient(rates[-1], t[1] - t[0]))
    motor = [x.copy() for x in (q, dq, ddq)]
    for order, x in enumerate(motor):
        for later in range(4):
            x[:, 1] += (-DAMPING / STIFFNESS) ** later * rates[order + later] / STIFFNESS
    sign = np.column_stack([smooth_sign(v, V0) for v in motor[1].T])
    tau = load + ROTOR * motor[2] + COULOMB * sign + VISCOUS * motor[1]
    noise = NOISE * np.random.default_rng(seed).standard_normal(tau.shape)
    return Recording(name, t, motor[0], tau + noise)


@pytest.fixture(scope="module")
def state() -> SearchState:
    """Rigid bodies, fitted to runs that begin in full swing (what rings of that moves K a bit)."""
    return state_of({name: a_run(name, seed) for seed, name in enumerate(NAMES)})


@pytest.mark.by_default("1.04-0.09")
@pytest.mark.parametrize(("stiffer", "damping"), [(1.3, 0.05), (1.04, 0.09), (2.3, 0.8)])
def test_bodies_and_spring_are_fitted_at_once(state, stiffer, damping):
    """From another spring and from bodies that are off by a fifth, to the noise."""
    beta, true = state.fit.beta.copy(), state.model.base.of(robot().parameters)
    beta[: len(true)] = true * np.where(np.arange(len(true)) % 2, 1.2, 0.8)
    start = JointSpring(1, stiffer * STIFFNESS, damping, 0.0)
    found = Flexible(state, [1]).fit(beta, (start,), 20)
    assert found.springs[0].stiffness == pytest.approx(STIFFNESS, rel=0.003)
    assert found.springs[0].damping == pytest.approx(DAMPING, rel=0.05)
    assert found.left < np.log([1.03 * NOISE, 1.03 * NOISE]).sum()


@pytest.mark.parametrize("at", [1000, 1001, 1002])
def test_a_jolt_between_the_samples_that_are_kept_is_not_lost(at):
    """Every third sample alone had none of it, or three times as much: a damping of 600 was told as
    3030, at 2.3 times the floor."""
    jolt = np.zeros((3000, 1))
    jolt[at] = 1.0
    assert 3.0 * np.sum(_thinned(jolt, 500.0, 3)) == pytest.approx(1.0, abs=1e-6)


def test_noise_above_what_fewer_samples_show_does_not_come_back_in_their_band():
    t = np.arange(3000) / 500.0
    motion, noise = np.sin(2 * np.pi * 9.0 * t), np.sin(2 * np.pi * 160.0 * t)  # 6.7 Hz by folding
    found = _thinned((motion + noise)[:, None], 500.0, 3)[:, 0]
    assert found[50:-50] == pytest.approx(motion[::3][50:-50], abs=1e-3)


def test_how_the_torque_changes_is_its_difference(state):
    """With the spring, and with how its link begins, which winds by half a radian."""
    flexible, step = Flexible(state, [1]), 1e-4
    spring = JointSpring(1, STIFFNESS, 0.1, 0.0, (0.5, 2.0) * 2)
    beta, true = state.fit.beta.copy(), state.model.base.of(robot().parameters)
    beta[: len(true)] = true
    slopes = flexible._slopes((spring,), flexible._swings(beta, (spring,)))

    def torque(**moved):
        other = replace(spring, **moved)
        return flexible._torque(beta, (other,), flexible._swings(beta, (other,)))

    ends = [np.exp(step), np.exp(-step)]
    wound = np.array(spring.wound)
    tried = {
        0: [torque(stiffness=STIFFNESS * e) for e in ends],
        1: [torque(damping=0.1 * e) for e in ends],
        3: [torque(wound=tuple(wound + x * np.eye(4)[0])) for x in (step, -step)],
        4: [torque(wound=tuple(wound + x * np.eye(4)[1])) for x in (step, -step)],
    }
    for column, (more, less) in tried.items():
        for j, found in slopes.items():
            difference = (more[j] - less[j]) / (2 * step)
            error = np.linalg.norm(found[:, flexible.size + column] - difference)
            assert error < 0.02 * np.linalg.norm(difference)


@pytest.mark.long
def test_what_a_spring_left_before_it_was_refined_is_not_named_beside_it(state):
    """Stribeck friction of 0.01 N·m was, which "the model without it lacks": 6.2 N·m."""
    spring = JointSpring(1, 1.1 * STIFFNESS, 0.05, 0.0)
    beta, true = state.fit.beta.copy(), state.model.base.of(robot().parameters)
    beta[: len(true)] = true
    _, found = _with_spring(state, effect("joint_elasticity"), [(beta, spring)])
    found.push(Term("stribeck", (1,), np.zeros(1), {"vs": 0.1, "delta": 2.0}))
    found.refit()
    search = Search(found, suspects(False, 2), len(state.terms))
    needed_beside_springs(search)
    assert [t.label for t in search.state.terms[search.fixed :]] == ["joint_elasticity J2"]


@pytest.mark.long
def test_a_spring_is_named_where_bodies_have_bent_to_its_swing(state):
    """One that did not hold before is followed again when nothing else is left, not sooner."""
    search = Search(state, suspects(False, 2), len(state.terms), followed={0, 1})
    other = SimpleNamespace(candidate=SimpleNamespace(gain=0.0))
    assert search.spring_beside([other]) is None
    chosen, rivals = search.spring_beside([])
    assert chosen.place == ("joint_elasticity", (1,))
    assert chosen.candidate.shape["K"] == pytest.approx(STIFFNESS, rel=0.1)
    assert not rivals


@pytest.mark.long
@pytest.mark.timeout(3600)
def test_nine_of_ten_springs_within_the_band_are_named(pytestconfig):
    trials, right = how_often(pytestconfig, 10, 10), 0
    for seed in range(301, 301 + trials):
        spring, arm = spring_arm(seed)
        found = arm.diagnose()
        said = [(f.term.effect_id, f.term.joints) for f in found.findings[:1]]
        said += [(c.effect, c.joints) for f in found.findings[:1] for c in f.confounded_with]
        right += ("joint_elasticity", (spring.joint - 1,)) in said
    assert right >= 0.9 * trials
