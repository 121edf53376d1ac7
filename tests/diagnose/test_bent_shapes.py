"""A shape that another effect of its joint draws to the end of its range."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from two_links import V0, recordings, state_of, textbook

from pa10d.diagnose.procedure import diagnose
from pa10d.diagnose.regression.partial import partials
from pa10d.diagnose.search.candidates import Candidate
from pa10d.diagnose.search.judging import Judging
from pa10d.diagnose.search.looking import bent_rivals, evidence_of, look
from pa10d.diagnose.search.pairs import pair_beside
from pa10d.diagnose.search.suspects import suspicion
from pa10d.effects import effect
from pa10d.effects.base import smooth_sign

FRICTION = [*suspicion(("stribeck", ()), 2), *suspicion(("nonlinear_viscous", ()), 2)]


def rubbing(power=0.0, bump=0.0):
    """extra(t, q, dq, ddq) -> (N, 2) N·m: the first joint's friction grows with its speed to the
    2.2, and is higher below 0.25 rad/s."""

    def extra(t, q, dq, ddq):
        v = np.abs(dq[:, 0])
        along = power * v**2.2 + bump * np.exp(-((v / 0.25) ** 2))
        return np.outer(along * smooth_sign(dq[:, 0], V0), [1.0, 0.0])

    return extra


@pytest.fixture(scope="module")
def both():
    return recordings(3, rubbing(power=0.35, bump=1.2), 0.1)


@pytest.mark.long
def test_two_bends_of_one_curve_are_both_named(both):
    """Each alone took the other's part as far as its shape goes, and was refused as no more what it
    is called: the joint was told as one that no effect of the library explains."""
    sides = [both["fit_a"], both["fit_b"]], [both["valid_a"], both["valid_b"]]
    found = diagnose(textbook(both), *sides)
    named = {(f.term.effect_id, f.term.joints): f.parameters for f in found.findings}
    assert set(named) == {("nonlinear_viscous", (0,)), ("stribeck", (0,))}
    assert np.all(found.left.ratio < 1.2)
    known = {"nonlinear_viscous": {"p": 2.2}, "stribeck": {"Fs": 1.2, "vs": 0.25}}
    for (kind, _), parameters in named.items():
        for name, true in known[kind].items():
            value = parameters[name]
            assert value.value == pytest.approx(true, abs=3 * value.std_error)
            assert value.std_error < 0.5 * true


@pytest.mark.long
def test_neither_would_be_told_alone(both):
    state = state_of(both)
    judging = Judging(state, FRICTION, len(state.terms))
    good, judged = look(judging)
    assert not good
    assert {j.place for j in judged if j.bent} == {("nonlinear_viscous", (0,)), ("stribeck", (0,))}
    pair = pair_beside(judging, judged)
    assert pair is not None
    assert len(pair.state.terms) == len(state.terms) + 2
    assert pair_beside(judging, judged, {j.place for j in judged}) is None


def test_one_bend_is_no_pair():
    """A power beyond the range of the law is bent, too, and needs no other effect beside it."""
    runs = recordings(3, lambda t, q, dq, ddq: 0.3 * np.abs(dq) ** 3.4 * np.sign(dq) * [1.0, 0.0])
    state = state_of(runs)
    judging = Judging(state, FRICTION, len(state.terms))
    _, judged = look(judging)
    assert any(j.bent for j in judged)
    assert pair_beside(judging, judged) is None


def as_shaped(state, kind, shape):
    """The effect on the first joint, of that shape, as the fit side has it."""
    columns = state.train.columns(effect(kind), (0,), [shape])
    (found,) = partials(state.fit, columns, effect(kind), 1, falls=False)
    return Candidate(effect(kind), (0,), shape, found)


@pytest.mark.by_default("0.6")
@pytest.mark.parametrize(("vs", "rivals"), [(0.6, ["nonlinear_viscous"]), (0.05, [])])
def test_a_wide_bump_is_told_with_the_curve_that_it_may_be(vs, rivals):
    """Drift had drawn the power to the end of its range: there it left more on the held-out side
    than the bump, and was no rival of it; inside its range it left as little."""
    state = state_of(recordings(3, rubbing(power=0.35), 0.1))
    judging = Judging(state, FRICTION, len(state.terms))
    drawn = as_shaped(state, "nonlinear_viscous", {"p": 3.5})
    chosen = as_shaped(state, "stribeck", {"vs": vs, "delta": 2.0})
    judged = evidence_of(judging, [chosen, drawn], 2)
    found = bent_rivals(judging, judged[0], judged)
    assert [j.candidate.effect.id for j in found] == rivals
    assert not any(j.candidate.effect.bent(j.candidate.shape) for j in found)


def dragged(t, q, dq, ddq):
    """(N, 2) N·m: a loom on the second joint that gives over 0.3 rad (Dahl's equation)."""
    z, state = np.zeros(len(t)), 0.0
    for k in range(1, len(t)):
        dx = q[k, 1] - q[k - 1, 1]
        state += dx - abs(dx) * state / 0.3
        z[k] = state
    return np.outer(2.0 * z / 0.3, [0.0, 1.0])


@pytest.mark.long
def test_a_law_that_was_refined_to_the_end_of_its_range_is_told():
    """Found inside it, it was refused once refined, and a map of half as much stood there."""
    runs = recordings(3, dragged, 0.1)
    sides = [runs["fit_a"], runs["fit_b"]], [runs["valid_a"], runs["valid_b"]]
    found = diagnose(textbook(runs), *sides, only=("presliding_hysteresis", (1,)))
    (said,) = found.unexplained
    assert (said.witness, said.law) == ("law", "pre-sliding hysteresis with zs = 0.2 rad")
    assert said.law in found.remaining[1].sentence


def test_a_gain_that_hides_behind_what_else_its_joint_lacks_comes_in_with_it():
    """Alone a gain of 15 % made motion held out worse, and asymmetric friction, too: saturation was
    named, at 16 times the noise."""

    def asymmetric(t, q, dq, ddq):
        return np.column_stack([0.0 * t, 1.0 + 0.6 * np.abs(dq[:, 1])])

    gains = np.array([1.0, 1.15])
    runs = {n: replace(run, tau=run.tau * gains) for n, run in recordings(0, asymmetric).items()}
    state = state_of(runs)
    asked = [(effect(name), (1,)) for name in ("torque_gain", "coulomb_asymmetry")]
    judging = Judging(state, asked, len(state.terms))
    _, judged = look(judging)
    alone = [one for one in judged if one.place == ("torque_gain", (1,))]
    assert not any(one.acceptable for one in alone)
    pair = pair_beside(judging, alone)
    assert {one.place[0] for one in pair.found} == {"torque_gain", "coulomb_asymmetry"}
    assert pair_beside(judging, []) is None
