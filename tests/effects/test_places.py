"""Effects tied to the joint's angle: ripple, spring, contact."""

import numpy as np
import pytest
from effect_motions import DT, alone, arm_context, columns, constant_speed
from scipy.signal import periodogram

from pa10d.effects import effect


@pytest.mark.parametrize("speed", [0.5, 1.0])
def test_ripple_comes_as_often_as_the_speed_says(speed):
    """N cycles per revolution are N·speed/2π hertz."""
    context = constant_speed(0, speed, samples=5000)
    for column in columns("torque_ripple", context, 0, N=80.0).T:
        frequency, power = periodogram(column, 1 / DT)
        assert frequency[np.argmax(power)] == pytest.approx(80 * speed / (2 * np.pi), abs=0.11)


def test_ripple_repeats_with_the_tooth_and_knows_its_phase():
    context = arm_context(seed=5)
    moved = alone(1, context.q[:, 1] + 2 * np.pi / 50, context.dq[:, 1], context.ddq[:, 1])
    here = alone(1, context.q[:, 1], context.dq[:, 1], context.ddq[:, 1])
    assert columns("torque_ripple", moved, 1, N=50.0) == pytest.approx(
        columns("torque_ripple", here, 1, N=50.0), abs=1e-9
    )
    a, b = 2.0, 1.0
    torque = columns("torque_ripple", here, 1, N=50.0) @ [a, b]
    as_cosine = np.hypot(a, b) * np.cos(50 * here.q[:, 1] - np.arctan2(a, b))
    assert torque == pytest.approx(as_cosine)


def test_spring_is_the_slope_of_its_energy():
    context = arm_context(seed=6)
    k, q0, q = 12.0, 0.35, context.q[:, 4]
    torque = columns("spring", context, 4) @ [k, k * q0]
    step = 1e-5
    energy = [0.5 * k * (q + s - q0) ** 2 for s in (-step, step)]
    assert torque == pytest.approx((energy[1] - energy[0]) / (2 * step), abs=1e-6)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_contact_pushes_back_on_its_side_only(side):
    """Work done on the stop is what a spring from qs on stores."""
    context = constant_speed(3, side * 0.5, samples=2001)
    q = context.q[:, 3]
    qs = side * 0.2
    found = columns("contact", context, 3, qs=qs, side=side)[:, 0]
    outside = side * (q - qs) <= 0
    assert not found[outside].any()
    assert np.all(found[~outside] * side > 0)
    work = np.trapezoid(found, q)
    assert work == pytest.approx(0.5 * (q[-1] - qs) ** 2, rel=1e-5)


def test_contact_looks_inside_the_range_visited_on_both_sides():
    context = arm_context(seed=7)
    shapes = effect("contact").starts(context, [2])
    q = context.q[:, 2]
    assert {s["side"] for s in shapes} == {1.0, -1.0}
    for shape in shapes:
        assert q.min() < shape["qs"] < q.max()
        assert columns("contact", context, 2, **shape).any()
