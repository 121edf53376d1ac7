"""A spring between motor and link is found at a link that hangs or stands in gravity, too."""

from __future__ import annotations

import numpy as np
import pytest

from pa10d.control.gains import BUS_DELAY
from pa10d.experiments.joint_response import Response, fitted_response

RATE, ROTOR, LINK, VISCOUS, STIFFNESS = 500.0, 0.4, 1.6, 1.5, 150.0
LINES = np.array([1.0, 1.6, 2.4, 3.6, 5.4, 8.0, 12.0, 18.0, 27.0])
ERROR = 0.05
UNSURE = 0.08  # of the stiffness: three standard errors of such lines, by the Jacobian


def two_bodies(slope: float) -> np.ndarray:
    """rad per N·m at the motor, of two bodies and a spring: (M·s² + D·s + K) x = (torque, 0)."""
    loss, found = 0.04 * np.sqrt(STIFFNESS * LINK), []
    for s in 2j * np.pi * LINES:
        mass = np.diag([ROTOR, LINK]) * s**2
        couple = (STIFFNESS + loss * s) * np.array([[1.0, -1.0], [-1.0, 1.0]])
        pulled = mass + couple + np.diag([VISCOUS * s, -slope])
        found.append(np.linalg.solve(pulled, [1.0, 0.0])[0] * np.exp(-s * BUS_DELAY / RATE))
    rng = np.random.default_rng(3)
    off = rng.normal(size=(2, len(LINES))) * ERROR
    return np.array(found) * np.exp(off[0] + 1j * off[1])


def seen(slope: float, urdf: float) -> Response:
    """As measured with the inertia and the slope that a URDF has."""
    return Response(LINES, two_bodies(slope), np.full(len(LINES), ERROR), 1.3, urdf)


@pytest.mark.by_default("90.0-0.5")
@pytest.mark.parametrize(("slope", "wrong"), [(-90.0, 2.0), (90.0, 0.5)])
def test_the_spring_within_its_error(slope: float, wrong: float) -> None:
    fit = fitted_response([seen(slope, wrong * slope)], 0.3, VISCOUS, RATE)
    assert abs(np.log(fit.stiffness / STIFFNESS)) < UNSURE


def test_gravity_is_no_spring() -> None:
    s = 2j * np.pi * LINES
    value = np.exp(-s * BUS_DELAY / RATE) / ((ROTOR + LINK) * s**2 + VISCOUS * s - 90.0)
    one = Response(LINES, value, np.full(len(LINES), ERROR), 1.3, 90.0)
    fit = fitted_response([one], 0.3, VISCOUS, RATE)
    assert np.isinf(fit.stiffness)
    assert fit.rotor + 1.3 * fit.link == pytest.approx(ROTOR + LINK, rel=0.05)


def test_a_small_rotor_that_stands_still_where_the_link_swings() -> None:
    """At 6.8 Hz; the rotor itself would swing above the lines. Felt at a rate of 200 Hz."""
    lines = np.array([2.0, 4.0, 7.0, 9.0, 11.0, 13.0, 15.0, 18.0, 21.0, 25.0])
    size = [0.035, 0.0076, 0.00063, 0.0017, 0.0022, 0.0025, 0.0033, 0.0031, 0.0028, 0.0029]
    phase = np.radians([-146, -176, -81, -62, -73, -88, -99, -103, -123, -148])
    error = np.array([0.30, 0.06, 0.21, 0.21, 0.25, 0.27, 0.19, 0.13, 0.18, 0.11])
    one = Response(lines, np.array(size) * np.exp(1j * phase), error, 0.24, 12.3)
    fit = fitted_response([one], 0.0072, VISCOUS, 200.0)
    assert fit.stiffness == pytest.approx(198.0, rel=0.3)
    assert fit.link == pytest.approx(0.45, rel=0.3)
