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
    found = stroke_friction(strokes, RATE, inertia=1.0)
    assert found is not None
    assert (found.coulomb, found.viscous) == pytest.approx((DRY, WET), rel=1e-6)
