"""Joints of which something is known, without an arm behind them."""

from __future__ import annotations

import numpy as np

from pa10d.control.gains import PidGains
from pa10d.control.joint_figures import Inertias, JointFigures
from pa10d.control.known_joints import KnownJoints, MeasuredJoints


def known_joints(kd: float = 0.0, n: int = 2, sentences: tuple[str, ...] = ()) -> KnownJoints:
    """Damping of all joints ``kd``; the second one's servo is slower than asked for, and has no
    stable gains in every pose."""
    one = np.ones(n)
    figures = JointFigures(one, one, one, one, 0 * one, np.inf * one, one, one, 0 * one)
    slow, peak = 4.0 * one, 1.5 * one
    slow[1:], peak[1:] = 1.5, np.inf
    return KnownJoints(
        figures=figures,
        gains=PidGains(one, one, kd * one, one),
        asked=4.0,
        bandwidth=slow,
        sensitivity=peak,
        inertia=Inertias(one, one, one),
        resonance=np.inf * one,
        sentences=sentences,
    )


def measured_joints(kd: float = 0.0, **more: object) -> MeasuredJoints:
    """The same as it is kept."""
    known = known_joints(kd, **more)  # type: ignore[arg-type]
    return MeasuredJoints(known, "2026-01-01 10:00 UTC", ("a", "b"), "arm", "f" * 64)
