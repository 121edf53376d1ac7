"""Which kind of bristles a joint has is asked again once they are known; corners have errors."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import scipy
from test_friction_on_bristles import LAG, WAY, carried, damped
from two_links import COULOMB, RATE, V0, recordings, state_of, textbook_torque

from pa10d.diagnose.outcome.found import _of_kinds
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.corners import as_unsure, turned
from pa10d.diagnose.search.harm import rms
from pa10d.diagnose.search.refitting import settled
from pa10d.diagnose.search.rivals import kinds_untold, of_another_kind
from pa10d.diagnose.search.steps import Search
from pa10d.effects import effect
from pa10d.effects.base import smooth_sign
from pa10d.measurement.signals import delayed
from pa10d.model import Term


def undamped(t, q, dq, ddq):
    rubs = carried(t, dq[:, 0], np.full(len(t), COULOMB[0]))
    dry = COULOMB[0] * smooth_sign(dq[:, 0], V0)
    return np.column_stack([rubs - dry, np.zeros(len(t))])


def on_bristles(law, seed) -> SearchState:
    """Bristles without damping are what was found."""
    state = state_of(recordings(seed, law, 0.02))
    state.push(Term("presliding_hysteresis", (0,), np.array(COULOMB[:1]), {"zs": WAY}))
    state.refit()
    return state


@pytest.mark.long
def test_bristles_that_were_taken_for_undamped_are_damped():
    """Their way was 10.78 ± 0.20 for 11.47 mrad, and their joint kept 1.8 times its noise."""
    state = on_bristles(damped, 4)
    index = len(state.terms) - 1
    found = of_another_kind(state, index, index)
    assert found.terms[index].shape["lag"] == pytest.approx(LAG, rel=0.1)
    assert rms(found.held_residual())[0] < 0.8 * rms(state.held_residual())[0]


@pytest.mark.long
def test_bristles_that_are_not_damped_stay_so():
    state = on_bristles(undamped, 4)
    assert of_another_kind(state, len(state.terms) - 1, len(state.terms) - 1) is None


def test_damped_bristles_whose_damping_is_gone_are_plain_ones():
    """They were dropped for a shape at its end, and the channel that they had stood in for with
    them: bristles of 20.15 ± 0.05 for 20 mrad, and a delay for a second order at 18 Hz."""
    state = on_bristles(undamped, 4)
    index = len(state.terms) - 1
    gone = {"zs": WAY, "damped": 1.0, "lag": 1e-4}
    state.replace_term(index, replace(state.terms[index], shape=gone))
    state.refit()
    search = Search(state, [(effect("presliding_hysteresis"), (0,))], index)
    assert search.prune() == set()
    (term,) = search.state.terms[index:]
    assert term.shape == {"zs": pytest.approx(WAY, rel=0.02)}


@cache
def softer(share: float) -> tuple[SearchState, SearchState]:
    """With the right corner of joint 1, and with one that is softer and unsure by that."""
    right = state_of(recordings(5, noise=1e-4))
    names = [(t.effect_id, t.joints) for t in right.terms]
    index = names.index(("coulomb", (0,)))
    speed = right.terms[index].shape["v0"]
    off = turned(right, index, (1.0 + share) * speed)
    unsure = replace(off.terms[index], shape_errors={"v0": share * speed})
    off.problem = off.problem.with_term(index, unsure)
    return right, off


def test_what_a_corner_is_unsure_by_is_no_finding():
    """A corner of 0.0153 ± 0.0002 for 0.0151 rad/s left enough for bristles without a number."""
    right, off = softer(0.5)
    left = rms(right.held_residual())
    assert rms(off.held_residual())[0] > 1.1 * left[0]
    found = as_unsure(off, (0,), left, left)
    assert rms(found.held_residual())[0] == pytest.approx(left[0], rel=0.02)


def test_what_it_is_surely_not_off_by_is():
    """Nor is one moved that does not do what was found."""
    right, off = softer(0.5)
    left = rms(right.held_residual())
    assert as_unsure(off, (0,), 0.9 * left, left) is None


def test_nor_is_one_that_leaves_more_than_noise():
    """Stribeck friction of a bristle had been passed over for a corner, at 18 times the floor."""
    right, off = softer(0.5)
    left = rms(right.held_residual())
    assert as_unsure(off, (0,), 2.0 * left, 0.5 * left) is None
    assert as_unsure(off, (0,), left, None) is None
    assert as_unsure(off, (0,), left, np.full(2, np.nan)) is None


def late(seconds, smoothed):
    """Joint 1's torque behind a low-pass of first order, or as much later as a whole."""
    pole = np.exp(-1.0 / RATE / seconds)

    def extra(t, q, dq, ddq):
        torque = textbook_torque(q, dq, ddq)[:, :1]
        passed = scipy.signal.lfilter([1 - pole], [1, -pole], torque, axis=0, zi=pole * torque[:1])
        moved = passed[0] if smoothed else delayed(torque, seconds, RATE)
        return np.column_stack([moved - torque, 0 * t])

    return extra


@cache
def told_late(seconds, smoothed, noise) -> SearchState:
    """A torque that is late as a whole is what was found, and settled."""
    state = state_of(recordings(6, late(seconds, smoothed), noise))
    state.push(Term("torque_delay", (0,), np.array([seconds]), {}))
    return settled(state, len(state.terms) - 1, rounds=1)


@pytest.mark.parametrize("smoothed", [True, False])
def test_whether_torque_is_late_or_smoothed_the_data_tell(smoothed):
    """A lag of 11 Hz was told as a delay of 13.5 ms, at 1.0 times the floor."""
    state = told_late(0.02, smoothed, 0.02)
    index = len(state.terms) - 1
    found = of_another_kind(state, index, index)
    assert (found is not None) == smoothed
    if found is not None:
        assert found.terms[index].shape["smoothed"] == 1.0
        assert kinds_untold(found, index, index) == []
    else:
        assert kinds_untold(state, index, index) == []


def test_and_where_they_do_not_both_are_named():
    state = told_late(0.004, True, 0.05)
    index = len(state.terms) - 1
    assert of_another_kind(state, index, index) is None
    (other,) = kinds_untold(state, index, index)
    assert _of_kinds(state.terms[index], [other]) == (
        " Whether it is late as a whole or behind a low-pass of first order, this data does not "
        f"tell; behind a low-pass of first order, Td would be {other.coefficients[0]:.3g} s."
    )
