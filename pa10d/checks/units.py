"""Speeds and torques in wrong units, values beyond the robot's limits."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pa10d.checks.angles import DEGREE, slope_of_speed
from pa10d.checks.finding import CheckFinding, Mend, joint_label, percent
from pa10d.dynamics.robot import Robot
from pa10d.measurement.recording import Recording

Array = NDArray[np.float64]

OVER = 0.02  # s over which a speed is taken: encoders are coarse
FASTER = 1.5  # times its limit the median joint moves, which no arm does for long
WAY = 0.1  # s over which speeds are added up to the way gone: no encoder is coarse beside that
FURTHEST = 0.2  # of one: more is another unit
TOGETHER = 0.98  # of their squares that speeds and ways share
COMMON = 0.02  # by which speeds may differ from that; of real arms' 0.0025
ALIKE = 0.005  # by which the joints of an arm with a wrong clock differ from each other
MUCH = 10.0  # times: no limit of a URDF is so wrong at most joints


def beyond_limits(recording: Recording, robot: Robot) -> Iterator[CheckFinding]:
    """Real recordings leave the URDF's limits; it is said, never refused."""
    checks = (
        ("q", "rad", recording.q, robot.lower, robot.upper),
        ("dq", "rad/s", recording.dq, -robot.velocity, robot.velocity),
        ("tau", "N·m", recording.tau, -robot.effort, robot.effort),
    )
    for name, unit, values, lower, upper in checks:
        if values is None:
            continue
        for j in range(recording.joints):
            out = (values[:, j] < lower[j]) | (values[:, j] > upper[j])
            if out.any():
                furthest = values[out, j][np.abs(values[out, j]).argmax()]
                yield CheckFinding(
                    "warning",
                    "limits",
                    f"{joint_label(j, robot.joint_names)}: {name} reaches {furthest:.4g} {unit}, "
                    f"limits {lower[j]:.4g} … {upper[j]:.4g} ({percent(out.mean())} of the "
                    "samples are beyond)",
                    "",
                    j + 1,
                )


def check_units(recording: Recording, robot: Robot | None) -> Iterator[CheckFinding]:
    """Findings from sizes alone."""
    if recording.dq is not None:
        yield from _speeds(recording, robot)
        yield from _clock(recording)
    if robot is not None:
        yield from _torques(np.abs(recording.tau).max(axis=0), robot)


def check_speeds(recording: Recording, robot: Robot) -> Iterator[CheckFinding]:
    """How fast joints go from stamp to stamp: much faster than they can where the stamps are in
    longer units than they are taken for, or count samples."""
    known = np.isfinite(robot.velocity)
    span = max(1, round(OVER * recording.rate))
    if not known.any() or len(recording.t) <= 2 * span:
        return
    went = np.abs(recording.q[span:] - recording.q[:-span]) * recording.rate / span
    usual = np.quantile(went, 0.9, axis=0)
    share = usual[known] / robot.velocity[known]
    if np.median(share) < FASTER:  # of most joints: one limit may be a placeholder
        return
    j = int(np.flatnonzero(known)[share.argmax()])
    yield CheckFinding(
        "error" if np.median(share) > MUCH else "warning",
        "time_unit",
        f"by the stamps joint {j + 1} moves at {usual[j]:.3g} {robot.angle_unit(j)}/s, its limit "
        f"is {robot.velocity[j]:.3g}, and others likewise: the stamps are no seconds, or q no rad",
        "say in --map what the stamps count: [min] behind their column, or [1/RATE] where they "
        "number the samples, with the samples' rate in Hz",
    )


def _speeds(recording: Recording, robot: Robot | None) -> Iterator[CheckFinding]:
    names = None if robot is None else robot.joint_names
    for j in range(recording.joints):
        slope = slope_of_speed(recording, j)
        if slope is None:
            continue
        label = joint_label(j, names)
        mend: Mend | None = None
        if abs(slope * DEGREE - 1) < 0.2:
            said, mend = "is in degrees per second", Mend(f"dq{j + 1}", "deg/s")
        elif slope < 0:
            said = "has the opposite sign of the slope of q"
            mend = Mend(f"dq{j + 1}", "-1") if 0.8 < -slope < 1.25 else None
        elif not 0.8 < slope < 1.25:
            said = f"is {slope:.3g} times the slope of q"
        else:
            continue
        yield CheckFinding(
            "warning",
            "velocity_unit",
            f"{label}: dq {said}",
            "the fit differentiates q itself; "
            + (f"--map {mend.option}" if mend else "mend dq")
            + " for other uses",
            j + 1,
            (mend,) if mend else (),
        )


def _clock(recording: Recording) -> Iterator[CheckFinding]:
    """Speeds that differ from the slope of the positions by one factor in every joint."""
    found = [_speed_over_way(recording, j) for j in range(recording.joints)]
    known = np.array([one for one in found if one is not None])
    middle = float(np.median(known)) if len(known) else 1.0
    if len(known) < 2 or not COMMON < abs(middle - 1.0) < FURTHEST:
        return
    if np.any(np.abs(known / middle - 1.0) > ALIKE):
        return
    mend = Mend("time", f"1/{middle:.4g}")
    yield CheckFinding(
        "warning",
        "clock",
        f"dq of every joint that moves is {middle:.3g} times the slope of q: the stamps stand "
        f"{percent(abs(middle - 1.0))} too {'far apart' if middle > 1.0 else 'close'}, or all "
        "speeds are scaled alike",
        "accelerations of q, and what is fitted to them, are wrong with a wrong clock: compare the "
        f"recording's length with a watch; where the stamps are wrong: --map {mend.option}",
        mends=(mend,),
    )


def _speed_over_way(recording: Recording, j: int) -> float | None:
    """dq added up over the way gone meanwhile; None where they do not go together."""
    span = max(1, round(WAY * recording.rate))
    if recording.dq is None or len(recording.t) <= 2 * span or np.ptp(recording.q[:, j]) <= 0.05:
        return None
    step = 0.5 * (recording.dq[1:, j] + recording.dq[:-1, j]) / recording.rate
    told = np.convolve(step, np.ones(span), "valid")
    gone = recording.q[span:, j] - recording.q[:-span, j]
    both = float(told @ gone)
    if both**2 < TOGETHER * float(told @ told) * float(gone @ gone):
        return None
    return both / max(float(gone @ gone), 1e-300)


def _torques(largest: Array, robot: Robot) -> Iterator[CheckFinding]:
    known = np.isfinite(robot.effort)
    if not known.any():
        return
    share = largest[known] / robot.effort[known]
    if share.max() < 0.01:
        geared = Mend("tau{n}", "RATIO", complete=False)
        yield CheckFinding(
            "warning",
            "torque_small",
            f"the torques stay below {percent(share.max())} of the limits: perhaps they are "
            "motor-side, or in kN·m",
            f"tau must be in N·m at the joint: --map {geared.option} with the gear ratio",
            mends=(geared,),
        )
    if np.median(share) > 3:
        small, rated = Mend("tau{n}", "mNm"), Mend("tau{n}", "RATED/1000", complete=False)
        yield CheckFinding(
            "warning",
            "torque_large",
            f"the torques are {np.median(share):.3g} times the limits (median joint): perhaps they "
            "are in N·mm, per mille or counts",
            f"tau must be in N·m at the joint: --map {small.option}, or of per mille "
            f"{rated.option}",
            mends=(small, rated),
        )
