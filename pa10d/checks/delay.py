"""How late the torque channel is against the position.

It is asked of identification's own first steps, so that a check and a model say the same.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from pa10d.checks.finding import CheckFinding
from pa10d.dynamics import Robot
from pa10d.identify.first_look import first_look
from pa10d.identify.timing import FARTHEST, USUAL
from pa10d.measurement.recording import Recording

SHORTEST = 12.0  # s: fewer stretches know their own scatter badly


@dataclass(frozen=True)
class Delay:
    """seconds: positive where the torque is late, over so many seconds of a recording; believed: of
    the whole robot."""

    seconds: float
    std_error: float
    over: float
    believed: bool

    @property
    def known(self) -> bool:
        """Whether the estimate settled and says more than what is usual."""
        settled = self.std_error < USUAL and (self.believed or abs(self.seconds) < FARTHEST)
        return settled and self.over >= SHORTEST


def estimate_delay(recording: Recording, robot: Robot) -> Delay | None:
    """One delay for the whole robot; None where the recording is too short for a fit."""
    recording = replace(recording, dq=None)  # late against the position, not a reported velocity
    shift = first_look(recording, robot)
    if shift is None:
        return None
    return Delay(shift.estimate, shift.std_error, recording.duration, shift.seconds != 0.0)


def check_delay(recording: Recording, robot: Robot) -> Iterator[CheckFinding]:
    """What the delay says."""
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
