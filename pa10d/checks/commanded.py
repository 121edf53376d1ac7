"""A torque that is what a controller asked for, told by its law and not by a name.

Where the wanted positions were logged, too, a PD law on what they differ by from the measured ones
explains a commanded torque to the last digits. A measured one has been through a current loop, a
motor and a sensor. Where motion alone explains the torque as well, nothing can be told: what a
joint of inertia and viscous friction needs is such a law, too, if its loop lags evenly.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pa10d.checks.finding import CheckFinding, joint_label
from pa10d.measurement.recording import Recording

Array = NDArray[np.float64]

LEFT = 0.005  # of the torque's spread that a law may leave: sensors of motor currents waver by 1 %


def check_commanded(
    recording: Recording, wanted: Array, names: tuple[str, ...] | None
) -> Iterator[CheckFinding]:
    """wanted: (N, n) rad, the positions that were asked for, nan for joints without."""
    measured = recording.dq
    if measured is None:
        measured = np.gradient(recording.q, axis=0) * recording.rate
    asked = np.gradient(wanted, axis=0) * recording.rate
    for j in range(recording.joints):
        tau, off = recording.tau[:, j], wanted[:, j] - recording.q[:, j]
        spread = float(tau.std())
        if spread == 0 or not np.isfinite(off).all() or not off.any():
            continue
        law = np.column_stack(
            [off, asked[:, j] - measured[:, j], measured[:, j], np.ones(len(off))]
        )
        dq = measured[:, j]
        motion = np.column_stack([np.gradient(dq) * recording.rate, dq, np.ones(len(off))])
        left = _left_by(law, tau)
        if left < LEFT * spread <= _left_by(motion, tau):
            yield CheckFinding(
                "warning",
                "commanded",
                f"{joint_label(j, names)}: tau is a PD law on the tracking error, to "
                f"{left / spread:.1g} of its spread: what a controller asked for, "
                "not a measured torque",
                "map the measured torque or the motor current; what the drive's own loop adds is "
                "missing otherwise",
                j + 1,
            )


def _left_by(columns: Array, tau: Array) -> float:
    """Spread of what the columns (N, k) leave of the torque (N,), N·m."""
    size = np.linalg.norm(columns, axis=0)
    scaled = columns / np.where(size > 0, size, 1.0)
    return float((tau - scaled @ np.linalg.lstsq(scaled, tau, rcond=None)[0]).std())
