"""What an effect may look at when it computes its columns: the motion and the model so far."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pa10d.common.errors import UserError
from pa10d.dynamics import Robot, inverse_dynamics, sensitivities, typical_inertia
from pa10d.effects.bristle import brushed
from pa10d.effects.sign import smooth_sign
from pa10d.measurement.motion import Quieting

Array = NDArray[np.float64]

OF_MOTION = ("load", "quiet_ddq", "drowned", "quiet_load", "typical_inertia", "_kept")
OF_SWING = ("drawn", "swings")  # of how links swing as the motion begins, too
TURNS, SLIDES = 0.01, 0.001  # rad/s, m/s
SHARPEST = 5e-4  # rad/s: of a sign without noise, for which a reversal still takes some samples


@dataclass(frozen=True)
class Context:
    """One run's motion at the raw sample rate, and what the model says about it.

    t                (N,) s since the start of the run, equidistant
    q, dq, ddq       (N, n) rad, rad/s, rad/s², filtered far more lightly than the equation
    rigid            (n, 10) standard parameters of the rigid bodies (any set with the right base
                     parameters), without rotor inertia; link-side loads follow from them
    total            (N, n) N·m, torque of the whole model so far, friction included
    temperature      (N, n) °C or None
    rotor_in_load    joints (0-based) whose rotor's inertia the rigid bodies have taken in: their
                     load is the torque at the rotor, not at the link
    ways             (n,) rad over which each joint's friction builds up after a turn; 0: at once
    lags             (n,) s, damping of these bristles by their stiffness; 0: they have none
    corners          (n,) rad/s (m/s) over which each joint's dry friction turns round; 0: unknown
    levels           (N, n) of all friction that builds up so, by that to which the way belongs: as
                     bristles are as stiff whatever they carry, they bend as much farther
    rubbing          (N, n) N·m, friction of the model so far that heats the joints, or None
    desired          the motion was not measured but is wanted: without noise, so that no sign of a
                     velocity has to be smoothed against it
    apart            the samples are of no one motion: nothing that came before any of them is
                     known, and t means nothing
    quieting         takes from a measured acceleration what is noise; None: none is known
    wound            joint -> N·m by which more is wound up in its spring than its link weighs, when
                     the motion begins, and N·m/s by which its torque grows then; absent: the link
                     hangs still
    springs          of the model's gears that give, whose links swing together: joint, K N·m/rad,
                     damping ratio, rotor kg·m²
    """

    robot: Robot
    t: Array
    q: Array
    dq: Array
    ddq: Array
    rigid: Array
    total: Array
    temperature: Array | None = None
    rubbing: Array | None = None
    rotor_in_load: tuple[int, ...] = ()
    ways: tuple[float, ...] = ()
    lags: tuple[float, ...] = ()
    corners: tuple[float, ...] = ()
    levels: Array | None = None
    desired: bool = False
    apart: bool = False
    quieting: Quieting | None = None
    wound: Mapping[int, tuple[float, float]] = field(default_factory=dict)
    springs: tuple[tuple[int, float, float, float], ...] = ()

    def sign(self, velocity: Array, v0: float) -> Array:
        """(N,) sign of a velocity smoothed over ±v0; along a motion its mean over each interval."""
        return np.tanh(velocity / v0) if self.apart else smooth_sign(velocity, v0)

    def friction(self, joint: int, level: Array, v0: float) -> Array:
        """(N,) friction of this level (N,) against a joint's motion: turning round over ±v0, or
        over the way that the joint's friction takes, where the model knows of one."""
        way = self.ways[joint] if self.ways and not self.apart else 0.0
        if way > 0.0:
            return self.bristles(joint, level, way, self.lags[joint] if self.lags else 0.0)
        return level * self.sign(self.dq[:, joint], v0)

    def bristles(self, joint: int, level: Array, way: float, lag: float) -> Array:
        """(N,) friction of this level (N,) that builds up over a joint's own way (rad), damped."""
        far = way * self.stretched(joint)
        return np.asarray(brushed(self.q[:, joint], self.dq[:, joint], level, far, lag))

    def stretched(self, joint: int) -> Array:
        """(N,) how many times farther than their own way a joint's bristles bend."""
        return np.ones(len(self.q)) if self.levels is None else self.levels[:, joint]

    def corner(self, joint: int) -> float:
        """rad/s (m/s) over which all friction of a joint turns round. Where the model does not know
        it, a slide is slower by as much as metres are larger than the radians of a joint."""
        if self.corners and self.corners[joint] > 0.0:
            return self.corners[joint]
        return SLIDES if self.robot.prismatic[joint] else TURNS

    def softness(self, v0: float) -> float:
        """rad/s over which a sign that is usually smoothed over v0 is to be smoothed here."""
        return min(v0, SHARPEST) if self.desired else v0

    @property
    def dt(self) -> float:
        """Sample period, s."""
        return float(self.t[1] - self.t[0])

    @cached_property
    def load(self) -> Array:
        """(N, n) N·m: torque that the transmission passes to the links."""
        return self.rigid_torque(self.q, self.dq, self.ddq)

    @cached_property
    def quiet_ddq(self) -> Array:
        """(N, n) rad/s²: the acceleration without what lies above the motion's own band."""
        return self.ddq if self.quieting is None else self.quieting(self.ddq, 1.0 / self.dt)

    @cached_property
    def drowned(self) -> NDArray[np.bool_]:
        """(n,) of which joint does a load have more noise of the encoders than load?"""
        if self.quieting is None:
            return np.zeros(self.q.shape[1], dtype=bool)
        noise = self.load - self._without_noise
        return np.asarray(np.mean(noise**2, axis=0) > np.mean(self._without_noise**2, axis=0))

    @cached_property
    def quiet_load(self) -> Array:
        """(N, n) N·m: the load, of joints whose load is mostly an encoder's noise without that. The
        size of such a load is the noise's own, and no mean over a while makes it the load's."""
        if not self.drowned.any():
            return self.load
        return np.where(self.drowned, self._without_noise, self.load)

    @property
    def quiet_total(self) -> Array:
        """(N, n) N·m: the same of the torque of the whole model."""
        if self.quieting is None or not self.drowned.any():
            return self.total
        return np.where(self.drowned, self.quieting(self.total, 1.0 / self.dt), self.total)

    @cached_property
    def _without_noise(self) -> Array:
        return self.rigid_torque(self.q, self.dq, self.quiet_ddq)

    def with_total(self, total: Array) -> Context:
        """The same with another torque of the whole model."""
        return self._with(replace(self, total=total))

    def with_levels(self, levels: Array | None) -> Context:
        """The same with other levels of friction."""
        return self._with(replace(self, levels=levels))

    def with_wound(self, wound: Mapping[int, tuple[float, float]]) -> Context:
        """The same with links that swing otherwise as the motion begins."""
        return self.handed_to(replace(self, wound=wound))

    def handed_to(self, other: Context) -> Context:
        """Another context of the same motion and the same bodies, with what follows from these
        alone: it is not computed again."""
        return self._with(other, OF_MOTION)

    def _with(self, other: Context, names: Sequence[str] = OF_MOTION + OF_SWING) -> Context:
        """What follows from motion and bodies alone is not computed again."""
        for name in names:
            if name in self.__dict__:
                other.__dict__[name] = self.__dict__[name]
        return other

    def rigid_torque(self, q: Array, dq: Array, ddq: Array) -> Array:
        """Link-side torque (N, n) of the model's rigid bodies for another motion."""
        return inverse_dynamics(self.robot, self.rigid, q, dq, ddq)

    @property
    def friction_heat(self) -> Array:
        """(N, n) W that the model's friction turns into heat."""
        if self.rubbing is None:
            return np.zeros_like(self.q)
        return np.maximum(self.rubbing * self.dq, 0.0)

    def inertia_seen(self, joint: int) -> Array:
        """(N,) kg·m²: M_jj(q), the inertia that joint j moves; never below a small part of
        its own largest value, because a badly excited fit may make it negative."""
        found = self.sensitivity(joint)[2][:, joint]
        return np.maximum(found, max(0.02 * float(np.max(np.abs(found))), 1e-6))

    @cached_property
    def typical_inertia(self) -> Array:
        """(n,) kg·m²: median of M_jj over poses spread evenly over the joints' ranges, so the same
        for every run of a robot. Positive, even where a badly excited fit makes M_jj negative."""
        return typical_inertia(self.robot, self.rigid)

    def sensitivity(self, joint: int) -> tuple[Array, Array, Array]:
        """∂τ/∂q_j, ∂τ/∂q̇_j and ∂τ/∂q̈_j of all joints' link-side torque, (N, n) each."""
        # no cached_property: until Python 3.12 that is one lock for all contexts, so that several
        # threads would wait for each other
        if "sensitivities" not in self._kept:
            found = sensitivities(self.robot, self.rigid, self.q, self.dq, self.ddq)
            self._kept["sensitivities"] = found
        by_q, by_dq, by_ddq = self._kept["sensitivities"]
        return by_q[joint], by_dq[joint], by_ddq[joint]

    @cached_property
    def drawn(self) -> dict[tuple[object, ...], Array]:
        """Columns of effects that see the model's loads, made for its total (``columns_once``)."""
        return {}

    @cached_property
    def swings(self) -> dict[tuple[object, ...], object]:
        """How links behind springs swing, as they have been worked out (``Swing.once``)."""
        return {}

    @cached_property
    def _kept(self) -> dict[str, tuple[Array, Array, Array]]:
        return {}


def posed(
    robot: Robot,
    q: ArrayLike,
    dq: ArrayLike,
    ddq: ArrayLike,
    time: ArrayLike | None = None,
    temperature: ArrayLike | None = None,
) -> Context:
    """A motion that nobody has measured, (N, n) or (n,) each; without time its samples stand
    apart. Its model part is empty."""
    named = {"q": q, "dq": dq, "ddq": ddq}
    moved = {name: np.atleast_2d(np.asarray(x, dtype=float)) for name, x in named.items()}
    samples = len(moved["q"])
    if temperature is not None:
        moved["temperature"] = np.atleast_2d(np.asarray(temperature, dtype=float))
    for name, values in moved.items():
        if values.shape != (samples, robot.n):
            raise UserError(f"{name} has shape {values.shape}, expected ({samples}, {robot.n})")
    t = np.zeros(samples) if time is None else np.asarray(time, dtype=float)
    if time is not None and (samples < 2 or t.shape != (samples,) or not _even(t)):
        raise UserError(f"time: expected {samples} values at equal steps, at least two")
    return Context(
        robot=robot,
        t=t - t[0],
        q=moved["q"],
        dq=moved["dq"],
        ddq=moved["ddq"],
        rigid=np.zeros((robot.n, 10)),
        total=np.zeros_like(moved["q"]),
        temperature=moved.get("temperature"),
        apart=time is None,
    )


def _even(t: Array) -> bool:
    """At equal steps forward, but for what stamps are rounded by."""
    step = np.diff(t)
    return bool(step.min() > 0 and np.ptp(step) < 0.01 * step.mean())
