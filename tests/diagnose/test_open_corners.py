"""A corner of dry friction that was open moves where both sides ask for it, and else stays."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import two_links

from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.corners import with_corners
from pa10d.effects.base import smooth_sign

BLUNT = 0.1


def softer(t, q, dq, ddq):
    """(N, 2) N·m by which a blunt sign of joint 1's friction differs from a sharp one."""
    out = np.zeros_like(q)
    sharp = smooth_sign(dq[:, 0], two_links.V0)
    out[:, 0] = two_links.COULOMB[0] * (smooth_sign(dq[:, 0], BLUNT) - sharp)
    return out


@cache
def runs(blunt: bool):
    return two_links.recordings(extra=softer if blunt else None)


def begun(fit: bool, held: bool) -> tuple[SearchState, int]:
    """Whose friction turns round bluntly on the fit side, on the held-out side; the model given has
    a sharp corner that its own data left open."""
    model = two_links.textbook(runs(False))
    index = [(t.effect_id, t.joints) for t in model.terms].index(("coulomb", (0,)))
    sharp = replace(model.terms[index], shape={"v0": two_links.V0}, shape_errors={})
    terms = (*model.terms[:index], sharp, *model.terms[index + 1 :])
    sides = {n: runs(fit if n.startswith("fit") else held)[n] for n in two_links.NAMES}
    return two_links.state_of(sides, replace(model, terms=terms)), index


def test_it_moves_where_both_sides_have_it():
    state, index = begun(True, True)
    assert with_corners(state).terms[index].shape["v0"] == pytest.approx(BLUNT, rel=0.1)


def test_it_stays_where_what_is_held_out_pays_for_it():
    state, index = begun(True, False)
    kept = with_corners(state).terms[index]
    assert kept.shape["v0"] == two_links.V0
    assert kept.shape_errors["v0"] == pytest.approx(BLUNT - two_links.V0, rel=0.1)


def dragging(t, q, dq, ddq):
    """(N, 2) N·m of a joint 1 whose friction is of air or oil alone: v·|v|, nothing dry."""
    out = np.zeros_like(q)
    out[:, 0] = 6.0 * dq[:, 0] * np.abs(dq[:, 0])
    out[:, 0] -= two_links.COULOMB[0] * smooth_sign(dq[:, 0], two_links.V0)
    return out


def test_friction_below_zero_is_no_corner():
    """Viscous friction less a blunt sign rises as a drag does."""
    runs = two_links.recordings(extra=dragging)
    model = two_links.textbook(runs)
    index = [(t.effect_id, t.joints) for t in model.terms].index(("coulomb", (0,)))
    open_ = replace(model.terms[index], shape={"v0": 2.0 * two_links.V0}, shape_errors={})
    terms = (*model.terms[:index], open_, *model.terms[index + 1 :])
    state = with_corners(two_links.state_of(runs, replace(model, terms=terms)))
    found = state.terms[index]
    assert found.shape["v0"] <= 2.0 * two_links.V0 or found.coefficients[0] >= 0.0


def test_what_the_given_model_knows_is_left_alone():
    state, index = begun(True, True)
    known = replace(state.terms[index], shape_errors={"v0": 0.001})
    state.problem = state.problem.with_term(index, known)
    assert with_corners(state).terms[index].shape["v0"] == two_links.V0
