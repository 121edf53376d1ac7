"""How late the torque channel is against the position, and whether friction brakes.

Both are asked of identification's own first steps, so that a check and a model say the same.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.checks.finding import CheckFinding, Mend, joint_label
from pa10d.dynamics import Robot
from pa10d.identify.first_look import first_look
from pa10d.identify.timing import FARTHEST, USUAL
from pa10d.measurement.recording import Recording

Array = NDArray[np.float64]

SHORTEST = 12.0  # s: friction of less may seem to drive
SURE = 5.0  # standard errors, over stretches: so few know their own scatter badly


@dataclass(frozen=True)
class Delay:
    """seconds: positive where the torque is late, over so many seconds of a recording; believed: of
    the whole robot. friction: (n,) mean braking power, W; friction_error: (n,) W where it
    drives."""

    seconds: float
    std_error: float
    over: float
    believed: bool
    friction: Array
    friction_error: Array

    @property
    def known(self) -> bool:
        """Whether the estimate settled and says more than what is usual."""
        settled = self.std_error < USUAL and (self.believed or abs(self.seconds) < FARTHEST)
        return settled and self.over >= SHORTEST

    @property
    def drives(self) -> list[int]:
        """Joints whose friction surely drives."""
        return [int(j) for j in np.flatnonzero(self.friction < -SURE * self.friction_error)]


def estimate_delay(recording: Recording, robot: Robot) -> Delay | None:
    """One delay for the whole robot; None where the recording is too short for a fit."""
    recording = replace(recording, dq=None)  # late against the position, not a reported velocity
    found = first_look(recording, robot)
    if found is None:
        return None
    shift = found.shift
    return Delay(
        shift.estimate,
        shift.std_error,
        recording.duration,
        shift.seconds != 0.0,
        found.braking,
        found.braking_error,
    )


def check_delay(recording: Recording, robot: Robot) -> Iterator[CheckFinding]:
    """What the delay and the sign of friction say."""
    delay = estimate_delay(recording, robot)
    if delay is None or not delay.known:
        yield CheckFinding(
            "info",
            "delay_unknown",
            "the delay between torque and position cannot be told from this recording",
            "a longer run with more reversals would show it",
        )
        return
    low, high = (delay.seconds + k * 1.96 * delay.std_error for k in (-1, 1))
    period = 1.0 / recording.rate
    late = low > period or high < -period
    word = "late" if delay.seconds >= 0 else "early"
    yield CheckFinding(
        "warning" if late else "info",
        "delay",
        f"the torque seems {abs(delay.seconds) * 1e3:.2f} ms {word} against the position (95 %: "
        f"{low * 1e3:.2f} … {high * 1e3:.2f} ms; one sample is {period * 1e3:.3g} ms)",
        "log both in one cycle, or expect the fit to find a common shift; elasticity, play or "
        "friction that the textbook model lacks can look the same, and the interval does not know "
        "of them"
        if late
        else "",
    )
    for j in delay.drives:
        tau, q = (Mend(f"{kind}{j + 1}", "-1", complete=False) for kind in ("tau", "q"))
        yield CheckFinding(
            "warning",
            "sign",
            f"{joint_label(j, robot.joint_names)}: friction would drive instead of brake "
            f"({delay.friction[j]:.2g} W): tau and q may have opposite signs",
            f"--map {tau.option} if the torque counts the other way, {q.option} if the angle does",
            j + 1,
            (tau, q),
        )
