"""A recorded run, played through the protocol: the same angles and torques, cycle by cycle.

The arm on the record does not listen: torques are taken in and forgotten. For looking at a run
with the tools of a live arm, and for trying a controller against what really was measured.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from backends.faults import fault
from backends.protocol import Array, Feedback
from pa10d.common.errors import UserError
from pa10d.measurement.recording import Recording
from pa10d.profile import Profile
from pa10d.store.csv_import import read_csv
from pa10d.store.run_reader import read_run, to_recording

KEY = "simulation.options.recording"
OFF = 0.01  # of the profile's rate: less is what stamps scatter by


class ReplayBackend:
    """``read`` gives the next sample; after the last one a fault of kind ``ended``."""

    switching = False  # a recording is enabled at once

    def __init__(self, recording: Recording, realtime: bool = False) -> None:
        self.recording, self.realtime = recording, realtime
        self.n = recording.joints
        self.period = 1.0 / recording.rate
        self.warnings = [
            f"'{recording.name}' is a recording: what it shows does not depend on the torques sent"
        ]
        self._next = 0
        self._feedback = Feedback(
            0.0, np.zeros(self.n), np.zeros(self.n), np.zeros(self.n, int), np.zeros(self.n, int)
        )

    def open(self) -> None:
        self._next = 0

    def begin_enable(self) -> None: ...

    def read(self) -> Feedback:
        recording, k = self.recording, self._next
        if k >= len(recording.t):
            raise fault("ended", f"'{recording.name}' is over after {recording.duration:.3f} s")
        self._next = k + 1
        feedback = self._feedback
        feedback.time = float(recording.t[k])
        feedback.q[:], feedback.tau[:] = recording.q[k], recording.tau[k]
        if recording.temperature is not None:
            feedback.temperature = recording.temperature[k].copy()
        return feedback

    def write(self, torque: Array) -> None:
        if not np.isfinite(torque).all():
            raise fault("torque", f"torque command is not finite: {np.asarray(torque).tolist()}")

    def quick_stop(self) -> None: ...

    def begin_disable(self) -> None: ...

    def begin_reset(self) -> None:
        self._next = 0

    def close(self) -> None: ...


def open_backend(profile: Profile) -> ReplayBackend:
    """The run that the profile's ``simulation.options.recording`` names (MCAP bag or CSV)."""
    simulation = profile.simulation
    named = simulation.options.get("recording") if simulation else None
    if not isinstance(named, str):
        raise UserError(f"{profile.path}: {KEY}: missing, expected the file of a recorded run")
    path = profile.path.parent / named
    axes = len(profile.joints or profile.drives or [])
    recording = _load(path, profile, axes)
    if axes and recording.joints != axes:
        raise UserError(f"{path}: {recording.joints} joints, the profile has {axes}")
    arm = ReplayBackend(recording, realtime=bool(simulation and simulation.clock == "real"))
    rate = profile.control.rate
    if abs(recording.rate - rate) > OFF * rate:
        arm.warnings.append(
            f"'{recording.name}' is played at the {recording.rate:.4g} Hz that it was recorded at; "
            f"the profile says {rate:g} Hz, by which gains are made and times are shown: set "
            f"control.rate to {recording.rate:.4g}"
        )
    return arm


def _load(path: Path, profile: Profile, axes: int) -> Recording:
    if not path.is_file():
        raise UserError(f"{profile.path}: {KEY}: no file {path}, expected a recorded run")
    if path.suffix == ".mcap":
        run = read_run(path)
        if profile.joints and len(run.joints) == axes and run.joints != tuple(profile.joints):
            raise UserError(
                f"{path}: recorded of the joints {', '.join(run.joints)}; the profile has "
                f"{', '.join(profile.joints)}, expected the same in this order"
            )
        return run.recording(path.stem)[0]
    if not axes:
        raise UserError(f"{profile.path}: joints: missing, expected the joints of {path}")
    table = read_csv(path, axes, profile.name, profile.torque_constants)
    return to_recording(table.samples, table.time_zero_ns, path.name.partition(".")[0])[0]
