"""Gains of one joint from what is known of it: as stiff as asked, if the loop's margins allow it.

The loop as it is: sampled, with its delay, the speed's filter, a joint that is a rotor with
friction, rigidly on its link or behind a spring. What a bandwidth ω asks for places three poles at
-ω: D = kd + viscous friction = 3·J·ω, kp = 3·J·ω², ki = J·ω³. They are taken where the
sensitivity 1/(1+L) stays below ``SENSITIVITY`` in every case that the joint may meet (light and
heavy poses, friction that has gone). Else those gains are taken that resist a slow disturbance best
among all below them that keep it: Åström, Panagopoulos & Hägglund, Design of PI controllers based
on non-convex optimization, Automatica 34 (1998), with a grid instead of their gradient.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.control.estimator import CUTOFF

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

SENSITIVITY = 2.0  # at most: a gain margin of 2, a phase margin of 29° at least
SLUGGISH = 3.0  # of a joint too heavy for its gains: it sways slowly, and friction calms it
SLOW = 2.0 * np.pi * 0.1  # rad/s of the disturbance that gains are compared by: gravity in motion
LOOKS = 120  # frequencies per loop
STIFF = 2.0 ** np.arange(-8.0, 0.5, 0.5)  # of kp
DAMPING = 2.0 ** np.arange(-8.0, 3.5, 0.5)  # of kd: a weak servo may need more than a stiff one
INTEGRAL = np.array(
    [1.0, 0.7, 0.5, 0.35, 0.25, 0.15, 0.06, 0.02]
)  # of ki that poles in one place have


@dataclass(frozen=True)
class Case:
    """One joint as the loop may meet it. inertia: kg·m², of rotor and link together; viscous:
    N·m·s/rad; rotor: kg·m² and stiffness: N·m/rad where a spring is between the two; gravity:
    N·m/rad by which it pulls the link further away."""

    inertia: float
    viscous: float = 0.0
    rotor: float = 0.0
    stiffness: float = np.inf
    damping: float = 0.02  # of the spring, of its critical damping
    allowed: float = SENSITIVITY
    gravity: float = 0.0

    @property
    def sprung(self) -> bool:
        """Whether a spring lies between rotor and link."""
        return bool(np.isfinite(self.stiffness)) and 0 < self.rotor < self.inertia

    @property
    def falls(self) -> float:
        """N·m/rad that a servo must give in any case: gravity's pull, seen through the spring; inf
        where the spring itself gives way."""
        if not self.sprung or self.gravity <= 0:
            return self.gravity
        left = self.stiffness - self.gravity
        return self.gravity * self.stiffness / left if left > 0 else np.inf

    def response(self, s: Complex) -> Complex:
        """rad per N·m at s = jω."""
        if not self.sprung:
            return np.asarray(1.0 / (self.inertia * s**2 + self.viscous * s - self.gravity))
        link = (self.inertia - self.rotor) * s**2 - self.gravity
        loss = 2.0 * self.damping * np.sqrt(self.stiffness * (self.inertia - self.rotor))
        spring = self.stiffness + loss * s
        through = link * spring / (link + spring)  # what the link asks of the spring
        return np.asarray(1.0 / (self.rotor * s**2 + self.viscous * s + through))


@dataclass(frozen=True)
class LoopTiming:
    """period: s; delay: s from a measurement to the middle of the torque that answers it."""

    period: float
    delay: float

    def frequencies(self) -> Array:
        """(LOOKS,) rad/s up to the half of the loop's rate."""
        return np.geomspace(0.3, np.pi / self.period * 0.999, LOOKS)

    def terms(self, w: Array) -> tuple[Complex, Complex, Complex]:
        """What kp, ki, kd are multiplied by in the sampled loop, delay included."""
        back: Complex = np.exp(-1j * w * self.period)
        share = 1.0 - np.exp(-2.0 * np.pi * CUTOFF * self.period)
        late: Complex = np.exp(-1j * w * self.delay)
        speed = share * (1.0 - back) / self.period / (1.0 - (1.0 - share) * back)
        return late, late * self.period / (1.0 - back), late * speed


@dataclass(frozen=True)
class JointGains:
    """N·m/rad, N·m/(rad·s), N·m·s/rad, and the peak of the sensitivity that comes with them; it is
    infinite where nothing stable holds the joint."""

    kp: float
    ki: float
    kd: float
    sensitivity: float


def asked_gains(inertia: float, viscous: float, bandwidth: float) -> JointGains:
    """Three poles at -bandwidth, rad/s; friction damps as well as the servo does."""
    kd = max(3.0 * inertia * bandwidth - viscous, 0.0)
    return JointGains(3.0 * inertia * bandwidth**2, inertia * bandwidth**3, kd, np.nan)


def swinging_inertia(gains: JointGains, timing: LoopTiming, hertz: float) -> float:
    """kg·m² of a free joint that these gains let swing at ``hertz``: there the loop returns what
    came in, |C(jω)| = J·ω²."""
    w = np.array([2.0 * np.pi * hertz])
    asked = np.array([gains.kp, gains.ki, gains.kd]) @ np.array(timing.terms(w))
    return float(np.abs(asked[0]) / w[0] ** 2)


def fitting_gains(asked: JointGains, cases: list[Case], timing: LoopTiming) -> JointGains:
    """``asked``, or the stiffest below that keep the margins in every case.

    Where no gains are stable in every case, calm ones as if there were no gravity, with an infinite
    sensitivity.
    """
    w = timing.frequencies()
    whole = np.array([[asked.kp, asked.ki, asked.kd]])
    if (peak := _peaks(whole, cases, timing, w)[0]) <= SENSITIVITY:
        return JointGains(asked.kp, asked.ki, asked.kd, float(peak))
    most = max(asked.kd, 3.0 * asked.ki / asked.kp * cases[0].inertia)
    kp, ki, kd = np.meshgrid(asked.kp * STIFF, INTEGRAL, most * DAMPING, indexing="ij")
    friction = min(case.viscous for case in cases)
    ki = np.minimum(ki * kp**2 / (3.0 * (kd + friction)), asked.ki)
    tried = np.stack([kp.ravel(), ki.ravel(), kd.ravel()], axis=1)
    peaks = _peaks(tried, cases, timing, w)
    stiff = np.abs(tried[:, 0] - 1j * tried[:, 1] / SLOW)
    if holds := bool(np.isfinite(peaks).any()):
        fine = peaks <= SENSITIVITY
    else:
        calm = _peaks(tried, [replace(case, gravity=0.0) for case in cases], timing, w)
        fine, peaks = calm <= SENSITIVITY, calm
    best = int(np.argmax(np.where(fine, stiff, -1.0)) if fine.any() else np.argmin(peaks))
    chosen = [float(k) for k in tried[best]]
    return JointGains(chosen[0], chosen[1], chosen[2], float(peaks[best]) if holds else np.inf)


def sensitivity(gains: JointGains, case: Case, timing: LoopTiming) -> float:
    """Peak of |1/(1+L)|; infinite where the loop is not stable."""
    w = timing.frequencies()
    row = np.array([[gains.kp, gains.ki, gains.kd]])
    return float(_peaks(row, [case], timing, w)[0])


def _peaks(gains: Array, cases: list[Case], timing: LoopTiming, w: Array) -> Array:
    """(K,) of gains (K, 3): the worst case, what it is allowed counted as ``SENSITIVITY``."""
    controllers = gains @ np.array(timing.terms(w))
    worst = np.zeros(len(gains))
    for case in cases:
        around = 1.0 + controllers * case.response(np.asarray(1j * w, dtype=np.complex128))
        peak = SENSITIVITY / case.allowed / np.abs(around).min(axis=1)
        swings = _encircles(around) | (gains[:, 0] <= case.falls)
        worst = np.maximum(worst, np.where(swings, np.inf, peak))
    return worst


def _encircles(around: Complex) -> NDArray[np.bool_]:
    """Nyquist's criterion on 1+L (K, F): from where integrators leave it, -90° to -270° (-180° to
    -270° where gravity pulls the joint away), it must come back to 0° without a turn."""
    start, end = np.angle(around[:, 0]), np.angle(around[:, -1])
    turned = end - start + 2 * np.pi * _crossings(around)
    turned += np.where(start > 0, start - 2 * np.pi, start)
    return np.asarray(np.abs(turned) > 1.0)


def _crossings(curves: Complex) -> Array:
    """(K,) how often each of (K, F) passes the negative real axis, from above more than from below:
    turns that the angle makes beside what its ends show, without an angle of every point."""
    above = curves.imag >= 0
    row, at = np.nonzero(above[:, 1:] != above[:, :-1])
    before, after = curves[row, at], curves[row, at + 1]
    turn = before.real * after.imag - before.imag * after.real  # > 0: to the left, by less than π
    down = above[row, at]
    passed = np.where(down, turn > 0, turn < 0) * np.where(down, 1.0, -1.0)
    return np.asarray(np.bincount(row, passed, len(curves)), np.float64)
