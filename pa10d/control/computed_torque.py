"""Control by a model: its torque ahead, and the joint servo's gains for what is left.

Computed torque asks the model where the arm is, feed-forward where it shall be.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pa10d.control.live_model import LiveModel
from pa10d.control.pid import Pid
from pa10d.control.reference import Reference
from pa10d.dynamics import Robot

Array = NDArray[np.float64]


class ComputedTorque:
    """Model torque at the measured state and the desired acceleration, plus PID feedback.

    The feedback acts in joint torque with the servo's own gains, not through the identified mass
    matrix: a model that is wrong about a small inertia cannot make the loop unstable.
    """

    name = "computed_torque"

    def __init__(self, robot: Robot, model: LiveModel, feedback: Pid) -> None:
        self.model, self._robot, self._feedback = model, robot, feedback
        self.model.torque(robot, *(np.zeros((1, robot.n)) for _ in range(4)))  # compiled before use

    def start(self, reference: Reference, q: Array, dq: Array, torque: Array) -> None:
        """Bumpless: the integral takes what model and feedback do not give."""
        self._feedback.start(reference, q, dq, torque - self._forward(reference, q, dq))

    def torque(self, reference: Reference, q: Array, dq: Array) -> Array:
        """N·m (n,)."""
        return self._forward(reference, q, dq) + self._feedback.torque(reference, q, dq)

    def model_torque(self, q: Array, dq: Array, ddq: Array) -> Array:
        """What the model alone gives along a motion (N, n): N·m (N, n)."""
        return self.model.torque(self._robot, q, dq, dq, ddq)

    def absorb(self, extra: Array) -> None:
        """The feedback's integral takes it."""
        self._feedback.absorb(extra)

    def applied(self, wanted: Array, sent: Array) -> None:
        """Anti-windup of the feedback."""
        self._feedback.applied(wanted, sent)

    def _forward(self, reference: Reference, q: Array, dq: Array) -> Array:
        live = self.model.torque(
            self._robot, q[None], dq[None], reference.dq[None], reference.ddq[None]
        )
        return np.asarray(live[0])


class FeedForward(ComputedTorque):
    """Model torque of the desired motion alone, plus PID feedback: what a controller does that
    takes a torque along with each point of a motion."""

    name = "feed_forward"

    def _forward(self, reference: Reference, q: Array, dq: Array) -> Array:
        return super()._forward(reference, reference.q, reference.dq)


BY_NAME: dict[str, type[ComputedTorque]] = {law.name: law for law in (FeedForward, ComputedTorque)}
