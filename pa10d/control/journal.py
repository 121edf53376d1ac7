"""Notes every cycle down in the ring, and the fault that ended it all."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pa10d.control.faults import Fault
from pa10d.control.reference import MotionUnderWay
from pa10d.control.ring import Ring
from pa10d.control.states import ArmState
from pa10d.control.torque_path import TorquePath

Array = NDArray[np.float64]


class Journal:
    """Fills one row per cycle; the places are looked up once."""

    def __init__(self, ring: Ring) -> None:
        self.ring = ring
        self._row = np.zeros(ring.layout.width)
        at = ring.layout.scalars
        self._late, self._busy, self._missed = (at[k] for k in ("late", "busy", "missed"))
        self._state, self._motion, self._place = (at[k] for k in ("state", "motion", "row"))
        self._time, self._recording, self._fault = (at[k] for k in ("time", "recording", "fault"))
        view = {name: self._row[cut] for name, cut in ring.layout.vectors.items()}
        self._q, self._dq, self._tau = view["q"], view["dq"], view["tau"]
        self._q_ref, self._dq_ref, self._ddq_ref = view["q_ref"], view["dq_ref"], view["ddq_ref"]
        self._torque, self._status, self._age = view["torque"], view["status"], view["age"]
        self._temperature = view["temperature"]
        self._temperature[:] = np.nan

    @property
    def count(self) -> int:
        """Records written so far."""
        return self.ring.written

    def timing(self, late: float, busy: float, missed: int) -> None:
        """What the clock of the loop saw: s, s, cycles."""
        row = self._row
        row[self._late], row[self._busy], row[self._missed] = late, busy, missed

    def publish(
        self, path: TorquePath, state: ArmState, motion: MotionUnderWay | None, *, faulty: bool
    ) -> None:
        """One record of the arm as it stands."""
        row = self._row
        row[self._time], row[self._state] = path.time, state
        row[self._recording] = motion is not None and motion.recording
        row[self._fault] = faulty
        row[self._motion] = motion.number if motion else 0
        row[self._place] = motion.row if motion else 0
        self._q[:], self._dq[:], self._tau[:] = path.measured_q, path.dq, path.tau
        reference = path.reference
        self._q_ref[:], self._dq_ref[:] = reference.q, reference.dq
        self._ddq_ref[:], self._torque[:] = reference.ddq, path.sent
        self._status[:], self._age[:] = path.status, path.age
        if path.temperature is not None:
            self._temperature[:] = path.temperature
        self.ring.append(row)

    def fault(self, fault: Fault | None) -> None:
        """Last words, kept even where this process ends next."""
        self.ring.say(None if fault is None else fault.document())

    def stopped(self, why: str) -> None:
        """Why a motion without a fault ends before its end, where there is more to say."""
        self.ring.say({"sentence": why} if why else None)
