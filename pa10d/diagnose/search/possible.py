"""A finding that is, by another name, what the search holds at none.

Of what no joint has less of than none a search may hold all at none. Another effect together with
bodies may be the very same torque: on two parallel axes a rotor that turns with both is a link's
inertia less both rotors'. It then asks for what no joint has, by way of a link that cannot be.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.constants import ABSORBED, MATERIAL_GAIN
from pa10d.diagnose.regression.partial import normal_equations
from pa10d.diagnose.regression.state import SearchState
from pa10d.identify.feasibility import nearest_feasible

Array = NDArray[np.float64]


def through_impossible_bodies(before: SearchState, after: SearchState) -> bool:
    """Is the last term of ``after`` what is held at none, as other bodies would have it, and do
    possible ones not follow it as far as those of ``before`` follow theirs?"""
    if after.free is None or not _absorbed_if_free(after):
        return False
    return bool(np.any(_cost(after) > (1.0 + MATERIAL_GAIN) * _cost(before)))


def _absorbed_if_free(state: SearchState) -> bool:
    """Does the model absorb the last term where nothing is held at none?"""
    index = len(state.terms) - 1
    free, columns = state.free, state.blocks[index][0]
    if free is None:
        return False
    left, _ = normal_equations(free.without(state.place(index)), columns)
    own = sum(np.sum((c / free.sigma[j]) ** 2, axis=0) for j, c in columns.items())
    return bool(np.all(np.diag(left) <= ABSORBED * own))


def _cost(state: SearchState) -> Array:
    """(n,) times what the fit leaves that the nearest possible arm leaves."""
    fit = state.fit
    near = nearest_feasible(
        fit.triangle, fit.target, state.unknowns, state.model.robot, state.rms_of
    )
    return near.rms / np.maximum(state.rms_of(fit.beta), 1e-300)
