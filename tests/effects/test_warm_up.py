"""Warm-up against the heat balance it stands for, with and without a thermometer."""

from dataclasses import replace

import numpy as np
import pytest
from effect_motions import arm_context, columns, constant_speed
from scipy.integrate import solve_ivp

from pa10d.effects import effect
from pa10d.effects.library.thermal_friction import own_warmth

J = 2


def warm_run(celsius, samples=500):
    context = constant_speed(J, 0.4, samples)
    temperature = np.full((samples, 7), 20.0)
    temperature[:, J] = celsius
    return replace(context, temperature=temperature)


@pytest.mark.parametrize("time_constant", [2.0, 30.0])
def test_without_a_thermometer_it_warms_as_a_heated_body_does(time_constant):
    context = replace(arm_context(seconds=8.0))
    found = columns("thermal_friction", context, J, T=time_constant, heated=0.0)
    heated = solve_ivp(
        lambda t, w: (1.0 - w) / time_constant,
        (0, context.t[-1]),
        [0.0],
        t_eval=context.t,
        rtol=1e-10,
        atol=1e-12,
    )
    v = context.dq[:, J]
    assert found[:, 0] == pytest.approx(-heated.y[0] * v, abs=1e-7)
    clear = np.abs(v) > 0.1
    assert found[clear, 1] == pytest.approx(-(heated.y[0] * np.sign(v))[clear], abs=1e-6)


@pytest.mark.parametrize("time_constant", [2.0, 30.0])
def test_its_own_friction_heats_it_and_rest_lets_it_cool(time_constant):
    context = arm_context(seconds=8.0)
    rests = context.t > 5.0
    context.dq[rests, J] = 0.0

    def heating(t, w):
        v = np.interp(t, context.t, context.dq[:, J])
        return ((2.0 * np.tanh(v / 0.02) + 1.5 * v) * v * (t <= 5.0) - w) / time_constant

    solved = solve_ivp(
        heating, (0, 8), [0.0], t_eval=context.t, rtol=1e-8, atol=1e-9, max_step=0.01
    )
    found = own_warmth(context, J, time_constant)
    assert found == pytest.approx(solved.y[0], abs=2e-3 * solved.y.max())
    taken = columns("thermal_friction", context, J, T=time_constant, heated=1.0)
    assert taken[:, 0] == pytest.approx(-found * context.dq[:, J])


def test_with_a_thermometer_the_loss_is_per_ten_kelvin_above_twenty_degrees():
    rising = np.linspace(20.0, 45.0, 500)
    found = columns("thermal_friction", warm_run(rising), J, T=100.0, heated=0.0)
    assert found[:, 0] == pytest.approx(-0.4 * (rising - 20.0) / 10.0)
    assert found[:, 1] == pytest.approx(-(rising - 20.0) / 10.0)


def test_two_runs_at_different_temperatures_differ():
    """A run that begins warm is not taken for a cold one."""
    cold, warm = (
        columns("thermal_friction", warm_run(c), J, T=50.0, heated=0.0) for c in (20.0, 40.0)
    )
    assert not cold.any()
    assert warm[:, 0] == pytest.approx(-0.8)


def test_a_joint_without_a_reading_falls_back_on_time():
    broken = warm_run(np.nan)
    timed = replace(broken, temperature=None)
    for heated in (0.0, 1.0):
        shape = {"T": 3.0, "heated": heated}
        assert np.array_equal(
            columns("thermal_friction", broken, J, **shape),
            columns("thermal_friction", timed, J, **shape),
        )
    shapes = effect("thermal_friction").starts(broken, [J])
    assert shapes == effect("thermal_friction").starts(timed, [J])
    assert len(shapes) > 1
