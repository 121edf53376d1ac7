"""FIGAROH's own way from arrays to base parameters, for comparison (pip install figaroh==1.0.2).

Its identification class as its users run it: low-pass of the motion, regressor sample by sample,
decimation by 10 of every column, double QR, iteratively weighted least squares with standard
deviations and its quality figures; no plots, no files.
"""

from __future__ import annotations

import contextlib
import io
import warnings
from typing import Any

import numpy as np

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    from figaroh.identification.base_identification import BaseIdentification
    from figaroh.tools.regressor import build_regressor_basic, build_regressor_reduced

CUTOFF = 10.0  # Hz
RATE = 500.0


class Peer(BaseIdentification):
    """The class a user writes: where the data come from, and what is in the model."""

    def __init__(self, robot: Any, data: Any) -> None:
        import pinocchio as pin

        model, self.order = robot.pinocchio()
        self.given = data
        super().__init__(pin.RobotWrapper(model), "")

    def load_param(self, config_file: str, setting_type: str = "identification") -> None:
        joints = list(range(self.model.nv))
        self.identif_config = {
            "robot_name": self.model.name,
            "act_idxq": joints,
            "act_idxv": joints,
            "has_friction": True,
            "has_actuator_inertia": True,
            "is_joint_torques": True,
            "fv": [0.0] * len(joints),
            "fs": [0.0] * len(joints),
            "Ia": [0.0] * len(joints),
            "filter_config": {
                "differentiation_method": "gradient",
                "filter_params": {
                    "nbutter": 4,
                    "f_butter": CUTOFF,
                    "med_fil": 5,
                    "f_sample": RATE,
                },
            },
        }

    def load_trajectory_data(self, data_source: str | None = None) -> dict[str, np.ndarray]:
        d = self.given
        return {
            "timestamps": np.arange(len(d.q)) / RATE,
            "positions": d.q[:, self.order],
            "velocities": d.dq[:, self.order],
            "accelerations": d.ddq[:, self.order],
            "torques": d.tau[:, self.order],
        }

    def error(self, unseen: Any) -> list[float]:
        """RMS against the true torque per joint, N·m."""
        q, dq, ddq = (x[:, self.order] for x in (unseen.q, unseen.dq, unseen.ddq))
        whole = build_regressor_basic(self.robot, q, dq, ddq, self.identif_config)
        base = build_regressor_reduced(whole, self._idx_eliminated)[:, self._base_indices]
        error = np.empty_like(unseen.q)
        error[:, self.order] = (base @ self.phi_base).reshape(-1, len(q)).T
        error -= unseen.true
        return [round(float(v), 5) for v in np.sqrt(np.mean(error[300:-300] ** 2, axis=0))]


def identify(robot: Any, data: Any) -> Peer:
    """Everything that is timed; what it prints is kept off stdout."""
    with contextlib.redirect_stdout(io.StringIO()), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        peer = Peer(robot, data)
        peer.initialize()
        peer.solve(decimate=True, decimation_factor=10, plotting=False, wls=True)
    return peer
