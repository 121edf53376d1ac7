"""Would this data do with a simpler effect that lies inside a finding?"""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.diagnose.constants import INSIDE, SIZED_LEVEL
from pa10d.diagnose.search.candidates import Candidate, scan, sharpened
from pa10d.diagnose.search.steps import Search
from pa10d.model import TorqueModel

Array = NDArray[np.float64]


def simpler_inside(search: Search, index: int, model: TorqueModel) -> list[Candidate]:
    """Effects of fewer columns that a finding has inside it, where what it has beyond them is zero
    by its own errors: this data would do with those."""
    state, term = search.state, search.state.terms[index]
    if len(term.joints) != 1 or term.effect.reaches_other_joints:
        return []
    (joint,), place = term.joints, model.term_slice(index)
    theta, covariance = model.terms[index].coefficients, model.covariance[place, place]
    found = []
    for kind, where in search.suspects:
        if where != term.joints or kind.shapes or kind.reaches_other_joints:
            continue
        simple = state.train.columns(kind, where, [{}])[joint]
        if may_be_simpler(theta, covariance, state.blocks[index][0][joint], simple):
            found.append((kind, where))
    bare = state.bare(index) if found else state
    return [one for pair in found for one in sharpened(bare, scan(bare, [pair]))[:1]]


def may_be_simpler(theta: Array, covariance: Array, columns: Array, simple: Array) -> bool:
    """Whether a term may as well be one of fewer columns: those lie inside its own, and what the
    term has beyond them is zero by its own errors (Wald).

    theta: (k,) coefficients with their covariance (k, k); columns: (N, k) torque of each, N·m, in
    the rows that count; simple: (N, m) of the other one
    """
    k, m = columns.shape[1], simple.shape[1]
    scale = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    inside = np.linalg.lstsq(columns * scale, simple, rcond=None)[0]
    beside = np.linalg.norm(simple - columns * scale @ inside, axis=0)
    if m >= k or (beside > INSIDE * np.linalg.norm(simple, axis=0)).any():
        return False
    turned = np.linalg.pinv(covariance / np.outer(scale, scale), hermitian=True)
    apart = theta / scale
    nearest = np.linalg.lstsq(inside.T @ turned @ inside, inside.T @ turned @ apart, rcond=None)[0]
    beyond = apart - inside @ nearest
    return bool(beyond @ turned @ beyond <= scipy.special.chdtri(k - m, SIZED_LEVEL))
