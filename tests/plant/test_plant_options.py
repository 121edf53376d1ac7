"""The plant protocol and the options a profile gives."""

import time

import numpy as np
import pytest
from plant_robots import seven_axes, turntable

import backends.virtual.plant
from backends.virtual.plant import build
from backends.virtual.plant.catalogue import LISTED, UNLISTED
from pa10d.common.errors import UserError
from pa10d.profile import Simulation, Tool

EFFECT_IDS = {
    *("torque_offset", "coulomb_asymmetry", "stribeck", "nonlinear_viscous"),
    *("presliding_hysteresis", "load_friction", "thermal_friction", "position_friction"),
    *("torque_ripple", "joint_elasticity", "backlash", "spring", "payload", "base_tilt"),
    *("encoder_offset", "torque_gain", "torque_saturation", "torque_delay"),
    *("coupling_friction", "coupling_inertia", "contact"),
}


def test_every_effect_of_the_library_can_be_hidden_and_some_of_none():
    assert set(LISTED) == EFFECT_IDS
    assert len(UNLISTED) >= 4


def test_default_factory_speaks_the_protocol():
    module, name = Simulation().plant.split(":")
    assert module == "backends.virtual.plant"
    plant = getattr(backends.virtual.plant, name)(seven_axes())
    pose = np.linspace(-0.5, 0.5, 7)
    assert plant.n == 7
    assert plant.reset(pose) is None
    q, torque = plant.measure()
    np.testing.assert_allclose(q, pose, atol=1e-5)
    assert q.shape == torque.shape == plant.temperature().shape == (7,)
    assert plant.step(np.full(7, 5.0), 0.002) is None
    np.testing.assert_array_equal(plant.measure(), plant.measure())
    kept = plant.measure()[0]
    plant.step(np.full(7, 50.0), 0.05)
    assert not np.array_equal(kept, plant.measure()[0])
    np.testing.assert_allclose(plant.temperature(), 25.0)


def test_torque_lists_and_integers_are_taken(tmp_path):
    plant = build(turntable(tmp_path), noise="none")
    plant.reset([0])
    plant.step([3], 0.002)
    assert plant.measure()[1][0] == 3.0


def test_known_tool_is_part_of_the_arm():
    profile = seven_axes()
    tooled = profile.model_copy(update={"tool": Tool(mass=1.5, com=(0.0, 0.0, 0.1))})
    more = build(tooled).physics.arm.mass[-1] - build(profile).physics.arm.mass[-1]
    assert more == pytest.approx(1.5)


def test_an_arm_of_its_own_by_seed():
    profile = seven_axes()
    arms = [build(profile, dynamics={"spread": 0.2, "seed": s}) for s in (1, 1, 2)]
    np.testing.assert_array_equal(arms[0].physics.arm.com, arms[1].physics.arm.com)
    assert not np.allclose(arms[0].physics.arm.mass, arms[2].physics.arm.mass)
    assert not np.allclose(arms[0].textbook.coulomb, arms[2].textbook.coulomb)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"effects": [{"effect": "stribek", "joint": 1}]}, "stribek"),
        ({"effects": [{"effect": "stribeck", "joint": 8, "Fs": 1, "vs": 1}]}, "1..7"),
        ({"effects": [{"effect": "stribeck", "Fs": 1, "vs": 1}]}, "joint: J"),
        ({"effects": [{"effect": "stribeck", "joint": 1, "vs": 1}]}, "value for Fs"),
        ({"effects": [{"effect": "stribeck", "joint": 1, "Fs": "big", "vs": 1}]}, "'big'"),
        ({"effects": [{"effect": "spring", "joint": 1, "k": 1, "K": 1}]}, "no 'K'"),
        ({"effects": [{"effect": "payload", "joint": 1, "mass": 1}]}, "no joint"),
        ({"effects": [{"effect": "coupling_inertia", "joints": [1, 1], "Ia": 1}]}, "joints"),
        ({"effects": [{"effect": "coupling_inertia", "joints": [1, 2], "Ia": 9}]}, "larger"),
        ({"effects": [{"effect": "spring", "joint": 1, "k": 1}] * 1 + ["x"]}, "list of"),
        ({"effects": [{"effect": "load_friction", "joint": 1, "mu": 0.1}] * 2}, "twice"),
        (
            {"effects": [{"effect": "load_friction", "joint": 1, "mu": 0, "dmu": 0.2}]},
            "would drive",
        ),
        ({"effects": [{"effect": "backlash", "joint": 1, "b": 0.01, "K": 0}]}, "more than 0"),
        ({"effects": [{"effect": "payload", "mass": 1, "inertia": [1, 1]}]}, "found 2"),
        ({"noise": "pink"}, "pink"),
        ({"noise": {"kind": "white", "colour": 1}}, "colour"),
        ({"dynamics": {"friction": 1}}, "friction"),
        ({"dynamics": {"coulomb": -1}}, "negative"),
        (
            {"effects": [{"effect": "presliding_hysteresis", "joint": 1, "model": "dahl"}]},
            "'dahl'",
        ),
    ],
)
def test_wrong_options_are_one_clear_line(options, says):
    with pytest.raises(UserError) as caught:
        build(seven_axes(), **options)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_control_cycle_takes_a_fraction_of_its_period():
    plant = build(seven_axes())
    torque = np.zeros(7)
    plant.step(torque, 0.002)
    best = np.inf
    for _ in range(5):
        start = time.process_time()
        for _ in range(100):
            plant.step(torque, 0.002)
        best = min(best, (time.process_time() - start) / 100)
    assert best < 0.001
