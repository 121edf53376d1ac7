"""How near a planned motion comes to what it must not reach, before anything moves.

The numbers are those of the pre-check: the same bodies, the same braking distance, the same torque.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pa10d.experiments.motion import Whole
from pa10d.trajectory.capsules import Capsules
from pa10d.trajectory.limits import MotionLimits

Array = NDArray[np.float64]

POSES = 600  # of a motion that are sent to be looked at
DIGITS = 4  # of a pose's angles: 0.1 mrad


def margins(whole: Whole, torque: Array, limits: MotionLimits, bodies: Capsules) -> dict[str, Any]:
    """Per joint what is left to the nearer position limit, braking included, and the shares of the
    other limits that are used; what is left between the arm's bodies, above the floor and to boxes.

    torque: (N, n) N·m that the motion needs. rad (m) and m; every figure with its second.
    """
    t, q, dq, ddq = whole.samples
    stop = q + dq * np.abs(dq) / (2 * limits.acceleration)
    left = np.minimum(limits.upper - stop, stop - limits.lower)
    at = np.argmin(left, axis=0)
    joints = [
        {
            "joint": j + 1,
            "position": float(left[at[j], j]),
            "at": float(t[at[j]]),
            "velocity": _share(dq[:, j], limits.velocity[j]),
            "acceleration": _share(ddq[:, j], limits.acceleration[j]),
            "torque": _share(torque[:, j], limits.torque[j]),
        }
        for j in range(q.shape[1])
    ]
    gaps, pairs = bodies.clearance(q), len(bodies.pairs)
    low = pairs + len(bodies.grounded)
    return {
        "joints": joints,
        "self": _nearest(t, gaps[:, :pairs], bodies, 0),
        "floor": _nearest(t, gaps[:, pairs:low], bodies, pairs),
        "boxes": _nearest(t, gaps[:, low:], bodies, low),
    }


def preview(whole: Whole) -> dict[str, Any]:
    """Poses of a motion at equal steps of ``dt`` s, few enough to be sent; ``begins``, ``ends``: s
    of the plan itself, without the way to it."""
    t, q = whole.samples.t, whole.samples.q
    every = max(1, -(-len(q) // POSES))
    return {
        "dt": float(every * (t[1] - t[0])),
        "poses": np.round(q[::every], DIGITS).tolist(),
        "begins": float(t[min(whole.first, len(t) - 1)]),
        "ends": float(t[whole.last - 1]),
        "seconds": float(t[-1]),
    }


def _share(values: Array, limit: float) -> float | None:
    return float(np.abs(values).max() / limit) if np.isfinite(limit) else None


def _nearest(t: Array, gaps: Array, bodies: Capsules, first: int) -> dict[str, Any] | None:
    """The smallest gap; None where there is nothing that could be met."""
    if not gaps.size:
        return None
    row, column = np.unravel_index(int(np.argmin(gaps)), gaps.shape)
    where = bodies.name(first + int(column))
    return {"margin": float(gaps[row, column]), "at": float(t[row]), "between": where}
