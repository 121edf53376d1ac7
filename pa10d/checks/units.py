"""Degrees for radians, wrong torque units, values beyond the robot's limits."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pa10d.checks.finding import Finding, Mend, joint_label, percent
from pa10d.dynamics.robot import Robot
from pa10d.measurement.recording import Recording

Array = NDArray[np.float64]

DEGREE = np.pi / 180
WHOLE_TURNS = 4 * np.pi  # rad: hardly any arm turns further


def beyond_limits(recording: Recording, robot: Robot) -> Iterator[Finding]:
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
                yield Finding(
                    "warning",
                    "limits",
                    f"{joint_label(j, robot.joint_names)}: {name} reaches {furthest:.4g} {unit}, "
                    f"limits {lower[j]:.4g} … {upper[j]:.4g} ({percent(out.mean())} of the "
                    "samples are beyond)",
                    "",
                    j + 1,
                )


def check_units(recording: Recording, robot: Robot | None) -> Iterator[Finding]:
    """Findings from sizes alone."""
    turning = np.ones(recording.joints, bool) if robot is None else ~robot.prismatic
    largest = np.abs(recording.q).max(axis=0)
    yield from _angles(largest, turning, robot, recording)
    if recording.dq is not None:
        yield from _speeds(recording, recording.dq, robot)
    if robot is not None:
        yield from _torques(np.abs(recording.tau).max(axis=0), robot)


def _angles(
    largest: Array, turning: NDArray[np.bool_], robot: Robot | None, recording: Recording
) -> Iterator[Finding]:
    if (largest[turning] > 1e4).any():
        counts = Mend("q{n}", "rev/COUNTS", complete=False)
        yield Finding(
            "error",
            "counts",
            f"q reaches {largest.max():.3g}: these look like encoder counts",
            f"q must be in rad: --map {counts.option} with the joint's counts per revolution",
            mends=(counts,),
        )
        return
    bounded = np.ones(recording.joints, bool)
    far = turning & (largest > WHOLE_TURNS)
    if robot is not None:
        bounded = np.isfinite(robot.lower) & np.isfinite(robot.upper)
        within = (recording.q * DEGREE >= robot.lower) & (recording.q * DEGREE <= robot.upper)
        beyond = (recording.q < 1.5 * robot.lower) | (recording.q > 1.5 * robot.upper)
        far |= turning & beyond.any(axis=0) & within.all(axis=0) & (largest > np.pi)
    if far.any():
        joints = ", ".join(str(j + 1) for j in np.flatnonzero(far))
        sure = bool((far & bounded).any())  # a joint without limits may turn on and on
        degrees, geared = Mend("q{n}", "deg"), Mend("q{n}", "1/RATIO", complete=False)
        yield Finding(
            "error" if sure else "warning",
            "degrees",
            f"q reaches {largest[far].max():.4g} on joint {joints}: these look like degrees"
            + ("" if sure else f", or like {largest[far].max() / (2 * np.pi):.0f} turns"),
            f"q must be in rad: --map {degrees.option}; motor-side angles: {geared.option} with "
            "the gear ratio",
            mends=(degrees, geared),
        )


def _speeds(recording: Recording, dq: Array, robot: Robot | None) -> Iterator[Finding]:
    names = None if robot is None else robot.joint_names
    own = np.gradient(recording.q, axis=0) * recording.rate
    for j in range(recording.joints):
        power = float(own[:, j] @ own[:, j])
        moving = np.ptp(recording.q[:, j]) > 0.05 and power > 0
        slope = float(own[:, j] @ dq[:, j]) / power if moving else 1.0
        explained = slope * float(own[:, j] @ dq[:, j]) / max(float(dq[:, j] @ dq[:, j]), 1e-300)
        if not moving or explained < 0.5:
            continue
        label = joint_label(j, names)
        if abs(slope * DEGREE - 1) < 0.2:
            said = "is in degrees per second"
        elif slope < 0:
            said = "has the opposite sign of the slope of q"
        elif not 0.8 < slope < 1.25:
            said = f"is {slope:.3g} times the slope of q"
        else:
            continue
        yield Finding(
            "warning",
            "velocity_unit",
            f"{label}: dq {said}",
            "the fit differentiates q itself; mend dq for other uses",
            j + 1,
        )


def _torques(largest: Array, robot: Robot) -> Iterator[Finding]:
    known = np.isfinite(robot.effort)
    if not known.any():
        return
    share = largest[known] / robot.effort[known]
    if share.max() < 0.01:
        geared = Mend("tau{n}", "RATIO", complete=False)
        yield Finding(
            "warning",
            "torque_small",
            f"the torques stay below {percent(share.max())} of the limits: perhaps they are "
            "motor-side, or in kN·m",
            f"tau must be in N·m at the joint: --map {geared.option} with the gear ratio",
            mends=(geared,),
        )
    if np.median(share) > 3:
        small, rated = Mend("tau{n}", "mNm"), Mend("tau{n}", "RATED/1000", complete=False)
        yield Finding(
            "warning",
            "torque_large",
            f"the torques are {np.median(share):.3g} times the limits (median joint): perhaps they "
            "are in N·mm, per mille or counts",
            f"tau must be in N·m at the joint: --map {small.option}, or of per mille "
            f"{rated.option}",
            mends=(small, rated),
        )
