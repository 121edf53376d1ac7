"""What a user should know of a recording before fitting: arrays in, findings out."""

from __future__ import annotations

from threadpoolctl import threadpool_limits

from pa10d.checks.channels import check_channels
from pa10d.checks.commanded import check_commanded
from pa10d.checks.counters import check_counters
from pa10d.checks.delay import Delay, check_delay, estimate_delay
from pa10d.checks.finding import Finding, Mend
from pa10d.checks.geometry import check_geometry
from pa10d.checks.gravity import check_gravity
from pa10d.checks.timing import check_timing, unit_of_stamps
from pa10d.checks.units import beyond_limits, check_units
from pa10d.dynamics.robot import Robot
from pa10d.measurement.recording import Recording
from pa10d.measurement.sampling import Timing

__all__ = [
    "Delay",
    "Finding",
    "Mend",
    "beyond_limits",
    "check_commanded",
    "check_recording",
    "estimate_delay",
    "in_order",
    "unit_of_stamps",
]

_ORDER = {"error": 0, "warning": 1, "info": 2}


def check_recording(
    recording: Recording,
    timing: Timing | None = None,
    robot: Robot | None = None,
    *,
    delay: bool = True,
) -> list[Finding]:
    """Everything worth saying, gravest first.

    timing: how the stamps were before they became equal steps; robot: for limits and the delay;
    delay: whether to fit a model for it and for signs, which takes longer than all the rest.
    """
    names = None if robot is None else robot.joint_names
    findings = [
        *check_timing(recording, timing),
        *check_channels(recording, names),
        *check_counters(recording, names),
        *check_units(recording, robot),
    ]
    if robot is not None:
        findings += beyond_limits(recording, robot)
        if delay and not any(finding.severity == "error" for finding in findings):
            # the matrices are many and small: threads of the linear algebra would mostly wait
            with threadpool_limits(limits=1, user_api="blas"):
                findings += [*check_delay(recording, robot), *check_geometry(recording, robot)]
                if not any(finding.code == "turned" for finding in findings):
                    findings += check_gravity(recording, robot)
    return in_order(findings)


def in_order(findings: list[Finding]) -> list[Finding]:
    """Gravest first."""
    return sorted(findings, key=lambda finding: _ORDER[finding.severity])
