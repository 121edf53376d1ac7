"""What a user should know of a recording before fitting: arrays in, findings out."""

from __future__ import annotations

from pa10d.checks.angles import Known, check_angles
from pa10d.checks.channels import check_channels, check_limits
from pa10d.checks.commanded import check_commanded
from pa10d.checks.counters import check_counters, wraps_in
from pa10d.checks.delay import Delay, check_delay, estimate_delay
from pa10d.checks.finding import CheckFinding, Mend
from pa10d.checks.geometry import check_geometry
from pa10d.checks.gravity import check_gravity
from pa10d.checks.held import check_held
from pa10d.checks.order import check_order
from pa10d.checks.resolution import check_resolution
from pa10d.checks.timing import check_timing, unit_of_stamps
from pa10d.checks.units import beyond_limits, check_speeds, check_units
from pa10d.common.parallel import one_thread
from pa10d.dynamics.robot import Robot
from pa10d.measurement.recording import Recording
from pa10d.measurement.sampling import Timing

__all__ = [
    "OF_ONE_TORQUE",
    "CheckFinding",
    "Delay",
    "Known",
    "Mend",
    "beyond_limits",
    "check_commanded",
    "check_recording",
    "estimate_delay",
    "in_order",
    "unit_of_stamps",
]

OF_ONE_TORQUE = frozenset({"clipped", "dull", "frozen"})
"""Errors that leave what the other joints' torques tell of the arm as it is."""
_ORDER = {"error": 0, "warning": 1, "info": 2}


def check_recording(
    recording: Recording,
    timing: Timing | None = None,
    robot: Robot | None = None,
    *,
    delay: bool = True,
    known: Known | None = None,
) -> list[CheckFinding]:
    """Everything worth saying, gravest first.

    timing: how the stamps were before they became equal steps; robot: for limits and the delay;
    delay: whether to fit a model for it and for signs, which takes longer than all the rest;
    known: what a file and a profile tell beside the samples.
    """
    names = None if robot is None else robot.joint_names
    known = known or Known()
    wraps = wraps_in(recording) if known.wraps is None else known.wraps
    findings = [
        *check_timing(recording, timing),
        *(
            f
            for f in check_channels(recording, names, robot)
            if not (f.code == "jump" and f"q{f.joint}" in wraps)
        ),
        *check_held(recording, names),
        *check_resolution(recording, robot),
        *check_counters(wraps, names),
        *check_units(recording, robot),
    ]
    with one_thread():
        findings += check_angles(recording, robot, known)
    if robot is not None:
        findings += beyond_limits(recording, robot)
        sound = not any(f.severity == "error" and f.code not in OF_ONE_TORQUE for f in findings)
        if sound:
            findings += check_speeds(recording, robot)
            with one_thread():
                findings += check_limits(recording, robot)
        if delay and sound:
            with one_thread():
                findings += check_delay(recording, robot)
                order = list(check_order(recording, robot))
                findings += order or check_geometry(recording, robot)
                if not order and not any(finding.code == "turned" for finding in findings):
                    findings += check_gravity(recording, robot)
    return in_order(findings)


def in_order(findings: list[CheckFinding]) -> list[CheckFinding]:
    """Gravest first."""
    return sorted(findings, key=lambda finding: _ORDER[finding.severity])
