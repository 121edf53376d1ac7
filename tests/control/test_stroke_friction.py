"""Friction from strokes to and fro, with whatever else acts on the way."""

from __future__ import annotations

import numpy as np
import pytest

from pa10d.experiments.joint_response import response_of, stroke_friction
from pa10d.experiments.seen import slid

RATE = 250.0
DRY, WET = 2.4, 3.0  # N·m, N·m·s/rad


def stroke(begin: float, speed: float, seconds: float, slope: float) -> tuple:
    """Angle and torque of steady sliding on a joint whose load gains ``slope`` N·m/rad."""
    q = begin + speed * np.arange(round(seconds * RATE)) / RATE
    return q, DRY * np.sign(speed) + WET * speed + slope * q + 5.0


@pytest.mark.parametrize("slope", [0.0, -70.0, 70.0])
def test_gravity_on_the_way_is_no_friction(slope: float) -> None:
    """The slow windows are the last second of a longer way: not the same places to and fro."""
    strokes = [
        stroke(0.03, 0.15, 1.0, slope),
        stroke(0.15, -0.15, 1.0, slope),
        stroke(0.04, 0.32, 0.3, slope),
        stroke(0.14, -0.32, 0.3, slope),
    ]
    found = stroke_friction(strokes, RATE)
    assert found is not None
    assert (found.coulomb, found.viscous) == pytest.approx((DRY, WET), rel=1e-6)


def test_a_servo_that_is_still_settling_is_no_friction_either() -> None:
    """The quick strokes gain speed on the way, with 2 kg·m² to be carried along."""
    strokes = []
    for speed, seconds in ((0.15, 1.0), (-0.15, 1.0), (0.3, 0.3), (-0.3, 0.3)):
        t = np.arange(round(seconds * RATE)) / RATE
        dq, ddq = speed * (0.9 + t / 3.0), speed / 3.0 + 0 * t
        q = speed * (0.9 * t + t * t / 6.0) + (0.01 if speed > 0 else 0.16)
        effort = DRY * np.sign(speed) + WET * dq + 2.0 * ddq - 100.0 * q
        strokes.append((q, effort))
    found = stroke_friction(strokes, RATE)
    assert found is not None
    assert (found.coulomb, found.viscous) == pytest.approx((DRY, WET), rel=1e-3)


def test_a_stroke_in_which_the_joint_stuck_shows_no_response() -> None:
    """Of the arm that was looked at: joint 2 waited for 0.7 s of a window of 1 s, then slid."""
    t = np.arange(round(RATE)) / RATE
    shaken = 0.2 * t + 0.01 * np.sin(2 * np.pi * 3 * t)  # slower and faster, but it moves on
    assert slid(shaken, RATE, 0.2)
    assert slid(-shaken, RATE, -0.2)
    assert not slid(-shaken, RATE, 0.2)
    assert not slid(np.maximum(t - 0.7, 0.0), RATE, 0.2)
    assert not slid(0.2 * np.minimum(t, 0.85), RATE, 0.2)


def test_what_a_slow_ring_adds_to_the_lowest_line_counts_as_its_error() -> None:
    """A link that rings at 1.1 Hz within the window: one line is wrong, and says so."""
    t = np.arange(round(RATE)) / RATE
    lines = np.array([2.0, 6.0, 11.0])
    torque = sum(np.cos(2 * np.pi * f * t + f) for f in lines)
    true = 1e-3 * np.exp(-1j * lines)
    q = sum(
        abs(one) * np.cos(2 * np.pi * f * t + f + np.angle(one))
        for f, one in zip(lines, true, strict=True)
    )
    ringing = q + 5e-3 * np.sin(2 * np.pi * 1.1 * t) * np.exp(-t)
    seen = [
        response_of(angle[None, :, None], torque[None], RATE, lines, 0.0, 0, np.ones((1, 1)))
        for angle in (q, ringing)
    ]
    assert np.abs(seen[0].value / true - 1.0).max() < 0.05
    assert seen[0].error.max() < 0.4
    off = np.abs(seen[1].value / true - 1.0)
    assert off[0] > 0.2
    assert seen[1].error[0] > 0.3 * off[0]
    assert seen[1].error[2] < 0.2
