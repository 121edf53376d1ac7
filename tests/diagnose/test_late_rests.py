"""A torque that is measured late tells of a rest when its joint moves on already, and of less of a
rotor than there is."""

from __future__ import annotations

from functools import cache

import numpy as np
from two_links import CUTOFF, NAMES, RATE, motion, robot, state_of, textbook_torque

from pa10d.diagnose.search.lateness import with_delays_followed
from pa10d.diagnose.search.steps import Search
from pa10d.judgement.judge import mask_of
from pa10d.judgement.residuals import residual_of
from pa10d.measurement.recording import Recording
from pa10d.model import Term
from pa10d.regression.equation import prepare
from pa10d.regression.shared_surfaces import late_joints, where_known

LATE = 0.03  # s


@cache
def runs():
    """The torque of joint 2 is late."""
    out = {}
    for number, name in enumerate(NAMES):
        t, q, dq, ddq = motion(700 + number)
        tau = textbook_torque(q, dq, ddq)
        tau[:, 1] = np.interp(t - LATE, t, tau[:, 1])
        tau += 0.05 * np.random.default_rng(number).standard_normal(tau.shape)
        out[name] = Recording(name, t, q, tau)
    return out


def delay(late: float) -> Term:
    return Term("torque_delay", (1,), np.array([late]), {"at": late})


def equation():
    return prepare(runs()["valid_a"], robot(), CUTOFF, stands=False)


def test_moments_after_a_rest_are_out_of_the_late_joints_equation():
    plain = equation()
    seen = where_known(plain, [delay(LATE)])
    assert np.array_equal(seen.going[:, 0], plain.going[:, 0])
    begun = np.flatnonzero(np.diff((plain.going[:, 1] == 0.0).astype(int)) == 1)
    over = np.flatnonzero(np.diff((plain.going[:, 1] == 0.0).astype(int)) == -1)
    later = np.flatnonzero(np.diff((seen.going[:, 1] == 0.0).astype(int)) == -1)
    assert np.all(seen.going[begun - 1, 1] == plain.going[begun - 1, 1]), "not before it"
    assert (later - over[: len(later)]).max() >= 4 * LATE * RATE - 1
    assert where_known(seen, [delay(LATE)]) is seen
    assert where_known(plain, []) is plain


def test_which_samples_count_is_said():
    assert late_joints([delay(LATE)]) == (1,)
    state = state_of(runs())
    given = mask_of([residual_of(state.model, equation())])
    state.push(delay(LATE))
    state.refit()
    told = mask_of([residual_of(state.model, equation())])
    assert "late" not in given
    assert told == f"{given}, joint 2 once its late torque tells of no rest any more"


def test_a_delay_is_followed_to_where_it_leaves_least():
    """By turns, the torque and how late it is, a fit stayed at a fifth of it and less."""
    state = state_of(runs())
    fixed = len(state.terms)
    state.push(delay(LATE / 5.0))
    state.refit()
    state = state.where_known()
    state.replace_term(fixed, delay(LATE / 5.0))
    followed = with_delays_followed(state, fixed)
    assert abs(followed.terms[fixed].coefficients[0] - LATE) < 0.05 * LATE
    assert np.all(followed.fit.rms() < 1.02 * 0.05)


def test_moments_come_back_once_no_torque_is_late_any_more():
    """A delay that stood in for what comes next is gone beside it, and so were moments that tell of
    it."""
    state = state_of(runs())
    search = Search(state.copy(), [], len(state.terms), told_of_rests=(1,))
    search.state.push(delay(LATE))
    search.state.refit()
    search.state = search.state.where_known()
    assert search.state.train.runs[0].keep[:, 1].sum() < state.train.runs[0].keep[:, 1].sum()
    search.state.drop(search.fixed)
    search.go_on_without(set(), steps=1)
    assert search.told_of_rests == ()
    assert np.array_equal(search.state.train.runs[0].keep, state.train.runs[0].keep)
