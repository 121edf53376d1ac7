"""Columns of friction and inertia effects against closed forms, Pinocchio and work."""

import numpy as np
import pytest
from effect_motions import (
    DT,
    alone,
    arm_context,
    columns,
    constant_speed,
    pa10,
    pinocchio_model,
    pinocchio_torque,
)

SPEEDS = (-0.9, -0.03, 0.012, 0.4)


@pytest.mark.parametrize("speed", SPEEDS)
@pytest.mark.parametrize(
    ("name", "shape", "law"),
    [
        ("rotor_inertia", {}, lambda v: [0.0]),
        ("coulomb", {"v0": 0.02}, lambda v: [np.tanh(v / 0.02)]),
        ("viscous", {}, lambda v: [v]),
        ("torque_offset", {}, lambda v: [1.0]),
        ("coulomb_asymmetry", {}, lambda v: [1.0, abs(v)]),
        (
            "stribeck",
            {"vs": 0.05, "delta": 1.5},
            lambda v: [np.exp(-((abs(v) / 0.05) ** 1.5)) * np.tanh(v / 0.0025)],
        ),
        ("nonlinear_viscous", {"p": 2.3}, lambda v: [np.sign(v) * abs(v) ** 2.3]),
    ],
)
def test_closed_form_at_constant_speed(name, shape, law, speed):
    found = columns(name, constant_speed(1, speed), 1, **shape)
    assert found == pytest.approx(np.tile(law(speed), (len(found), 1)), rel=1e-9, abs=1e-12)


def test_rotor_inertia_is_the_second_difference_of_the_angle():
    t = np.arange(3000) * DT
    q = 0.4 * np.sin(2.0 * t)
    context = alone(3, q, 0.8 * np.cos(2 * t), -1.6 * np.sin(2 * t))
    twice = np.diff(q, 2) / DT**2
    assert columns("rotor_inertia", context, 3)[1:-1, 0] == pytest.approx(twice, abs=1e-5)


def test_load_friction_against_pinocchio():
    """|torque of the links alone|, whatever friction the rest of the model has."""
    context = arm_context(seed=4)
    links = pinocchio_torque(pinocchio_model(pa10()), context.q, context.dq, context.ddq)
    for j in (1, 3):
        found = columns("load_friction", context, j, v0=1e-3)[:, 0]
        clear = np.abs(context.dq[:, j]) > 0.05
        expected = np.abs(links[:, j]) * np.sign(context.dq[:, j])
        assert clear.sum() > 1000
        assert found[clear] == pytest.approx(expected[clear], rel=1e-9, abs=1e-9)


def test_position_friction_sits_at_its_place_in_both_directions():
    for speed in (0.5, -0.5):
        context = constant_speed(2, speed, samples=2001)
        found = columns("position_friction", context, 2, qc=0.2, w=0.05, wave=0.0)[:, 0] * np.sign(
            speed
        )
        q = context.q[:, 2]
        assert q[np.argmax(found)] == pytest.approx(0.2, abs=0.001)
        assert found[np.argmin(np.abs(q - 0.25))] == pytest.approx(np.exp(-0.5), rel=0.02)
        # area of a bell curve
        assert np.sum(found) * 0.5 * DT == pytest.approx(0.05 * np.sqrt(2 * np.pi), rel=1e-3)


def test_friction_in_waves_comes_round_and_averages_to_nothing():
    context = constant_speed(2, 0.5, samples=2001)
    found = columns("position_friction", context, 2, qc=0.2, w=1 / 12, wave=1.0)[:, 0]
    q = context.q[:, 2]
    turn = (q >= 0.2) & (q < 0.2 + 2 * np.pi / 12)
    assert turn.sum() > 200, "one wave at least"
    assert np.mean(found[turn]) == pytest.approx(0.0, abs=0.02)
    assert np.mean(found[turn] ** 2) == pytest.approx(0.5, abs=0.02)
    assert found[np.argmin(np.abs(q - 0.2 - np.pi / 12))] == pytest.approx(-1.0, abs=0.01)


@pytest.mark.parametrize(
    ("name", "joints", "shape"),
    [
        ("coulomb", (1,), {"v0": 0.01}),
        ("viscous", (1,), {}),
        ("stribeck", (2,), {"vs": 0.1, "delta": 2.0}),
        ("nonlinear_viscous", (3,), {"p": 1.7}),
        ("load_friction", (1,), {"v0": 0.01}),
        ("position_friction", (1,), {"qc": 0.1, "w": 0.3, "wave": 0.0}),
        ("coupling_friction", (4, 5), {"ratio": 1.0}),
        ("coupling_friction", (4, 5), {"ratio": -1.0}),
    ],
)
def test_friction_only_takes_power(name, joints, shape):
    context = arm_context(seed=1)
    found = columns(name, context, *joints, **shape)
    if found.ndim == 2:
        power = found * context.dq[:, joints[0], None]
    else:
        power = np.einsum("snk,sn->sk", found, context.dq)
    slow = np.min(np.abs(context.dq[:, joints]), axis=1) < 0.02  # signs are averages over samples
    assert np.all(power[~slow] >= -1e-9)
    assert np.all(power.sum(axis=0) > 0)


@pytest.mark.parametrize("ratio", [1.0, -1.0])
def test_coupling_friction_heats_what_the_shared_part_rubs(ratio):
    context = arm_context(seed=2)
    found = columns("coupling_friction", context, 4, 5, ratio=ratio)
    v = context.dq[:, 4] + ratio * context.dq[:, 5]
    power = np.einsum("snk,sn->sk", found, context.dq)
    clear = np.abs(v) > 0.1
    assert power[clear, 0] == pytest.approx(np.abs(v[clear]), rel=1e-6)
    assert power[:, 1] == pytest.approx(v**2)
    assert not found[:, [0, 1, 2, 3, 6]].any()


def test_coupling_inertia_follows_from_a_shared_kinetic_energy():
    """T = Ia·q̇i·q̇j, so torque i is the time derivative of Ia·q̇j; no pose enters."""
    context = arm_context(seed=3)
    found = columns("coupling_inertia", context, 3, 5)[..., 0]
    momentum = np.gradient(context.dq, DT, axis=0)
    inner = slice(2, -2)
    assert found[inner, 3] == pytest.approx(momentum[inner, 5], abs=1e-3)
    assert found[inner, 5] == pytest.approx(momentum[inner, 3], abs=1e-3)
    assert not np.delete(found, [3, 5], axis=1).any()
    energy = np.sum(found * context.dq, axis=1) * DT
    stored = context.dq[:, 3] * context.dq[:, 5]
    assert np.sum(energy[1:-1]) == pytest.approx(stored[-1] - stored[0], abs=5e-3)
