"""A drive's delay beyond the loop's own: a usual one unless the lines show another."""

from __future__ import annotations

import numpy as np
import pytest

from pa10d.control.gains import BUS_DELAY
from pa10d.experiments.joint_response import Fitted, Response, fitted_response

RATE, ROTOR, LINK, VISCOUS = 100.0, 0.02, 0.05, 0.3
LINES = np.array([1.0, 1.7, 2.7, 4.0, 6.0, 9.0])


def fitted(delay: float, error: float, seed: int) -> Fitted:
    """What is made of a rigid joint's lines of such an error, a share of the response."""
    s = 2j * np.pi * LINES
    value = np.exp(-s * (BUS_DELAY / RATE + delay)) / ((ROTOR + LINK) * s**2 + VISCOUS * s)
    off = np.random.default_rng(seed).normal(size=(2, len(LINES))) * error
    seen = value * np.exp(off[0] + 1j * off[1])
    one = Response(LINES, seen, np.full(len(LINES), error), LINK, 0.0)
    return fitted_response([one], ROTOR, VISCOUS, RATE)


@pytest.mark.long
def test_lines_that_say_nothing_leave_a_usual_one() -> None:
    """Where a sway hid the lines, more than a period was found for half a millisecond."""
    found = [abs(fitted(0.0005, 0.5, seed).delay) for seed in range(6)]
    assert max(found) < 0.002  # up to 5.6 ms by the lines alone


@pytest.mark.by_default("4")
@pytest.mark.parametrize("seed", range(6))
def test_lines_that_show_a_long_one_are_believed(seed: int) -> None:
    assert fitted(0.02, 0.01, seed).delay == pytest.approx(0.02, abs=0.0015)
