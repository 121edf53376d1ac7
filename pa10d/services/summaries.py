"""A run in a few numbers per joint."""

from __future__ import annotations

from typing import Any

import numpy as np

from pa10d.common.errors import UserError
from pa10d.store import RunInfo, RunStore


def joint_summaries(store: RunStore, info: RunInfo) -> list[dict[str, Any]]:
    """Ranges of position, speed (differences of q) and torque; empty for a run without samples."""
    try:
        recording = store.recording(info)
    except UserError:
        return []
    speed = np.abs(np.gradient(recording.q, axis=0)).max(axis=0) * recording.rate
    return [
        {
            "joint": j + 1,
            "name": name,
            "q_min": float(recording.q[:, j].min()),
            "q_max": float(recording.q[:, j].max()),
            "dq_max": float(speed[j]),
            "tau_min": float(recording.tau[:, j].min()),
            "tau_max": float(recording.tau[:, j].max()),
        }
        for j, name in enumerate(info.joints)
    ]
