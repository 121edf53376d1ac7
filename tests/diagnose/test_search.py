"""What a forward search weighs: which variant of an effect holds, and what counts as harm."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from two_links import V0, recordings, robot, state_of, textbook

from pa10d.diagnose.asked.one_effect import add
from pa10d.diagnose.constants import MUCH_WORSE
from pa10d.diagnose.evidence.held_out import judge
from pa10d.diagnose.procedure import diagnose
from pa10d.diagnose.regression.partial import PartialFit
from pa10d.diagnose.search.candidates import Candidate, held_columns, scan
from pa10d.diagnose.search.harm import harmful, less_likely, rms
from pa10d.diagnose.search.judging import JudgedCandidate, Judging
from pa10d.diagnose.search.looking import evidence_of
from pa10d.diagnose.search.refining import refine
from pa10d.diagnose.search.steps import Search
from pa10d.effects import effect
from pa10d.effects.base import smooth_sign

BUMP, CENTRE, WIDTH, OFFSET = 1.5, 0.3, 0.25, 2.0


def rough_spot(t, q, dq, ddq):
    """Friction that rises around one angle of joint 2, beside an offset that hides it."""
    rise = BUMP * np.exp(-0.5 * ((q[:, 1] - CENTRE) / WIDTH) ** 2)
    torque = rise * smooth_sign(dq[:, 1], V0) + OFFSET
    return np.column_stack([np.zeros(len(t)), torque])


@pytest.fixture(scope="module")
def rough():
    return recordings(3, rough_spot)


def test_both_variants_are_looked_at_where_the_fit_side_leaves_it_open(rough):
    found = scan(state_of(rough), [(effect("position_friction"), (1,))])
    assert {c.shape["wave"] for c in found} == {0.0, 1.0}
    assert found[0].gain >= found[1].gain > 0


def test_a_variant_that_explains_next_to_nothing_is_not(rough):
    def stop(t, q, dq, ddq):
        pushed = 40.0 * np.maximum(q[:, 1] - 0.5, 0.0)
        return np.column_stack([np.zeros(len(t)), pushed])

    found = scan(state_of(recordings(4, stop)), [(effect("contact"), (1,))])
    assert [c.shape["side"] for c in found] == [1.0]


@pytest.mark.long
def test_the_right_one_is_added_beside_what_hid_it(rough):
    fit, held = [rough["fit_a"], rough["fit_b"]], [rough["valid_a"], rough["valid_b"]]
    found = diagnose(textbook(rough), fit, held)
    spot = next(f for f in found.findings if f.term.effect_id == "position_friction")
    assert spot.term.joints == (1,)
    assert not spot.term.shape["wave"]
    assert spot.parameters["qc"].value == pytest.approx(CENTRE, abs=0.03)
    assert len(found.findings) == 2  # the offset, or what is alike on this motion, is the other


@pytest.fixture(scope="module")
def clean():
    return state_of(recordings(5))


def bent(state, joint: int, by: np.ndarray):
    """A copy of which one joint's error held out is another by ``by`` (m_j,) N·m, while the other
    joint's has fallen to a third."""
    after = state.copy()
    now = state.held_residual()
    told = {j: r / 3.0 for j, r in now.items()} | {joint: now[joint] + by}
    object.__setattr__(after, "held_residual", lambda fit=None: told)
    return after


def test_a_rise_that_noise_explains_is_no_harm(clean, monkeypatch):
    """Held against the fit's own doubt: as large as what its parameters may be off by."""
    monkeypatch.setattr(type(clean), "moving_rms", lambda self: np.ones(robot().n))
    rng = np.random.default_rng(1)
    size = rms(clean.held_residual())[0]
    worse = bent(clean, 0, 0.9 * size * rng.standard_normal(len(clean.held_residual()[0])))
    assert rms(worse.held_residual())[0] > (1.0 + MUCH_WORSE) * size
    assert harmful(clean, worse)
    worse.fit = replace(worse.fit, to_beta=300.0 * worse.fit.to_beta)
    assert not harmful(clean, worse)


def test_errors_that_grow_on_the_whole_are_harm_however_unsure(clean, monkeypatch):
    monkeypatch.setattr(type(clean), "moving_rms", lambda self: np.ones(robot().n))
    worse = bent(clean, 0, 3.0 * clean.held_residual()[0])
    worse.fit = replace(worse.fit, to_beta=300.0 * worse.fit.to_beta)
    assert harmful(clean, worse)


def test_what_one_equation_shifts_elsewhere_is_no_reason_to_choose_it(clean):
    """Of an effect of one joint, only what that joint gains counts; of one of all joints, all."""
    held = clean.held_residual()
    own, everywhere = effect("torque_offset"), effect("joint_elasticity")
    partial = PartialFit(np.eye(1), np.zeros(1), np.zeros((1, 1)), np.zeros(1), 5.0, True)
    found = judge(clean.held, held, {0: 0.5 * held[0], 1: 0.5 * held[1]})
    one = JudgedCandidate(Candidate(own, (0,), {}, partial), found, 0.0)
    all_of_them = JudgedCandidate(Candidate(everywhere, (0,), {}, partial), found, 0.0)
    each = [0.75 * len(held[j]) for j in range(2)]
    assert one.gain == pytest.approx(5.0 + each[0])
    assert all_of_them.gain == pytest.approx(5.0 + sum(each))
    assert found.gain == pytest.approx(sum(each))


def test_what_a_joint_always_lacked_says_nothing_of_a_change(clean):
    """A base that leans suits what joint 1 keeps, which is no more than it usually does: nothing of
    it speaks for the change, whatever joint 2 has to say."""
    state = clean.copy()
    state.usual = np.array([1e3, 0.0])
    leans = (effect("base_tilt"), ())
    (tilt,) = scan(state, [leans])
    judged = []
    for part in (0.0, 1.0):
        change = held_columns(state, tilt)[0][:, 0]
        alike = bent(state, 0, part * change)
        judging = Judging(alike, [leans], len(state.terms))
        judged += evidence_of(judging, [tilt], 1)
    as_it_is, suiting = judged
    assert as_it_is.speaks_on == [1]
    assert suiting.evidence.p_value == pytest.approx(as_it_is.evidence.p_value)
    assert suiting.p_corrected == pytest.approx(as_it_is.p_corrected)
    assert suiting.gain == pytest.approx(as_it_is.gain)


def test_what_moving_a_model_did_to_a_joint_is_no_change(clean):
    """Moved within its doubt it leaves more there than a change would need, and as it was given no
    more than usual: offsets of a wrist were named that hid the one that had come."""
    state = clean.copy()
    left = rms(state.held_residual())
    state.usual, state.as_given = 0.5 * left, left * [0.4, 2.0]
    judging = Judging(state, [], len(state.terms))
    for joint, speaks in ((0, []), (1, [1])):
        (candidate,) = scan(state, [(effect("torque_offset"), (joint,))])
        (judged,) = evidence_of(judging, [candidate], 1)
        assert judged.speaks_on == speaks


def test_a_candidate_that_does_not_hold_once_added_leaves_the_model_as_it_was(clean):
    """Nothing is hidden: whatever is pushed in is pruned, and the search must not keep a trace."""
    search = Search(clean.copy(), [(effect("torque_offset"), (1,))], len(clean.terms))
    before = search.state.fit.beta.copy()
    best = search.best(*search.suspects[0])
    assert best is not None
    change = {j: np.zeros_like(r) for j, r in search.state.held_residual().items()}
    found = judge(search.state.held, search.state.held_residual(), change)
    assert search.take(JudgedCandidate(best, found, 0.0, change)) is None
    assert len(search.state.terms) == len(clean.terms)
    np.testing.assert_array_equal(search.state.fit.beta, before)


@pytest.mark.long
def test_what_is_added_to_two_joints_goes_to_the_state_that_the_search_goes_on_with(monkeypatch):
    """A pruned trial leaves it with a copy: once the second joint's effect was lost with it."""
    runs = recordings(4, extra=lambda t, q, dq, ddq: np.column_stack([1.5 + 0 * t, -1.0 + 0 * t]))
    settle = Search.settle

    def with_a_copy(self, *args, **more):
        found = settle(self, *args, **more)
        self.state = self.state.copy()
        return found

    monkeypatch.setattr(Search, "settle", with_a_copy)
    fit, held = ([runs[f"{kind}_{part}"] for part in "ab"] for kind in ("fit", "valid"))
    made, warnings = add(textbook(runs), "torque_offset", [0, 1], fit, validate=held, name="m1")
    assert made.change == "added torque_offset J1, torque_offset J2"
    assert warnings == []


def test_a_corner_is_not_rounded_by_guesswork():
    """On motion that hardly creeps the data cannot tell how sharp a friction sign is."""
    state = state_of(recordings(8))
    coulomb = next(i for i, t in enumerate(state.terms) if t.effect_id == "coulomb")
    sharp = state.terms[coulomb].shape["v0"]
    refine(state, len(state.terms), coulomb)
    assert state.terms[coulomb].shape["v0"] == sharp


def test_a_corner_that_is_clearly_too_blunt_is_made_sharper():
    state = state_of(recordings(8))
    coulomb = next(i for i, t in enumerate(state.terms) if t.effect_id == "coulomb")
    blunt = 8.0 * state.terms[coulomb].shape["v0"]
    state.replace_term(coulomb, replace(state.terms[coulomb], shape={"v0": blunt}))
    state.refit()
    refine(state, len(state.terms), coulomb)
    assert state.terms[coulomb].shape["v0"] < 0.5 * blunt


@given(st.lists(st.floats(0.01, 100.0), min_size=1, max_size=7))
def test_errors_that_came_cannot_be_as_welcome_as_those_that_went(ratios):
    """Of an arm that went from one model to another, and back, one way is worse."""
    ratio = np.array(ratios)
    assert not (less_likely(ratio) and less_likely(1.0 / ratio))


def test_one_joint_that_shared_bodies_left_does_not_outweigh_the_others():
    """A real arm's second joint went from 0.95 to 0.42 N·m, three others along with it."""
    assert not less_likely(np.array([0.80, 0.45, 0.69, 0.55, 2.47, 1.07, 1.29]))
    assert less_likely(np.array([1.0, 0.98, 1.2]))
