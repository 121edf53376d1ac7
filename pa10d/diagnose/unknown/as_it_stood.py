"""What one change alone would take of a frozen model's error, all else as it stood.

A frozen model may move as far as its own doubt allows. Where that doubt is wide, a payload of a
kilogram lies within it: bodies take it up, nothing is left to be named, and yet the model as it was
given is wrong by newton metres on every joint that carries it. Whether that is a change or what
the model's own data left open, no statistics of the new data can say; that a single change would
do, they can.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.common.words import joint_words, percent
from pa10d.diagnose.constants import BROKEN_SHARE, MATERIAL_GAIN, MOVED_FAR
from pa10d.diagnose.regression.state import SearchState, Suspects
from pa10d.model import TorqueModel
from pa10d.model.unknowns import vector_of
from pa10d.regression.per_joint import PerJoint

Array = NDArray[np.float64]


@dataclass(frozen=True)
class OneChange:
    """named: the effect, as people call it; shares (n,) of each joint's squared error, as the model
    was given, that it takes on the held-out side when fitted to the fit side alone."""

    named: str
    shares: Array


def moved_far(state: SearchState, left: Array) -> NDArray[np.bool_]:
    """(n,) joints on which a frozen model was moved, within its doubt, to leave no more than it
    usually does, and left more as it was given; left (n,) N·m RMS held out, of the model without
    findings: what these explain is no such move."""
    if state.usual is None or state.as_given is None:
        return np.zeros(state.held.n, dtype=bool)
    return np.asarray(state.as_given > np.maximum(MOVED_FAR * left, state.usual))


def stood_words(given: Array, left: Array, far: NDArray[np.bool_], change: OneChange | None) -> str:
    """Of all joints that a frozen model was moved on, (n,) N·m before and after, far (n,) mask;
    empty where there is none."""
    if not far.any():
        return ""
    worst = int(np.argmax(np.where(far, given / np.maximum(left, 1e-300), 0.0)))
    alike = [j for j in np.flatnonzero(far).tolist() if j != worst]
    said = (
        f"as it was given the model leaves {given[worst]:.3g} where moving within its own doubt "
        f"it leaves {left[worst]:.3g} on joint {worst + 1}"
        + (f" ({joint_words(alike)} alike)" if alike else "")
    )
    if change is not None and change.shares[worst] >= BROKEN_SHARE:
        took = [j for j in np.flatnonzero(far).tolist() if change.shares[j] >= BROKEN_SHARE]
        said += (
            f"; {change.named} alone, all else as it was, takes {percent(change.shares[worst])} of "
            f"it, and most of it on {joint_words(took)}"
        )
    return f"{said}; that it came, or that the model's own runs left it open, other runs can tell"


def one_change(state: SearchState, given: TorqueModel, suspects: Suspects) -> OneChange | None:
    """The plainest of the changes that take nearly the most; None where none takes half of it."""
    before = _as_given(state, given)
    tried = []
    for effect, joints in suspects:
        if not all(s.smoothing or s.optional for s in effect.shapes):
            continue  # what has a shape of its own bends to what a model lacks
        shape = effect.starts(state.train.contexts[0], joints)[0]
        fit, held = (side.columns(effect, joints, [shape]) for side in (state.train, state.held))
        if any(len(c) and not np.all(np.isfinite(c)) for c in (*fit.values(), *held.values())):
            continue
        after = _without(state, before, fit, held)
        tried.append((_size(state, after), next(iter(fit.values())).shape[1], effect, after))
    whole = _size(state, before[1])
    least = min((size for size, *_ in tried), default=whole)
    if least > (1.0 - BROKEN_SHARE) * whole:
        return None
    near = [one for one in tried if one[0] <= least + MATERIAL_GAIN * whole]
    _, _, effect, after = min(near, key=lambda one: (one[1], one[0]))
    shares = [
        1.0 - float(after[j] @ after[j]) / max(float(r @ r), 1e-300) for j, r in before[1].items()
    ]
    return OneChange(effect.named, np.array(shares))


def _as_given(state: SearchState, given: TorqueModel) -> tuple[PerJoint, PerJoint]:
    """Of either side, joint -> (m_j,) N·m that the model leaves as it was given."""
    beta = vector_of(given.h, given.terms)
    bare = state.bare(len(given.terms))
    out = []
    for which, side in enumerate((state.train, state.held)):
        matrix = bare.matrix(which)
        out.append({j: side.tau[j] - matrix[j] @ beta for j in range(side.n)})
    return out[0], out[1]


def _without(
    state: SearchState, before: tuple[PerJoint, PerJoint], fit: PerJoint, held: PerJoint
) -> PerJoint:
    """Held-out errors without what columns fitted to the fit side foretell."""
    sigma = state.fit.sigma
    rows = np.concatenate([c / sigma[j] for j, c in fit.items()])
    target = np.concatenate([before[0][j] / sigma[j] for j in fit])
    theta = np.linalg.lstsq(rows, target, rcond=1e-9)[0]
    return {j: r - held[j] @ theta if j in held else r for j, r in before[1].items()}


def _size(state: SearchState, left: PerJoint) -> float:
    """Squared error of all joints, each in units of its weight, per sample."""
    means = [np.mean((r / state.fit.sigma[j]) ** 2) for j, r in left.items() if len(r)]
    return float(np.sum(means))
