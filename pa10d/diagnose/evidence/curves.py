"""What a curve over a joint's angle, put together of effects that follow it, leaves open.

A cam, a compensator, a worn gear is none of the library's curves, but a spring, a contact and a few
ripples make up any: a ripple that was seen over few turns is a Fourier part of whatever is there.
What they leave out, gravity of the bodies behind the joint takes up, alike in every stretch of
time, so that no scatter tells of it. So a free curve as large as they are stands beside them: by
what it moves coefficients, and may move them, those are unsure (0272).
"""

from __future__ import annotations

from collections.abc import Collection, Iterable

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.constants import ANGLE_LEAST_TURNS, MAP_FINE_KNOTS
from pa10d.diagnose.regression.state import SearchState
from pa10d.model import Term

Array = NDArray[np.float64]


def parts_of_curves(terms: Iterable[tuple[int, Term]], angles: Array) -> dict[int, tuple[int, ...]]:
    """By joint: indices of those terms that may be parts of one curve over its angle, where there
    are several and a ripple among them was seen over few of its turns. angles: (N, n) rad (m)."""
    of_joint: dict[int, list[tuple[int, Term]]] = {}
    for index, term in terms:
        if term.effect.follows_angle:
            of_joint.setdefault(term.joints[0], []).append((index, term))
    return {
        j: tuple(index for index, _ in own)
        for j, own in of_joint.items()
        if len(own) > 1 and any(_few_turns(term, angles[:, j]) for _, term in own)
    }


def _few_turns(term: Term, angle: Array) -> bool:
    order = term.effect.line_order
    if not order:
        return False
    return float(term.shape[order] * np.ptp(angle) / (2.0 * np.pi)) < ANGLE_LEAST_TURNS


def angles_of(state: SearchState) -> Array:
    """(N, n) of the fit side."""
    return np.concatenate([context.q for context in state.train.contexts])


def open_to_curves(state: SearchState, found: Collection[int]) -> Array:
    """(p, p) variance of all coefficients that comes from curves which terms, of the indices
    ``found``, may only be parts of."""
    terms = [(index, state.terms[index]) for index in sorted(found)]
    out = np.zeros((len(state.fit.to_beta),) * 2)
    for joint, parts in parts_of_curves(terms, angles_of(state)).items():
        out += _of_curve(state, joint, parts)
    return out


def _of_curve(state: SearchState, joint: int, parts: tuple[int, ...]) -> Array:
    fit, train = state.fit, state.train
    torque = np.sum(
        [state.blocks[i][0][joint] @ state.terms[i].coefficients for i in parts], axis=0
    )
    runs = zip(train.runs, train.contexts, strict=True)
    angle = train.gathered([c.q[:: run.lowpass.factor, joint] for run, c in runs], joint)
    places = np.linspace(angle.min(), angle.max(), MAP_FINE_KNOTS)
    hats = [np.interp(angle, places, one) for one in np.eye(MAP_FINE_KNOTS)]
    columns = np.column_stack(hats) / fit.sigma[joint]
    seen = fit.basis[joint].T @ columns
    size = max(float(np.std(torque)), 1e-12)  # of a knot: no more than what was found there
    left = columns.T @ columns - seen.T @ seen + np.eye(len(seen.T)) / size**2
    inverse = np.linalg.inv(left)
    reach = fit.to_beta @ seen
    moved = reach @ (inverse @ (columns.T @ fit.residual[joint]))
    return np.asarray(reach @ inverse @ reach.T + np.outer(moved, moved))
