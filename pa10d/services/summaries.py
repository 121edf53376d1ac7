"""A run in a few numbers per joint."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pa10d.common.errors import UserError
from pa10d.store import RunInfo, RunStore


@dataclass(frozen=True)
class JointSummary:
    """One joint's ranges. joint: from 1; q: rad (m); dq: rad/s, differences of q; tau: N·m."""

    joint: int
    name: str
    q_min: float
    q_max: float
    dq_max: float
    tau_min: float
    tau_max: float


def joint_summaries(store: RunStore, info: RunInfo) -> list[JointSummary]:
    """One per joint; empty for a run without samples."""
    try:
        recording = store.recording(info)
    except UserError:
        return []
    speed = np.abs(np.gradient(recording.q, axis=0)).max(axis=0) * recording.rate
    return [
        JointSummary(
            joint=j + 1,
            name=name,
            q_min=float(recording.q[:, j].min()),
            q_max=float(recording.q[:, j].max()),
            dq_max=float(speed[j]),
            tau_min=float(recording.tau[:, j].min()),
            tau_max=float(recording.tau[:, j].max()),
        )
        for j, name in enumerate(info.joints)
    ]
