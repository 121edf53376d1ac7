"""The one exit for torque. Whatever computed it, nothing reaches a drive but through here."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pa10d.control.envelope import Envelope
from pa10d.control.faults import LoopFault
from pa10d.control.limits import ArmLimits
from pa10d.control.outside import Reach
from pa10d.control.states import POWERED, ArmState

Array = NDArray[np.float64]

STANDING = 0.25  # of the velocity limit: an arm that shall stand and is faster runs away …
ALONE = 0.35  # … but one joint that takes no other along, or all that were held alone before: it is
# twice the way on which the drives stop it


class TorqueExit:
    """Finite, allowed by the state, inside the envelope, within limits, limited in its rate."""

    def __init__(self, limits: ArmLimits, period: float) -> None:
        self.limits = limits
        self.sent = np.zeros_like(limits.torque)
        self._step = limits.torque_rate * period
        self.reach = Reach(limits)
        self._envelope = Envelope(limits, period, self.reach)
        standing = replace(limits, velocity=STANDING * limits.velocity)
        self._standing = Envelope(standing, period, self.reach)
        alone = replace(limits, velocity=ALONE * limits.velocity)
        self._alone = Envelope(alone, period, self.reach)

    def watch(
        self,
        q: Array,
        dq: Array,
        age: NDArray[np.int64],
        wanted_q: Array,
        live: NDArray[np.bool_],
        standing: bool = False,
        alone: bool = False,
    ) -> None:
        """Raise Violation where a live axis has left the envelope of the motion, or of ``standing``
        where nothing may move by itself; nor is any axis faster while one is outside its limits.
        alone: all but one are in their brakes, or each was held so before."""
        self.reach.follow(q)
        envelope = self._standing if standing or self.reach.widened else self._envelope
        if alone and not self.reach.widened:
            envelope = self._alone
        envelope.watch(q, dq, age, wanted_q, live)

    def send(self, wanted: Array, state: ArmState, live: NDArray[np.bool_]) -> Array:
        """(n,) N·m that may go to the drives; zero for axes that are not live."""
        if state not in POWERED:
            raise LoopFault("torque_state", f"torque asked for while {state.label}")
        if not np.isfinite(wanted).all():
            axis = int(np.flatnonzero(~np.isfinite(wanted))[0])
            raise LoopFault("not_finite", "the controller gave no finite torque", axis)
        limit = self.limits.torque
        held = np.minimum(np.maximum(wanted, -limit), limit)
        change = np.minimum(np.maximum(held - self.sent, -self._step), self._step)
        self.sent = np.where(live, self.sent + change, 0.0)
        return self.sent

    def restart(self) -> None:
        """The drives were unpowered: their torque is zero."""
        self.sent = np.zeros_like(self.sent)
