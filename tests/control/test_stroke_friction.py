"""Friction from strokes to and fro, with whatever else acts on the way."""

from __future__ import annotations

import numpy as np
import pytest

from pa10d.experiments.joint_response import stroke_friction

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
