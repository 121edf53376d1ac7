"""Positions far beyond what a joint can turn: degrees, encoder counts, or angles at the motor.

Told by the speeds that were logged beside them, by the URDF's limits, by the gear ratios that a
profile has, and at last by the arm's weight: with angles in a wrong unit the textbook model, all
its masses free, leaves more. Where none of them tells, nothing is guessed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.checks.counters import Wraps
from pa10d.checks.finding import CheckFinding, Mend, Severity
from pa10d.checks.textbook_view import middle_of, squares_left, surely_less
from pa10d.common.words import joint_words
from pa10d.dynamics.robot import Robot
from pa10d.measurement.counters import centred
from pa10d.measurement.recording import Recording

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

DEGREE = np.pi / 180
WHOLE_TURNS = 4 * np.pi  # rad: hardly any arm turns further
TURN = 360.0  # degrees
COUNTS = 1e4  # nothing in degrees reaches so far
BEYOND = 1.5  # times a limit, from where on a position is no joint's
ALIKE = 0.05  # by which a slope of dq over the slope of q may be off a unit: both are noisy
GEARS = (1.5, 2000.0)  # ratios that gears of arms have
OTHERS = (0.85, 1.18)  # of a degree: next to which degrees have to be surely better


@dataclass(frozen=True)
class Known:
    """What is known beside the samples. wraps: how numbers began anew as they were logged, None:
    look at them as they are; stated: joints (from 0) whose positions somebody gave a unit; ratios:
    (n,) of the profile's gears."""

    wraps: Wraps | None = None
    stated: frozenset[int] = field(default_factory=frozenset)
    ratios: Sequence[float] | None = None


def check_angles(recording: Recording, robot: Robot | None, known: Known) -> Iterator[CheckFinding]:
    """One finding at most: positions are logged in one unit, whichever joints show it."""
    n = recording.joints
    turning = np.ones(n, bool) if robot is None else ~robot.prismatic
    turning &= ~np.array([f"q{j + 1}" in (known.wraps or {}) for j in range(n)])
    largest = np.abs(recording.q).max(axis=0)
    stated = np.isin(np.arange(n), list(known.stated))
    asked = turning & ~stated
    if (largest[asked] > COUNTS).any() or _whole_numbers(recording.q[:, asked]):
        # what begins anew is asked again once mended
        mends = _of_all(turning, "rev/COUNTS", complete=False)
        yield CheckFinding(
            "error",
            "counts",
            f"q reaches {largest[turning].max():.3g}: these look like encoder counts",
            f"q must be in rad: --map {_options(mends)} with the joint's counts per revolution",
            mends=mends,
        )
        return
    far = turning & _far(recording, robot, largest) & ~(stated & _unbounded(robot, n))
    if not far.any():
        return
    sure = bool((far & ~_unbounded(robot, n)).any())  # without limits it may turn on and on
    reaches = f"q reaches {largest[far].max():.4g} on {joint_words(_which(far))}"
    degrees = _of_all(turning, "deg", complete=True)
    geared, alone = _geared(turning, known.ratios), _alone(far, turning)
    severity: Severity = "error" if sure else "warning"
    told = _Told(recording, robot, far, stated, known.ratios).by_whom()
    swapped = () if "by dq" in told.because else _exchanged(recording, robot, far)
    if swapped:  # limits and weight were asked of what may be torques
        told = _Answer()
    if told.unit == "deg":
        yield CheckFinding(
            severity, "degrees", f"{reaches}: these look like degrees{told.because}",
            f"q must be in rad: --map {_options(degrees)}{alone}; motor-side angles: --map "
            f"{_options(geared)}{_ratio(known)}", mends=(*degrees, *(replace(m, complete=False)
                                                                    for m in geared)),
        )  # fmt: skip
    elif told.unit == "motor":
        if told.factor and known.ratios is None:
            geared = tuple(Mend(m.field, f"1/{told.factor:.4g}") for m in geared)
        yield CheckFinding(
            severity, "motor_side", f"{reaches}: these are angles at the motor{told.because}",
            f"q must be at the joint: --map {_options(geared)}{_ratio(known)}", mends=geared,
        )  # fmt: skip
    else:
        turns = f", or {largest[far].max() / (2 * np.pi):.0f} turns" if not sure else ""
        off = _whole_turns_off(recording, robot, far)
        a_turn = "whole turns off, " if off else ""
        told_off = f"turns: --map {_options(off)}; " if off else ""
        if swapped:
            a_turn = "q and tau in each other's columns, " + a_turn
            told_off = f"exchanged: --map {_options(swapped)}; " + told_off
        yield CheckFinding(
            severity, "angle_unit",
            f"{reaches}: {a_turn}degrees, or angles at the motor{turns}; neither speeds nor limits "
            f"nor weight tell which{told.because}",
            f"{told_off}degrees: --map {_options(degrees)}{alone}; at the motor: --map "
            f"{_options(geared)}{_ratio(known)}",
            mends=tuple(replace(m, complete=False) for m in (*swapped, *off, *degrees, *geared)),
        )  # fmt: skip


def _whole_numbers(q: Array) -> bool:
    """Are all of them whole, and beyond what a servo says in whole degrees?"""
    return bool(q.size and np.abs(q).max() > TURN and np.all(q == np.round(q)))


@dataclass(frozen=True)
class _Answer:
    """unit: deg, motor, or '' where nothing tells; factor: the ratio that was seen."""

    unit: str = ""
    because: str = ""
    factor: float = 0.0


@dataclass(frozen=True)
class _Told:
    recording: Recording
    robot: Robot | None
    far: Flags
    stated: Flags
    ratios: Sequence[float] | None

    def by_whom(self) -> _Answer:
        """The surest witness first; two that contradict each other leave it open."""
        if (self.far & self.stated).all(where=self.far):
            return _Answer("motor")
        by_speed = self._by_speed()
        by_limits = self._by_limits()
        if by_speed.unit and by_limits.unit and by_speed.unit != by_limits.unit:
            return _Answer(because=f" (speeds: {by_speed.unit}, limits: {by_limits.unit})")
        if by_speed.unit or by_limits.unit:
            return by_speed if by_speed.unit else by_limits
        return self._by_weight()

    def _by_speed(self) -> _Answer:
        """Speeds are logged at the joint in rad/s, or tell nothing."""
        if self.recording.dq is None:
            return _Answer()
        slopes = np.array([
            abs(slope) for j in _which(self.far)
            if (slope := slope_of_speed(self.recording, j)) is not None
        ])  # fmt: skip
        if not len(slopes):
            return _Answer()
        if (np.abs(slopes / DEGREE - 1) < ALIKE).all():
            return _Answer("deg", ", by dq")
        if self.ratios is not None:
            own = np.array([1 / self.ratios[j] for j in _which(self.far)])
            same = len(own) == len(slopes) and (np.abs(slopes / own - 1) < ALIKE).all()
            return _Answer("motor", ", by dq") if same else _Answer()
        ratio = float(1 / np.median(slopes))
        alike = bool((np.abs(slopes * ratio - 1) < ALIKE).all())
        if alike and GEARS[0] < ratio < GEARS[1] and self._slow_enough():
            return _Answer("motor", f", by dq with a ratio of {ratio:.4g}", _round(ratio))
        return _Answer()

    def _slow_enough(self) -> bool:
        """Whether the speeds are a joint's, in rad/s."""
        if self.robot is None or self.recording.dq is None:
            return False
        usual = np.quantile(np.abs(self.recording.dq), 0.99, axis=0)  # noise has its spikes
        return bool((usual < BEYOND * self.robot.velocity).all())

    def _by_limits(self) -> _Answer:
        """A unit in which a joint would turn further than it can is not the one."""
        if self.robot is None:
            return _Answer()
        degrees = self._within(np.full(self.recording.joints, DEGREE))
        if not degrees:
            return _Answer("motor", ", by the limits: too far for degrees")
        if self.ratios is not None and not self._within(1 / np.asarray(self.ratios)):
            return _Answer("deg", ", by the limits: too far for the gears")
        return _Answer()

    def _within(self, factors: Array) -> bool:
        assert self.robot is not None
        turned = np.ptp(self.recording.q, axis=0) * factors  # where its zero is nobody knows
        able = BEYOND * (self.robot.upper - self.robot.lower)
        return bool((turned <= able)[self.far].all())

    def _by_weight(self) -> _Answer:
        if self.robot is None:
            return _Answer()
        part = middle_of(self.recording)
        turning = ~self.robot.prismatic

        def left(factors: Array) -> Array:
            assert self.robot is not None
            scaled = np.where(turning & ~self.stated, factors, 1.0)
            return squares_left(replace(part, q=part.q * scaled), self.robot)

        ones = np.ones(self.recording.joints)
        degrees = left(DEGREE * ones)
        if not len(degrees):
            return _Answer()
        if self.ratios is not None:
            geared = left(1 / np.asarray(self.ratios))
            if surely_less(degrees, geared):
                return _Answer("deg", ", by the arm's weight")
            if surely_less(geared, degrees):
                return _Answer("motor", ", by the arm's weight")
            return _Answer()
        if all(surely_less(degrees, left(DEGREE * other * ones)) for other in OTHERS):
            return _Answer("deg", ", by the arm's weight")
        return _Answer()


def slope_of_speed(recording: Recording, j: int) -> float | None:
    """dq over the slope of q; None where they do not go together, or nothing moves."""
    if recording.dq is None:
        return None
    own, dq = np.gradient(recording.q[:, j]) * recording.rate, recording.dq[:, j]
    power = float(own @ own)
    if np.ptp(recording.q[:, j]) <= 0.05 or power <= 0:
        return None
    slope = float(own @ dq) / power
    explained = slope * float(own @ dq) / max(float(dq @ dq), 1e-300)
    return slope if explained >= 0.5 else None


def _far(recording: Recording, robot: Robot | None, largest: Array) -> Flags:
    far = largest > WHOLE_TURNS
    if robot is None:
        return np.asarray(far)
    beyond = (recording.q < BEYOND * robot.lower) | (recording.q > BEYOND * robot.upper)
    return np.asarray(far | (beyond.any(axis=0) & (largest > np.pi) & ~_unbounded(robot, len(far))))


def _unbounded(robot: Robot | None, n: int) -> Flags:
    if robot is None:
        return np.zeros(n, bool)
    return np.asarray(~(np.isfinite(robot.lower) & np.isfinite(robot.upper)))


def _whole_turns_off(recording: Recording, robot: Robot | None, far: Flags) -> tuple[Mend, ...]:
    """What brings the joints that are far off between their limits, where whole turns do."""
    if robot is None or (far & _unbounded(robot, len(far))).any():
        return ()
    turn, joints = 2 * np.pi, _which(far)
    q = np.stack([centred(recording.q[:, j], turn) for j in joints], axis=1)
    within = (q >= robot.lower[joints]) & (q <= robot.upper[joints])
    return tuple(Mend(f"q{j + 1}", "wrap2pi*rad") for j in joints) if within.all() else ()


def _exchanged(recording: Recording, robot: Robot | None, far: Flags) -> tuple[Mend, ...]:
    """Where what is called a torque runs as an angle does: smoother than what is called the angle,
    and between the joint's limits. Friction and noise make a torque the rougher of the two."""
    q, tau = recording.q[:, far], recording.tau[:, far]
    if robot is None or (_rough(q) <= _rough(tau)).any():
        return ()
    within = (tau >= robot.lower[far]) & (tau <= robot.upper[far])
    if not within.all():
        return ()
    columns = [(f"q{j + 1}", f"tau{j + 1}") for j in range(recording.joints)]
    pairs = [*columns, *((tau, q) for q, tau in columns)]
    return tuple(Mend(field, "", source=other) for field, other in pairs)


def _rough(values: Array) -> Array:
    """(samples, k) → (k,): how much of it is from sample to sample, in any unit."""
    spread = np.maximum(values.std(axis=0), 1e-300)
    return np.asarray(np.diff(values, 2, axis=0).std(axis=0) / spread)


def _of_all(turning: Flags, unit: str, complete: bool) -> tuple[Mend, ...]:
    if turning.all():
        return (Mend("q{n}", unit, complete),)
    return tuple(Mend(f"q{j + 1}", unit, complete) for j in _which(turning))


def _alone(far: Flags, turning: Flags) -> str:
    """The others may be in rad already: none is farther than it may go."""
    if (far == turning).all():
        return ""
    own = tuple(Mend(f"q{j + 1}", "deg", True) for j in _which(far))
    return f", or --map {_options(own)} where {joint_words(_which(far))} alone"


def _geared(turning: Flags, ratios: Sequence[float] | None) -> tuple[Mend, ...]:
    if ratios is None:
        return _of_all(turning, "1/RATIO", complete=False)
    if turning.all() and len(set(ratios)) == 1:
        return (Mend("q{n}", f"1/{ratios[0]:.10g}"),)
    return tuple(Mend(f"q{j + 1}", f"1/{ratios[j]:.10g}") for j in _which(turning))


def _which(flags: Flags) -> list[int]:
    return [int(j) for j in np.flatnonzero(flags)]


def _options(mends: Sequence[Mend]) -> str:
    return " ".join(mend.option for mend in mends)


def _ratio(known: Known) -> str:
    return "" if known.ratios is not None else " with the gear ratio"


def _round(ratio: float) -> float:
    """Ratios are mostly whole; a slope knows them to a percent at best."""
    whole = round(ratio)
    return float(whole) if abs(ratio - whole) < 0.005 * ratio else ratio
