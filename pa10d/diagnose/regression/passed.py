"""Where a gear may give: bodies as they fit behind springs wound by the torque that was measured.

What passes through a spring, the torque less friction and what turns the rotor, says how far it is
wound, without any load of a model that does not know the spring. Noise is wound up, too, so this
says where to look and where to begin, and is no evidence.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.constants import (
    PASSED_BAND,
    PASSED_MODES,
    PASSED_MOTION,
    PASSED_ROUNDS,
    PASSED_SAMPLES,
    PASSED_ZETA,
    SWUNG_MODES,
)
from pa10d.diagnose.regression.partial import solve_symmetric
from pa10d.diagnose.regression.state import SearchState
from pa10d.dynamics import regressor, typical_inertia
from pa10d.measurement.signals import Lowpass

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Guess:
    """A spring at a joint: K N·m/rad, C N·m·s/rad, rotor kg·m², the coefficients (p,) beside it,
    gain: the weighted squared error that it seems to take from the fit side, and drop: the share
    that the error of the joint seems to fall by that it helps most."""

    joint: int
    stiffness: float
    damping: float
    rotor: float
    beta: Array
    gain: float
    drop: float


def guesses(state: SearchState, joints: Sequence[int]) -> list[Guess]:
    """The best spring of each joint, the most promising first."""
    thin = _Thin(state)
    plain = thin.fitted(thin.rigid(thin.motion))
    links = typical_inertia(state.model.robot, state.model.robot.parameters)
    if not np.all(links > 1e-5):  # the robot's file knows no masses
        links = state.train.contexts[0].typical_inertia
    found = []
    for j in joints:
        tried = []
        for mode, band in thin.modes():
            omega = 2.0 * np.pi * mode
            tried.append(thin.guess(j, float(links[j]) * omega**2, omega, plain[1], band))
        found.append(max(tried, key=lambda g: g.gain))
    return sorted(found, key=lambda g: -g.gain)


class _Thin:
    """The fit side on a few samples: motion and torque filtered alike, then thinned out."""

    def __init__(self, state: SearchState) -> None:
        self.state, side = state, state.train
        self.kept = state.model.base.kept
        self.n = side.n
        self.motion = [
            tuple(run.lowpass(x) for x in (run.context.q, run.context.dq, run.context.ddq))
            for run in side.runs
        ]
        step = max(1, max(len(run.tau) for run in side.runs) // PASSED_SAMPLES)
        self.chosen = [np.arange(0, len(run.tau), step) for run in side.runs]
        self.keep = [k[c] for k, c in zip(side.keep, self.chosen, strict=True)]
        self.highest = max(
            highest_frequency(m[1], run.rate) for m, run in zip(self.motion, side.runs, strict=True)
        )
        self.tau = [run.tau[c] for run, c in zip(side.runs, self.chosen, strict=True)]
        self.whole = self._of_terms()
        self.terms = [x[c] for x, c in zip(self.whole, self.chosen, strict=True)]

    def rigid(self, motions: Sequence[tuple[Array, ...]]) -> list[Array]:
        """Per run (K, n, b)."""
        out = []
        for motion, chosen in zip(motions, self.chosen, strict=True):
            columns = np.zeros((len(chosen), self.n, len(self.kept)))
            q, dq, ddq = (x[chosen] for x in motion)
            regressor(self.state.model.robot, q, dq, ddq, self.kept, out=columns)
            out.append(columns)
        return out

    def fitted(self, rigid: Sequence[Array], more: Sequence[Array] = ()) -> tuple[Array, Array]:
        """Coefficients and (n,) what is left, N·m; more: per run (K, n, 1), one column more."""
        grams, sides, squares, counts = [], [], [], []
        for j in range(self.n):
            parts, targets = [], []
            for number, keep in enumerate(self.keep):
                row = [rigid[number][:, j], self.terms[number][:, j]]
                row += [more[number][:, j]] if more else []
                parts.append(np.hstack(row)[keep[:, j]])
                targets.append(self.tau[number][keep[:, j], j])
            a, y = np.concatenate(parts), np.concatenate(targets)
            grams.append(a.T @ a)
            sides.append(a.T @ y)
            squares.append(float(y @ y))
            counts.append(len(y))
        sigma = self.state.fit.rms()
        for _ in range(3):
            gram = sum(g / s**2 for g, s in zip(grams, sigma, strict=True))
            side = sum(b / s**2 for b, s in zip(sides, sigma, strict=True))
            beta = solve_symmetric(np.asarray(gram), np.asarray(side))
            left = [
                q - 2.0 * beta @ b + beta @ g @ beta
                for q, b, g in zip(squares, sides, grams, strict=True)
            ]
            sigma = np.sqrt(np.maximum(left, 1e-12) / np.maximum(counts, 1))
        return beta, sigma

    def modes(self) -> list[tuple[float, float]]:
        """Hz of a link's mode, and up to which the torque is wound: that of the motion; or that of
        a link which swings faster than it is moved, as it does after every reversal, where the
        low-pass lets it through."""
        motion = PASSED_BAND * self.highest
        swings = [self.highest * mode for mode in SWUNG_MODES]
        cutoff = min(run.lowpass.cutoff for run in self.state.train.runs)
        return [(self.highest * mode, motion) for mode in PASSED_MODES] + [
            (hertz, PASSED_BAND * hertz) for hertz in swings if hertz < cutoff
        ]

    def guess(self, j: int, stiffness: float, omega: float, plain: Array, band: float) -> Guess:
        """What a spring would bring, beside what the model leaves without it (plain, (n,)); band:
        Hz, up to which the torque is wound."""
        side, size = self.state.train, self.state.unknowns.size
        beta, rotor = self.state.fit.beta.copy(), 0.0
        shared = j in side.contexts[0].rotor_in_load
        damping = 2.0 * PASSED_ZETA * stiffness / omega
        for _ in range(PASSED_ROUNDS):
            motions, more = [], []
            for number, run in enumerate(side.runs):
                q, dq, ddq = (x.copy() for x in self.motion[number])
                rubs = self.whole[number][:, j] @ beta[len(self.kept) :]
                passed = run.tau[:, j] - rubs - rotor * ddq[:, j]
                wound = Lowpass(len(passed), run.rate, min(band, 0.4 * run.rate)).derivatives(
                    passed / stiffness
                )
                for x, lag in zip((q, dq, ddq), wound, strict=True):
                    x[:, j] -= lag
                motions.append((q, dq, ddq))
                column = np.zeros((len(self.chosen[number]), self.n, 1))
                column[:, j, 0] = wound[2][self.chosen[number]]
                more.append(column)
            found, left = self.fitted(self.rigid(motions), more if shared else ())
            beta = found[:size]
            rotor = max(float(found[size]), 0.0) if shared else 0.0
        share = 1.0 - (left / plain) ** 2
        rows = np.array([len(side.tau[i]) for i in range(self.n)])
        gain, drop = float(np.sum(rows * share)), float(1.0 - np.min(left / plain))
        return Guess(j, stiffness, damping, rotor, beta, gain, drop)

    def _of_terms(self) -> list[Array]:
        """Per run (M, n, p - b): filtered columns of all terms."""
        state = self.state
        made = [state.train.columns_of_runs(t.effect, t.joints, t.shape) for t in state.terms]
        return [np.concatenate(columns, axis=2) for columns in zip(*made, strict=True)]


def highest_frequency(velocity: Array, rate: float) -> float:
    """Hz below which nearly all of the power of velocities (M, n) lies, each by its own size."""
    power = np.abs(np.fft.rfft(velocity - velocity.mean(axis=0), axis=0)) ** 2
    share = np.cumsum(np.sum(power / np.maximum(power.sum(axis=0), 1e-300), axis=1))
    at = int(np.searchsorted(share, PASSED_MOTION * share[-1]))
    return float(max(at, 1) * rate / len(velocity))
