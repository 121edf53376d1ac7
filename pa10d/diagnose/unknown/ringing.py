"""What the motion sets swinging and what swings on after it, at a frequency of its own.

A liquid in the tool, a load on a rope, a frame that gives: what is left at an instant depends on
all that the arm did in the last few swings, so no map of the instant's motion knows of it. It is
sought as an oscillator that the joints' accelerations drive: at which frequency, and how damped, is
settled on the fit side, where it has to do better than one that does not swing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.common.parallel import shared_map
from pa10d.diagnose.constants import (
    FORETOLD_LEVEL,
    LEAST_GAIN,
    RING_DAMPING,
    RING_LEAST_TURNS,
    RING_NONE,
    RING_STEP,
)
from pa10d.diagnose.regression.side import Side
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.unknown.structure import (
    Prediction,
    evidence_of,
    motion_variables,
    noise_beside,
    of_all,
)

Array = NDArray[np.float64]
Motion = list[Array]
"""Per run (M, n) rad/s², filtered as the equation is, at its rate."""


@dataclass(frozen=True)
class SwingsOn:
    """hertz of the oscillator; share of the joint's held-out squared error that it removes; rms
    N·m of what it foretells."""

    joint: int
    hertz: float
    share: float
    rms: float
    p_value: float


def rings(state: SearchState, joints: Sequence[int]) -> list[SwingsOn]:
    """Of those of the joints whose held-out error such an oscillator foretells."""
    if not joints:
        return []
    motions = _accelerations(state.train), _accelerations(state.held)
    tried = shared_map(lambda j: _of_joint(state, motions, j), list(joints))
    found = [one for one in tried if one is not None]
    residual = state.held_residual()
    noise = noise_beside(state, residual, [prediction for _, prediction in found])
    out = []
    for hertz, p in found:
        claim = evidence_of(state, residual, p, state.train.n, noise, FORETOLD_LEVEL)
        if claim is not None:
            rms = float(np.sqrt(np.mean(p.values**2)))
            out.append(SwingsOn(p.joint, hertz, of_all(residual, p), rms, claim.p_value))
    return out


def _accelerations(side: Side) -> Motion:
    names = [f"ddq{j + 1}" for j in range(side.n)]
    return [np.column_stack([m[name] for name in names]) for m in motion_variables(side.runs)]


def _of_joint(
    state: SearchState, motions: tuple[Motion, Motion], joint: int
) -> tuple[float, Prediction] | None:
    """The oscillator that helps the fit side most, if it has to swing for that."""
    hertz = _frequencies(state)
    if not len(hertz):
        return None
    swinging = [(f, zeta) for f in hertz for zeta in RING_DAMPING]
    gains = [_fit(state, motions[0], joint, *at)[0] for at in swinging]
    most = int(np.argmax(gains))
    damped = max(_fit(state, motions[0], joint, f, RING_NONE)[0] for f in hertz)
    if gains[most] < max(damped, 0.0) + LEAST_GAIN:
        return None
    _, theta, absorbed = _fit(state, motions[0], joint, *swinging[most])
    said = swung(state.held, motions[1], joint, *swinging[most]) @ theta
    values = said - state.held_matrix[joint] @ absorbed
    inside = np.ones(len(values), dtype=bool)
    return float(swinging[most][0]), Prediction(joint, (), values, inside)


def _frequencies(state: SearchState) -> Array:
    """(k,) Hz of which the shorter of the longest stretches has some turns."""
    longest = [max(run.t[-1] - run.t[0] for run in s.runs) for s in (state.train, state.held)]
    lowest, highest = RING_LEAST_TURNS / min(longest), state.train.runs[0].lowpass.cutoff
    if lowest >= highest:
        return np.zeros(0)
    count = int(np.log(highest / lowest) / np.log(RING_STEP))
    return np.asarray(lowest * RING_STEP ** np.arange(count + 1))


def _fit(
    state: SearchState, motion: Motion, joint: int, hertz: float, zeta: float
) -> tuple[float, Array, Array]:
    """What it takes of the fit side beside the model, in units of noise; its coefficients (2n,),
    and what the model's own (p,) give back for it."""
    fit = state.fit
    columns = swung(state.train, motion, joint, hertz, zeta) / fit.sigma[joint]
    seen = fit.basis[joint].T @ columns
    own = columns - fit.basis[joint] @ seen
    theta, *_ = np.linalg.lstsq(own, fit.residual[joint], rcond=1e-6)
    gain = float(theta @ (own.T @ fit.residual[joint])) - 2.0 * len(theta)
    return gain, theta, fit.to_beta @ (seen @ theta)


def swung(side: Side, motion: Motion, joint: int, hertz: float, zeta: float) -> Array:
    """(m_j, 2n) both states of oscillators of this frequency (Hz) and damping (of the critical
    one), driven by each joint's acceleration, at rest when a run begins; in the rows of a joint."""
    omega = 2.0 * np.pi * hertz
    turn = omega * (-zeta + 1j * np.sqrt(1.0 - zeta**2))
    columns = []
    for run, ddq in zip(side.runs, motion, strict=True):
        pole = np.exp(turn / run.rate)
        state = scipy.signal.lfilter([1.0 / run.rate], [1.0, -pole], ddq, axis=0)
        columns.append(omega * np.column_stack([state.real, state.imag]))
    width = range(columns[0].shape[1])
    return np.column_stack([side.gathered([c[:, k] for c in columns], joint) for k in width])
