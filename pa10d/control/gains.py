"""Gains of the joint servo by a stated rule.

With inertia J and no other dynamics, PID puts three poles of the closed loop at -ω where
kp = 3·J·ω², ki = J·ω³, kd = 3·J·ω; ω = 2π times the profile's ``bandwidth_hz``, which by
itself is 4 Hz, and less in proportion where the loop is slower than 500 Hz. The loop stays
stable up to nine times this inertia. It does not far below it: there kd/J outruns the delay of
the bus and of the speed's filter; so J is that of a light pose (``joint_figures``).

Nothing but the URDF says so, until the joints have been measured. Then ω is also as large as
friction and gravity need, and what is asked is kept within margins (``servo_design``).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pa10d.control.joint_figures import (
    ROUGH,
    Inertias,
    JointFigures,
    inertias,
    poses_of,
    presumed_figures,
    whole_masses,
)
from pa10d.control.servo_design import (
    SENSITIVITY,
    SLUGGISH,
    Case,
    JointGains,
    LoopTiming,
    asked_gains,
    fitting_gains,
    sensitivity,
    swinging_inertia,
)
from pa10d.control.swaying import Coupled, settled
from pa10d.dynamics import Robot, inverse_dynamics
from pa10d.profile import Control

Array = NDArray[np.float64]

PUSH = 0.12  # of the torque limit, in a second: by which a joint is pushed that sticks
NEAR = 0.3  # of the bound of the following error, that friction and gravity may push a joint away
TURNING = 5.4  # kp·e/C: a joint whose friction turns round goes 2·0.27·C/(J·ω²) astray
UPRIGHT = 2.5  # kp of what gravity pulls a joint by that stands on it
HELD = 1.5  # … at least, of what it may be: a sensitivity of 2 asks for that
WORN = 0.5  # of the measured viscous friction that is there in any case
FIRM = 2.0  # … where gains are softened: joints that lean together ask for more than HELD
AGAIN = 0.6  # of the inertia that explained a swing, where it was not enough
LONE = 0.5  # of the usual inertia: what is lighter swings without its link
SMALL = 1e-3  # rad
TOGETHER = 64  # poses in which an arm is looked at as a whole
BUS_DELAY = 1.5  # periods from a measurement to the middle of the torque that answers it


@dataclass(frozen=True)
class PidGains:
    """(n,) each: N·m/rad, N·m/(rad·s), N·m·s/rad.

    push: N·m/s by which the torque on a joint that sticks grows, until it comes loose; the first
    motion alone needs it. friction: N·m of dry friction as measured, which motions bring along.
    pull: N·m/rad by which gravity pulls the joint away at most, 0 where it hangs, or nobody knows.
    """

    kp: Array
    ki: Array
    kd: Array
    push: Array = field(default_factory=lambda: np.zeros(1))
    friction: Array = field(default_factory=lambda: np.zeros(1))
    pull: Array = field(default_factory=lambda: np.zeros(1))

    def document(self) -> dict[str, list[float]]:
        """For JSON and the pipe to the control process."""
        return {key: np.asarray(values).tolist() for key, values in vars(self).items()}

    @staticmethod
    def from_document(document: Mapping[str, Any]) -> PidGains:
        """The other way."""
        return PidGains(**{k: np.array(v, dtype=float) for k, v in document.items()})

    def softened(self, share: float) -> PidGains:
        """The same poles, slower: ``share`` of the bandwidth; but gravity stays outweighed."""
        kp, ki, kd = share**2 * self.kp, share**3 * self.ki, share * self.kd
        return replace(self, kp=np.maximum(kp, np.minimum(self.kp, FIRM * self.pull)), ki=ki, kd=kd)


def nominal_inertia(robot: Robot) -> Array:
    """(n,) kg·m² that the gains are made for, with a rotor of usual size."""
    return inertias(robot, presumed_figures(robot)).usual


def pid_gains(robot: Robot, control: Control) -> PidGains:
    """From the profile where it has them, else by the rule."""
    inertia, w = nominal_inertia(robot), 2.0 * np.pi * control.servo_bandwidth
    given = control.gains

    def chosen(values: list[float] | None, rule: Array) -> Array:
        return rule if values is None else np.array(values, dtype=float)

    return PidGains(
        kp=chosen(given.kp, 3.0 * inertia * w**2),
        ki=chosen(given.ki, inertia * w**3),
        kd=chosen(given.kd, 3.0 * inertia * w),
    )


@dataclass(frozen=True)
class FittedGains:
    """gains, and the peak of the sensitivity (n,) in the worst case of each joint."""

    gains: PidGains
    sensitivity: Array


def fitted_gains(
    robot: Robot, control: Control, following_error: Array, figures: JointFigures
) -> FittedGains:
    """What the profile asks for, or friction and gravity need, within margins in every pose.

    following_error: (n,) rad, the bound. Where inertia is only presumed it may be three times as
    large or small, and friction may be missing: then the gains are soft.
    """
    span, pull = inertias(robot, figures), pulls(robot, figures)
    bandwidth = np.full(robot.n, 2.0 * np.pi * control.servo_bandwidth)
    if control.bandwidth_hz is None:
        upright = np.maximum(UPRIGHT, HELD * figures.doubt) * pull
        bandwidth = np.maximum(bandwidth, _needed(robot, span, following_error, figures))
        bandwidth = np.maximum(bandwidth, np.sqrt(upright / (3.0 * span.usual)))
    made = []
    for j in range(robot.n):
        thought = max(span.usual[j], span.light[j] / figures.least[j])  # heavier where it fell
        asked = asked_gains(float(thought), float(figures.viscous[j]), float(bandwidth[j]))
        made.append(_held(asked, span, figures, float(pull[j]), _timing(control, figures, j), j))
    gains = _together(made)
    settling = settled(_coupled(robot, control, figures, gains), gains.ki)
    gains = replace(gains, ki=settling, pull=pull)
    return FittedGains(gains, np.array([one.sensitivity for one in made]))


def _coupled(robot: Robot, control: Control, figures: JointFigures, gains: PidGains) -> Coupled:
    """The arm held by these gains, about poses that it may come to; friction may have worn off."""
    poses = poses_of(robot, figures)[:TOGETHER]
    late = np.array([_timing(control, figures, j).delay for j in range(robot.n)])
    return Coupled(
        mass=whole_masses(robot, figures, poses),
        slope=_slopes(robot, _felt(robot, figures), poses),
        stiff=gains.kp,
        damps=gains.kd + WORN * figures.viscous,
        late=np.maximum(late, 0.0),
    )


def _held(
    asked: JointGains,
    span: Inertias,
    figures: JointFigures,
    pull: float,
    timing: LoopTiming,
    j: int,
) -> JointGains:
    """With margins where gravity is as strong as it may be, else as strong as it is thought, and
    friction calms what sways slowly; where there are none at all, at least stable, if anything is.
    """
    sure = fitting_gains(asked, _cases(span, figures, j, pull, sure=True), timing)
    if sure.sensitivity <= SENSITIVITY or pull <= 0:
        return sure
    thought = fitting_gains(asked, _cases(span, figures, j, pull), timing)
    return thought if thought.sensitivity <= SENSITIVITY or np.isinf(sure.sensitivity) else sure


def loop_sensitivity(
    robot: Robot, control: Control, figures: JointFigures, gains: PidGains
) -> Array:
    """(n,) peak of the sensitivity that gains have in the worst pose, inf where the loop swings up
    there; by the inertias as they are known, whatever the doubt about them."""
    known = figures.but(doubt=np.ones(robot.n))
    span, worst = inertias(robot, known), np.zeros(robot.n)
    pull = pulls(robot, known)
    for j in range(robot.n):
        used, timing = _of_joint(gains, j), _timing(control, figures, j)
        cases = _cases(span, known, j, float(pull[j]))
        worst[j] = max(sensitivity(used, case, timing) for case in cases)
    return worst


def first_gains(
    robot: Robot, control: Control, following_error: Array, figures: JointFigures | None = None
) -> PidGains:
    """For an arm that nobody has measured; joints that stick are pushed. figures: as presumed, with
    what swings have shown."""
    presumed = presumed_figures(robot) if figures is None else figures
    made = fitted_gains(robot, control, following_error, presumed).gains
    return replace(made, push=PUSH * robot.effort)


def _needed(robot: Robot, span: Inertias, bound: Array, figures: JointFigures) -> Array:
    """(n,) rad/s with which friction and gravity push no joint further than ``NEAR`` its bound."""
    if (figures.doubt >= ROUGH).all():
        return np.zeros(robot.n)
    away = NEAR * bound
    turning = np.sqrt(TURNING * figures.coulomb / (3.0 * span.usual * away))
    damped = figures.viscous / (3.0 * span.usual)
    load = np.abs(_gravity(robot, robot.parameters, poses_of(robot, figures))).max(axis=0)
    lifting = np.cbrt(load * robot.velocity / (span.usual * away))
    return np.asarray(np.maximum.reduce([turning, damped, lifting]))


def gravity_slope(robot: Robot, bodies: Array, poses: Array) -> Array:
    """(P, n) N·m/rad by which gravity pulls each joint further away in poses (P, n), rad; negative
    where it hangs. bodies: (n, 10) standard parameters."""
    return np.diagonal(_slopes(robot, bodies, poses), axis1=1, axis2=2).copy()


def _slopes(robot: Robot, bodies: Array, poses: Array) -> Array:
    """(P, n, n) N·m/rad by which gravity pulls joint i further away where joint j leans."""
    here, slopes = _gravity(robot, bodies, poses), np.zeros((*poses.shape, robot.n))
    for j in range(robot.n):
        moved = poses.copy()
        moved[:, j] += SMALL
        slopes[:, :, j] = (here - _gravity(robot, bodies, moved)) / SMALL
    return 0.5 * (slopes + slopes.transpose(0, 2, 1))  # of a potential: what differs is rounding


def pulls(robot: Robot, figures: JointFigures) -> Array:
    """(n,) N·m/rad by which gravity pulls each joint further away where that is worst, of all poses
    that the arm may come to, by the bodies as they were felt; 0 where it hangs in all of them."""
    slope = gravity_slope(robot, _felt(robot, figures), poses_of(robot, figures))
    return np.asarray(np.maximum(slope.max(axis=0), 0.0))


def burdens(robot: Robot, figures: JointFigures) -> Array:
    """(n,) N·m of gravity on each joint in the worst of the same poses, by the same bodies."""
    poses = poses_of(robot, figures)
    return np.asarray(np.abs(_gravity(robot, _felt(robot, figures), poses)).max(axis=0))


def _felt(robot: Robot, figures: JointFigures) -> Array:
    return figures.bodies[0] if len(figures.bodies) else robot.parameters


def _gravity(robot: Robot, bodies: Array, q: Array) -> Array:
    still = np.zeros_like(q)
    return inverse_dynamics(robot, bodies, q, still, still)


def after_swing(
    robot: Robot, control: Control, figures: JointFigures, gains: PidGains, axis: int, hertz: float
) -> JointFigures:
    """The same joints, but one that swung at ``hertz`` with these gains: it is at least as light
    (where it swings faster than its servo should, else as heavy) as would explain that."""
    used = _of_joint(gains, axis)
    seen = swinging_inertia(used, _timing(control, figures, axis), hertz)
    swung, before = figures.swung.copy(), float(figures.swung[axis])
    light = seen < inertias(robot, figures).usual[axis]
    if before and light:
        seen = min(seen, AGAIN * before)
    elif before:
        seen = max(seen, before / AGAIN)
    swung[axis] = seen
    return figures.but(swung=swung)


def with_rotor(
    robot: Robot, figures: JointFigures, axis: int, rotor: float, hertz: float
) -> JointFigures | None:
    """The same joints, but one whose rotor of kg·m² swung at ``hertz`` in front of a spring that
    nobody has seen: it is as stiff as swings that rotor so quickly at most, for a stiffer one takes
    the link along. None where link and rotor are one, or the spring is known."""
    if np.isfinite(figures.stiffness[axis]) or rotor > LONE * inertias(robot, figures).usual[axis]:
        return None
    stiffness, motor, own = figures.stiffness.copy(), figures.motor.copy(), figures.rotor.copy()
    stiffness[axis] = rotor * (2.0 * np.pi * hertz) ** 2
    motor[axis] = own[axis] = rotor
    return figures.but(stiffness=stiffness, motor=motor, rotor=own)


def after_fall(
    robot: Robot, figures: JointFigures, gains: PidGains, bound: float, axis: int
) -> JointFigures | None:
    """The same joints, but one that was ``bound`` rad behind, did not swing and met nothing: half
    as light as it was thought to be at most. None where it is taken for as heavy as it may be."""
    heaviest = 1.0 / float(figures.doubt[axis])
    if figures.least[axis] <= heaviest:
        return None
    lighter = figures.least.copy()
    lighter[axis] *= 0.5
    return figures.but(lighter=lighter)


def lightly_pressed(
    robot: Robot, figures: JointFigures, gains: PidGains, bound: float, axis: int
) -> bool:
    """Whether what pressed on a joint ``bound`` rad behind was less than its push, which friction
    alone may hold, once measured friction has turned round; one that was pressed on harder may have
    met something.
    """
    turned = 2.0 * figures.coulomb[axis]
    return bool(gains.kp[axis] * bound - turned <= PUSH * robot.effort[axis])


def _timing(control: Control, figures: JointFigures, j: int) -> LoopTiming:
    return LoopTiming(1.0 / control.rate, BUS_DELAY / control.rate + float(figures.delay[j]))


def _of_joint(gains: PidGains, j: int) -> JointGains:
    kp, ki, kd = (float(values[j]) for values in (gains.kp, gains.ki, gains.kd))
    return JointGains(kp, ki, kd, np.nan)


def _cases(
    span: Inertias, figures: JointFigures, j: int, pull: float, sure: bool = False
) -> list[Case]:
    """pull: N·m/rad of gravity in the pose where it is worst; sure: be it as wrong as inertias may
    be, and nothing calms a heavy joint that sways slowly under it: dry friction does, where it is
    known. A light joint is felt most where it is quick, and gravity is slow."""
    doubt, viscous = float(figures.doubt[j]), float(figures.viscous[j])
    spring = (float(figures.motor[j]), float(figures.stiffness[j]))
    light, usual, heavy = (float(values[j]) for values in span)
    most, calm = (doubt * pull if sure else pull), not sure or figures.coulomb[j] > 0
    upright = (most, 0.0) if calm else (pull, most)
    cases = [
        Case(light / float(figures.least[j]), WORN * viscous, *spring),
        Case(usual, viscous, *spring, gravity=upright[0]),
        Case(heavy * doubt, WORN * viscous, *spring, allowed=SLUGGISH, gravity=upright[1]),
    ]
    return cases + ([Case(float(figures.swung[j]))] if figures.swung[j] else [])


def _together(made: list[JointGains]) -> PidGains:
    kp, ki, kd = (np.array([getattr(one, key) for one in made]) for key in ("kp", "ki", "kd"))
    return PidGains(kp, ki, kd)
