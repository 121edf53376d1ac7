"""The whole model beside springs in gears, fitted by Gauss and Newton's steps.

Where a spring lets its link swing within the band of the motion, a rigid model's bodies are those
of no arm: they have bent themselves to the swing, and links thrown about by their loads lead
farther from the truth with every fit. A share r²/(1 - r²) of an error in the load comes back, r the
motion's frequency over the spring's own: more than all of it from 0.7 on. So bodies, friction and
spring are sought at once: how the link would swing with other bodies is worked out beside how it
swings, by the same equation driven by the regressor's columns instead of the load.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from pa10d.diagnose.constants import (
    ROTOR_STEP,
    SPRING_STEP,
    SPRING_WORTH,
    STEP_DAMPINGS,
    SWING_SAMPLES,
    THIN_BAND,
    THIN_ORDER,
)
from pa10d.diagnose.regression.side import Side
from pa10d.diagnose.regression.state import SearchState
from pa10d.dynamics import Robot, inverse_dynamics, regressor, typical_inertia
from pa10d.effects import Context
from pa10d.effects.rotor import LIGHTEST
from pa10d.effects.swing import DAMPED, Spring, Swing, driven
from pa10d.measurement.signals import Lowpass
from pa10d.regression.equation import RunEquation
from pa10d.regression.per_joint import PerJoint, assembled, rms
from pa10d.regression.rests import filtered
from pa10d.regression.solution import strong
from pa10d.regression.winding import winds

Array = NDArray[np.float64]


@dataclass(frozen=True)
class JointSpring(Spring):
    """wound: (2·runs,) of each run in turn, N·m by which more is wound up than the link weighs when
    it begins, and N·m/s by which that grows; empty: every link begins at rest."""

    wound: tuple[float, ...] = ()

    def begun(self, run: int) -> tuple[float, float]:
        """How the link swings as this run begins, N·m and N·m/s."""
        return (self.wound[2 * run], self.wound[2 * run + 1]) if self.wound else (0.0, 0.0)


Springs = tuple[JointSpring, ...]
Swings = Sequence[Swing]


@dataclass(frozen=True)
class SpringFit:
    """Coefficients (p,) of the bodies and of all other terms, beside the springs; left: the sum
    over the joints of the logarithm of what is left over, N·m, and what unlikely beginnings cost.
    """

    beta: Array
    springs: Springs
    left: float


@dataclass(frozen=True)
class _Run:
    context: Context
    lowpass: Lowpass
    going: Array
    left: Array
    winds: tuple[float, ...]

    def filtered(self, raw: Array) -> Array:
        """(N, n, …) torque of all joints, as the equations have it."""
        return filtered(raw, self.lowpass, self.going, self.left)


@dataclass(frozen=True)
class _Steps:
    """Gauss and Newton's step and shorter ones, by the singular values of the equation of
    normalised columns: Levenberg's damping first holds what the data hardly show."""

    right: Array
    values: Array
    seen: Array
    scale: Array

    def of(self, damping: float) -> Array:
        """(p,) damping: as a share of a column's length."""
        gain = self.values / (self.values**2 + damping**2)
        return np.asarray(self.right @ (gain * self.seen) / self.scale)


class Flexible:
    """One side of a model with springs at some joints; the springs' own terms, where it has any,
    are out.

    but: indices of those terms
    """

    def __init__(self, state: SearchState, joints: Sequence[int], but: Sequence[int] = ()) -> None:
        self.joints, self.side = tuple(joints), state.train
        self.robot: Robot = state.model.robot
        self.kept = state.model.base.kept
        self.bodies = len(self.kept)
        self.rotor_in_load = [j in self.side.contexts[0].rotor_in_load for j in joints]
        self.runs = [
            _coarse(r, c, joints) for r, c in zip(self.side.runs, self.side.contexts, strict=True)
        ]
        self.rows = sum(len(tau) for tau in self.side.tau) / self.side.n
        places = state.unknowns.places
        chosen = [i for i in range(len(state.terms)) if i not in but]
        self.others = [(places[i], state.blocks[i][0]) for i in chosen]
        self.size = state.unknowns.size

    def fit(self, beta: Array, springs: Springs, rounds: int) -> SpringFit | None:
        """The best that so many steps reach from there; None where a link would run away."""
        still = (0.0,) * (2 * len(self.runs))
        springs = tuple(replace(s, wound=s.wound or still) for s in springs)
        swings = self._swings(beta, springs)
        if swings is None:
            return None
        found = self._torque(beta, springs, swings)
        inertia = typical_inertia(self.robot, self._rigid(beta))[list(self.joints)]
        sizes = self._sizes(inertia, springs)
        left, tried = self._left(found, springs, sizes), 0
        for _ in range(rounds):
            steps = self._steps(beta, springs, swings, found, sizes)
            better = None
            for number in range(max(tried - 1, 0), len(STEP_DAMPINGS)):
                step = steps.of(STEP_DAMPINGS[number])
                trial = beta + step[: self.size], self._moved(springs, step, inertia)
                followed = self._swings(*trial)
                if followed is None:
                    continue
                torque = self._torque(*trial, followed)
                if self._left(torque, trial[1], sizes) < left:
                    better, tried = (*trial, followed, torque), number
                    break
            if better is None:
                break
            beta, springs, swings, found = better
            before, left = left, self._left(found, springs, sizes)
            if before - left < SPRING_WORTH:
                break
        return SpringFit(beta, springs, left)

    def _sizes(self, inertia: Array, springs: Springs) -> Array:
        """(springs·2·runs,) N·m and N·m/s that may be wound up when a run begins; inertia: kg·m² of
        rotor and link (springs,)."""
        modes = [
            np.sqrt(s.stiffness / _link(i, s.rotor)) for s, i in zip(springs, inertia, strict=True)
        ]
        return np.array(
            [run.winds[e] * by for e, m in enumerate(modes) for run in self.runs for by in (1.0, m)]
        )

    def _left(self, torque: PerJoint, springs: Springs, sizes: Array) -> float:
        unlikely = float(np.sum((_wound(springs) / sizes) ** 2))
        return _left(self.side, torque) + 0.5 * unlikely / self.rows

    def _steps(
        self, beta: Array, springs: Springs, swings: Swings, torque: PerJoint, sizes: Array
    ) -> _Steps:
        """Of (p + shapes,): coefficients, then what ``_moved`` takes."""
        slopes = self._slopes(springs, swings)
        sigma = {j: max(rms(self.side.tau[j] - torque[j]), 1e-12) for j in torque}
        rows = np.concatenate([slopes[j] / sigma[j] for j in torque])
        target = np.concatenate([(self.side.tau[j] - torque[j]) / sigma[j] for j in torque])
        likely = np.zeros((len(sizes), rows.shape[1]))
        likely[:, -len(sizes) :] = np.diag(1.0 / sizes)
        rows = np.concatenate([rows, likely])
        target = np.concatenate([target, -_wound(springs) / sizes])
        scale = np.linalg.norm(rows, axis=0)
        scale[scale == 0] = 1.0
        both = np.column_stack([rows / scale, target])
        triangle = scipy.linalg.qr(both, mode="r", overwrite_a=True, check_finite=False)[0]
        width = len(scale)
        left, values, right = np.linalg.svd(triangle[:width, :width])
        kept = strong(values)
        seen = left[:, kept].T @ triangle[:width, width]
        return _Steps(right[kept].T, values[kept], seen, scale)

    def _moved(self, springs: Springs, step: Array, inertia: Array) -> Springs:
        """No farther than the equations are nearly linear: a rotor that takes the whole inertia in
        one step leaves a link without a mode, and no way back."""
        shapes = step[self.size : self.size + 3 * len(springs)].reshape(-1, 3)
        wound = step[self.size + 3 * len(springs) :].reshape(len(springs), -1)
        out = []
        for spring, own, more, whole in zip(springs, shapes, wound, inertia, strict=True):
            longest = max(abs(own[0]), abs(own[1]), SPRING_STEP)
            stiffer, damped = (SPRING_STEP / longest * float(x) for x in own[:2])
            link = _link(float(whole), spring.rotor)
            rotor = float(np.clip(own[2], -ROTOR_STEP * link, ROTOR_STEP * link))
            stiffness = spring.stiffness * float(np.exp(stiffer))
            critical = 2.0 * float(np.sqrt(stiffness * link))
            damping = float(
                np.clip(spring.damping * np.exp(damped), *np.multiply(DAMPED, critical))
            )
            out.append(
                replace(
                    spring,
                    stiffness=stiffness,
                    damping=damping,
                    rotor=max(0.0, spring.rotor + rotor),
                    wound=tuple(w + float(m) for w, m in zip(spring.wound, more, strict=True)),
                )
            )
        return tuple(out)

    def _swings(self, beta: Array, springs: Springs) -> Swings | None:
        """Of each run; None where a link would run away."""
        rigid, out = self._rigid(beta), []
        for number, run in enumerate(self.runs):
            swing = _swing(run.context, rigid, springs, number)
            if swing is None:
                return None
            out.append(swing)
        return out

    def _torque(self, beta: Array, springs: Springs, swings: Swings) -> PerJoint:
        """joint -> (m_j,) filtered torque on the samples that count."""
        rigid, whole = self._rigid(beta), []
        for run, swing in zip(self.runs, swings, strict=True):
            torque = inverse_dynamics(self.robot, rigid, *swing.motion)
            for e, spring in enumerate(springs):
                torque[:, spring.joint] += spring.rotor * swing.lag[2][:, e]
            whole.append(run.filtered(torque))
        out = {j: self.side.gathered([x[:, j] for x in whole], j) for j in range(self.side.n)}
        for place, block in self.others:
            for j, columns in block.items():
                out[j] = out[j] + columns @ beta[place]
        return out

    def _slopes(self, springs: Springs, swings: Swings) -> PerJoint:
        """joint -> (m_j, p + 3·springs + 2·springs·runs): by coefficients, each spring's ln K, ln C
        and rotor, and each one's beginnings."""
        whole = []
        known, runs = self.bodies + 3 * len(springs), len(self.runs)
        for number, (run, swing) in enumerate(zip(self.runs, swings, strict=True)):
            columns = np.zeros((len(run.context.q), self.robot.n, self.bodies))
            regressor(self.robot, *swing.motion, self.kept, out=columns)
            moving = run.filtered(self._moving(columns, swing, springs, number))
            wide = np.zeros((*moving.shape[:2], known + 2 * runs * len(springs)))
            wide[:, :, :known] = moving[:, :, :known]
            for e in range(len(springs)):
                place, begins = known + 2 * (e * runs + number), known + 2 * e
                wide[:, :, place : place + 2] = moving[:, :, begins : begins + 2]
            whole.append(wide)
        rows = [self.side.gathered([x[:, j] for x in whole], j) for j in range(self.side.n)]
        width = self.size + rows[0].shape[1] - self.bodies
        bodies = {j: r[:, : self.bodies] for j, r in enumerate(rows)}
        shapes = {j: r[:, self.bodies :] for j, r in enumerate(rows)}
        parts = [(slice(self.bodies), bodies), (slice(self.size, width), shapes), *self.others]
        return assembled(parts, width, [len(r) for r in rows])

    def _moving(self, columns: Array, swing: Swing, springs: Springs, number: int) -> Array:
        """(N, n, b + 5·springs) raw: the regressor's columns at the links, and what the links'
        own change of motion adds to each; the last two of each: where and how fast it begins."""
        b, count = self.bodies, len(springs)
        samples, n, _ = columns.shape
        lag = swing.lag
        drives = np.zeros((samples, count, b + 5 * count))
        rest = np.zeros((1, n, b))
        still = np.zeros((1, n))
        regressor(self.robot, swing.motion[0][:1], still, still, self.kept, out=rest)
        rests, fast = np.zeros((2, count, drives.shape[2]))
        for e, spring in enumerate(springs):
            j, own, begins = spring.joint, b + 3 * e, b + 3 * count + 2 * e
            drives[:, e, :b] = columns[:, j]
            drives[:, e, own] = -spring.stiffness * lag[0][:, e]
            drives[:, e, own + 1] = -spring.damping * lag[1][:, e]
            if self.rotor_in_load[e]:
                drives[:, e, own + 2] = -swing.motion[2][:, j]
            rests[e, :b] = rest[0, j]
            rests[e, own] = drives[0, e, own]
            fast[e, own] = -spring.begun(number)[1] / spring.stiffness
            rests[e, begins], fast[e, begins + 1] = 1.0, 1.0 / spring.stiffness
        where = np.asarray(np.linalg.solve(swing.grip, rests))
        moved = driven(drives, where, fast, swing.equation, self.runs[number].context.dt)
        out = np.zeros((samples, n, drives.shape[2]))
        out[:, :, :b] = columns
        for e, spring in enumerate(springs):
            for by, change in zip(swing.slopes, moved, strict=True):
                out -= by[e][:, :, None] * change[:, e][:, None, :]
            out[:, spring.joint] += spring.rotor * moved[2][:, e]
            if self.rotor_in_load[e]:
                out[:, spring.joint, b + 3 * e + 2] += lag[2][:, e]
        return out

    def _rigid(self, beta: Array) -> Array:
        out = np.zeros(10 * self.robot.n)
        out[self.kept] = beta[: self.bodies]
        return out.reshape(-1, 10)


def _link(inertia: float, rotor: float) -> float:
    """kg·m² of the link, of rotor and link together."""
    return max(inertia - rotor, LIGHTEST * inertia)


def _wound(springs: Springs) -> Array:
    """(springs·2·runs,) how the links begin, one spring's after another's."""
    return np.array([x for spring in springs for x in spring.wound])


def _swing(context: Context, rigid: Array, springs: Springs, run: int) -> Swing | None:
    wound = {spring.joint: spring.begun(run) for spring in springs}
    return Swing.of(replace(context, rigid=rigid, wound=wound), springs)


def zeta_of(state: SearchState, h: Array, spring: Spring) -> float:
    """Damping ratio at the link's typical inertia, with these base parameters."""
    rigid = np.zeros(10 * state.model.robot.n)
    rigid[state.model.base.kept] = h
    typical = float(typical_inertia(state.model.robot, rigid.reshape(-1, 10))[spring.joint])
    link = _link(typical, spring.rotor)
    return float(spring.damping / (2.0 * np.sqrt(spring.stiffness * link)))


def _coarse(run: RunEquation, context: Context, joints: Sequence[int]) -> _Run:
    """The motion on fewer samples, as many as its swing needs, with a filter that ends on the same
    samples of the equation. What fewer samples cannot show is taken out first: a jolt that falls
    between two of them still drives the link, and the noise of encoders would come back in the
    band of the swing."""
    fine = run.lowpass
    most = int(fine.rate / (SWING_SAMPLES * fine.cutoff))
    step = max(d for d in range(1, max(most, 1) + 1) if fine.factor % d == 0)
    q, dq, ddq = (_thinned(x, fine.rate, step) for x in (context.q, context.dq, context.ddq))
    thin = replace(
        context,
        t=context.t[::step],
        q=q,
        dq=dq,
        ddq=ddq,
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
    return _Run(thin, lowpass, going, run.left, tuple(winds(run, j) for j in joints))


def _thinned(x: Array, rate: float, step: int) -> Array:
    """(⌈N/step⌉, n) of x (N, n) at ``rate`` Hz, without what lies above half the new rate."""
    if step == 1:
        return x
    return Lowpass(len(x), rate, THIN_BAND * rate / step, step, THIN_ORDER)(x)


def _left(side: Side, torque: PerJoint) -> float:
    return float(sum(np.log(max(rms(side.tau[j] - torque[j]), 1e-12)) for j in torque))
