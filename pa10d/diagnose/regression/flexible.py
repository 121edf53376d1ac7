"""The whole model beside one spring in a gear, fitted by Gauss and Newton's steps.

Where a spring lets its link swing within the band of the motion, a rigid model's bodies are those
of no arm: they have bent themselves to the swing, and links thrown about by their loads lead
farther from the truth with every fit. A share r²/(1 - r²) of an error in the load comes back, r the
motion's frequency over the spring's own: more than all of it from 0.7 on. So bodies, friction and
spring are sought at once: how the link would swing with other bodies is worked out beside how it
swings, by the same equation driven by the regressor's columns instead of the load.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from pa10d.diagnose.constants import (
    ROTOR_STEP,
    SPRING_STEP,
    SPRING_WORTH,
    STEP_SHARES,
    SWING_SAMPLES,
)
from pa10d.diagnose.regression.side import Side
from pa10d.diagnose.regression.state import SearchState
from pa10d.dynamics import Robot, inverse_dynamics, regressor, typical_inertia
from pa10d.effects import Context
from pa10d.effects.rotor import LIGHTEST
from pa10d.effects.swing import Swing, driven_lag
from pa10d.measurement.signals import Lowpass
from pa10d.regression.equation import RunEquation
from pa10d.regression.per_joint import PerJoint, assembled, rms
from pa10d.regression.rests import filtered
from pa10d.regression.solution import strong
from pa10d.regression.winding import winds

Array = NDArray[np.float64]


@dataclass(frozen=True)
class JointSpring:
    """K N·m/rad, C N·m·s/rad and the inertia in kg·m² that stays on the motor's side.

    wound: (2·runs,) of each run in turn, N·m by which more is wound up than the link weighs when it
    begins, and N·m/s by which that grows; empty: every link begins at rest
    """

    joint: int
    stiffness: float
    damping: float
    rotor: float
    wound: tuple[float, ...] = ()

    def begun(self, run: int) -> tuple[float, float]:
        """How the link swings as this run begins, N·m and N·m/s."""
        return (self.wound[2 * run], self.wound[2 * run + 1]) if self.wound else (0.0, 0.0)


@dataclass(frozen=True)
class SpringFit:
    """Coefficients (p,) of the bodies and of all other terms, beside the spring; left: the sum over
    the joints of the logarithm of what is left over, N·m, and what unlikely beginnings cost."""

    beta: Array
    spring: JointSpring
    left: float


@dataclass(frozen=True)
class _Run:
    context: Context
    lowpass: Lowpass
    going: Array
    left: Array
    winds: float

    def filtered(self, raw: Array) -> Array:
        """(N, n, …) torque of all joints, as the equations have it."""
        return filtered(raw, self.lowpass, self.going, self.left)


class Flexible:
    """One side of a model with a spring at a joint; the spring's own term, if it has one, is out.

    but: index of that term
    """

    def __init__(self, state: SearchState, joint: int, but: int | None = None) -> None:
        self.joint, self.side = joint, state.train
        self.robot: Robot = state.model.robot
        self.kept = state.model.base.kept
        self.bodies = len(self.kept)
        self.rotor_in_load = joint in self.side.contexts[0].rotor_in_load
        self.runs = [
            _coarse(r, c, joint) for r, c in zip(self.side.runs, self.side.contexts, strict=True)
        ]
        self.rows = sum(len(tau) for tau in self.side.tau) / self.side.n
        places = state.unknowns.places
        chosen = [i for i in range(len(state.terms)) if i != but]
        self.others = [(places[i], state.blocks[i][0]) for i in chosen]
        self.size = state.unknowns.size

    def fit(self, beta: Array, spring: JointSpring, rounds: int) -> SpringFit | None:
        """The best that so many steps reach from there; None where the link would run away."""
        if not spring.wound:
            spring = replace(spring, wound=(0.0,) * (2 * len(self.runs)))
        found = self._torque(beta, spring)
        if found is None:
            return None
        inertia = float(typical_inertia(self.robot, self._rigid(beta))[self.joint])
        sizes = self._sizes(inertia, spring)
        left = self._left(found, spring, sizes)
        for _ in range(rounds):
            step = self._step(beta, spring, found, sizes)
            better = None
            for share in STEP_SHARES:
                moved = self._moved(spring, share, step, inertia)
                trial = beta + share * step[: self.size], moved
                torque = self._torque(*trial)
                if torque is not None and self._left(torque, trial[1], sizes) < left:
                    better = (*trial, torque)
                    break
            if better is None:
                break
            beta, spring, found = better
            before, left = left, self._left(found, spring, sizes)
            if before - left < SPRING_WORTH:
                break
        return SpringFit(beta, spring, left)

    def _sizes(self, inertia: float, spring: JointSpring) -> Array:
        """(2·runs,) N·m and N·m/s that may be wound up when a run begins; inertia: kg·m² of rotor
        and link."""
        omega = float(np.sqrt(spring.stiffness / _link(inertia, spring.rotor)))
        return np.array([run.winds * by for run in self.runs for by in (1.0, omega)])

    def _left(self, torque: PerJoint, spring: JointSpring, sizes: Array) -> float:
        unlikely = float(np.sum((np.array(spring.wound) / sizes) ** 2))
        return _left(self.side, torque) + 0.5 * unlikely / self.rows

    def _step(self, beta: Array, spring: JointSpring, torque: PerJoint, sizes: Array) -> Array:
        """(p + shapes,) Gauss and Newton's: coefficients, then what ``_moved`` takes."""
        slopes = self._slopes(beta, spring)
        sigma = {j: max(rms(self.side.tau[j] - torque[j]), 1e-12) for j in torque}
        rows = np.concatenate([slopes[j] / sigma[j] for j in torque])
        target = np.concatenate([(self.side.tau[j] - torque[j]) / sigma[j] for j in torque])
        likely = np.zeros((len(sizes), rows.shape[1]))
        likely[:, -len(sizes) :] = np.diag(1.0 / sizes)
        rows = np.concatenate([rows, likely])
        target = np.concatenate([target, -np.array(spring.wound) / sizes])
        scale = np.linalg.norm(rows, axis=0)
        scale[scale == 0] = 1.0
        both = np.column_stack([rows / scale, target])
        triangle = scipy.linalg.qr(both, mode="r", overwrite_a=True, check_finite=False)[0]
        width = len(scale)
        left, values, right = np.linalg.svd(triangle[:width, :width])
        kept = strong(values)
        seen = left[:, kept].T @ triangle[:width, width]
        return np.asarray(right[kept].T @ (seen / values[kept]) / scale)

    def _moved(self, spring: JointSpring, share: float, step: Array, inertia: float) -> JointSpring:
        """No farther than the equations are nearly linear: a rotor that takes the whole inertia in
        one step leaves a link without a mode, and no way back."""
        stiffer, damped, rotor, *wound = step[self.size :]
        farthest = ROTOR_STEP * _link(inertia, spring.rotor)
        rotor = float(np.clip(rotor, -farthest, farthest))
        longest = max(abs(stiffer), abs(damped), SPRING_STEP)
        stiffer, damped = (share * SPRING_STEP / longest * x for x in (stiffer, damped))
        return replace(
            spring,
            stiffness=spring.stiffness * float(np.exp(stiffer)),
            damping=spring.damping * float(np.exp(damped)),
            rotor=max(0.0, spring.rotor + share * rotor),
            wound=tuple(
                was + share * float(more) for was, more in zip(spring.wound, wound, strict=True)
            ),
        )

    def _torque(self, beta: Array, spring: JointSpring) -> PerJoint | None:
        """joint -> (m_j,) filtered torque on the samples that count."""
        rigid, whole = self._rigid(beta), []
        for number, run in enumerate(self.runs):
            swing = _swing(run.context, rigid, spring, number)
            if swing is None:
                return None
            torque = inverse_dynamics(self.robot, rigid, *swing.motion)
            torque[:, self.joint] += spring.rotor * swing.lag[2]
            whole.append(run.filtered(torque))
        out = {j: self.side.gathered([x[:, j] for x in whole], j) for j in range(self.side.n)}
        for place, block in self.others:
            for j, columns in block.items():
                out[j] = out[j] + columns @ beta[place]
        return out

    def _slopes(self, beta: Array, spring: JointSpring) -> PerJoint:
        """joint -> (m_j, p + 3 + 2·runs): by coefficients, ln K, ln C, rotor and beginnings."""
        rigid, whole = self._rigid(beta), []
        for number, run in enumerate(self.runs):
            swing = _swing(run.context, rigid, spring, number)
            assert swing is not None  # it was followed to get here
            columns = np.zeros((len(run.context.q), self.robot.n, self.bodies))
            regressor(self.robot, *swing.motion, self.kept, out=columns)
            moving = run.filtered(self._moving(columns, swing, spring, number))
            wide = np.zeros((*moving.shape[:2], self.bodies + 3 + 2 * len(self.runs)))
            wide[:, :, : self.bodies + 3] = moving[:, :, :-2]
            place = self.bodies + 3 + 2 * number
            wide[:, :, place : place + 2] = moving[:, :, -2:]
            whole.append(wide)
        rows = [self.side.gathered([x[:, j] for x in whole], j) for j in range(self.side.n)]
        width = self.size + rows[0].shape[1] - self.bodies
        bodies = {j: r[:, : self.bodies] for j, r in enumerate(rows)}
        shapes = {j: r[:, self.bodies :] for j, r in enumerate(rows)}
        parts = [(slice(self.bodies), bodies), (slice(self.size, width), shapes), *self.others]
        return assembled(parts, width, [len(r) for r in rows])

    def _moving(self, columns: Array, swing: Swing, spring: JointSpring, number: int) -> Array:
        """(N, n, b + 5) raw: the regressor's columns at the link, and what the link's
        own change of motion adds to each; the last two: where and how fast it begins."""
        j, b = self.joint, self.bodies
        samples, n, _ = columns.shape
        lag = swing.lag
        drives = np.zeros((samples, b + 5))
        drives[:, :b] = columns[:, j]
        drives[:, b] = -spring.stiffness * lag[0]
        drives[:, b + 1] = -spring.damping * lag[1]
        drives[:, b + 2] = -swing.motion[2][:, j] if self.rotor_in_load else 0.0
        rest = np.zeros((1, n, b))
        still = np.zeros((1, n))
        regressor(self.robot, swing.motion[0][:1], still, still, self.kept, out=rest)
        rests = drives[0].copy()
        rests[:b] = rest[0, j]
        rests[b + 1 :] = 0.0
        rests[b + 3] = 1.0
        rates = np.zeros_like(rests)
        rates[b] = -spring.begun(number)[1]
        rates[b + 4] = 1.0
        moved = driven_lag(drives, rests, rates, *swing.equation, self.runs[number].context.dt)
        out = np.zeros((samples, n, drives.shape[1]))
        out[:, :, :b] = columns
        for by, change in zip(swing.slopes, moved, strict=True):
            out -= by[:, :, None] * change[:, None, :]
        out[:, j] += spring.rotor * moved[2]
        if self.rotor_in_load:
            out[:, j, b + 2] += lag[2]
        return out

    def _rigid(self, beta: Array) -> Array:
        out = np.zeros(10 * self.robot.n)
        out[self.kept] = beta[: self.bodies]
        return out.reshape(-1, 10)


def _link(inertia: float, rotor: float) -> float:
    """kg·m² of the link, of rotor and link together."""
    return max(inertia - rotor, LIGHTEST * inertia)


def _swing(context: Context, rigid: Array, spring: JointSpring, run: int) -> Swing | None:
    wound = {**context.wound, spring.joint: spring.begun(run)}
    seen = replace(context, rigid=rigid, wound=wound)
    return Swing.of(seen, spring.joint, spring.stiffness, spring.damping, spring.rotor)


def zeta_of(state: SearchState, h: Array, spring: JointSpring) -> float:
    """Damping ratio at the link's typical inertia, with these base parameters."""
    rigid = np.zeros(10 * state.model.robot.n)
    rigid[state.model.base.kept] = h
    typical = float(typical_inertia(state.model.robot, rigid.reshape(-1, 10))[spring.joint])
    link = _link(typical, spring.rotor)
    return float(spring.damping / (2.0 * np.sqrt(spring.stiffness * link)))


def _coarse(run: RunEquation, context: Context, joint: int) -> _Run:
    """The motion on fewer samples, as many as its swing needs, with a filter that ends on the same
    samples of the equation."""
    fine = run.lowpass
    most = int(fine.rate / (SWING_SAMPLES * fine.cutoff))
    step = max(d for d in range(1, max(most, 1) + 1) if fine.factor % d == 0)
    thin = replace(
        context,
        t=context.t[::step],
        q=context.q[::step],
        dq=context.dq[::step],
        ddq=context.ddq[::step],
        total=context.total[::step],
        temperature=None,
        rubbing=None,
    )
    lowpass = Lowpass(
        len(thin.t),
        fine.rate / step,
        fine.cutoff,
        fine.factor // step,
        fine.order,
        -(-fine.blind // step),
        fine.channel,
    )
    going = np.ones_like(thin.q) if run.going is None else run.going[::step]
    return _Run(thin, lowpass, going, run.left, winds(run, joint))


def _left(side: Side, torque: PerJoint) -> float:
    return float(sum(np.log(max(rms(side.tau[j] - torque[j]), 1e-12)) for j in torque))
