"""The compiled rigid-body algebra against Pinocchio's."""

import numpy as np
import pinocchio as pin
import pytest
from plant_robots import joint, link, profile_of, seven_axes

from backends.virtual.plant.arm import arm_of_model, base_gravity, perturbed, with_body
from backends.virtual.plant.assemble import arm_model
from backends.virtual.plant.compiled import entry
from backends.virtual.plant.inertia import mass_matrix
from backends.virtual.plant.rigid import bias, frames, place
from backends.virtual.plant.state import bodies_of


@entry
def both(bodies, gravity, q, dq, work, mass, torque):
    place(bodies, q, work)
    bias(bodies, gravity, dq, work, torque)
    mass_matrix(bodies, work, mass)


def crooked(folder):
    """Skew axes, turned origins, a sliding joint and two branches."""
    return profile_of(
        folder,
        link("a", 3.0, "0.1 0.02 0.3", (0.1, 0.2, 0.15)),
        joint("j1", "base", "a", "0.6 0 0.8", "0.1 0 0.2", rpy="0.3 -0.2 0.9"),
        link("b", 2.0, "0 0.1 0.1", (0.05, 0.04, 0.03)),
        joint("j2", "a", "b", "0 0.6 -0.8", "0 0.2 0.1", kind="prismatic", rpy="1 0.5 0"),
        link("c", 1.5, "0.05 0 -0.2", (0.02, 0.03, 0.01)),
        joint("j3", "b", "c", "1 0 0", "0.2 0 0", rpy="0 0 1.2"),
        link("d", 1.0, "0.05 0.1 0", (0.02, 0.03, 0.01)),
        joint("j4", "a", "d", "0 1 0", "0 0 0.4", kind="continuous"),
    )


@pytest.mark.parametrize("robot", [pytest.param("seven axes", marks=pytest.mark.long), "crooked"])
def test_mass_matrix_and_bias_agree_with_pinocchio(robot, tmp_path):
    profile = seven_axes() if robot == "seven axes" else crooked(tmp_path)
    model = arm_model(profile)
    arm = arm_of_model(model, base_gravity(profile))
    data, n = model.createData(), model.nv
    work, mass, torque = frames(n), np.zeros((n, n)), np.zeros(n)
    rng = np.random.default_rng(1)
    for _ in range(100):
        q, dq = rng.uniform(-3, 3, (2, n))
        full = pin.integrate(model, pin.neutral(model), q)
        both(bodies_of(arm), arm.gravity, q, dq, work, mass, torque)
        upper = np.triu(pin.crba(model, data, full))
        np.testing.assert_allclose(mass, upper + np.triu(upper, 1).T, atol=1e-9)
        np.testing.assert_allclose(torque, pin.nle(model, data, full, dq), atol=1e-9)


def test_every_perturbed_link_could_be_built():
    profile = seven_axes()
    arm = arm_of_model(arm_model(profile), base_gravity(profile))
    for seed in range(20):
        other = perturbed(arm, np.random.default_rng(seed), 0.2)
        assert np.all(np.abs(other.mass / arm.mass - 1) <= 0.2)
        for inertia in other.inertia:
            moments = np.linalg.eigvalsh(inertia)
            assert moments[0] > 0
            assert moments[2] <= moments[0] + moments[1] + 1e-12


def test_body_on_the_flange_adds_its_weight_at_its_place():
    profile = seven_axes()
    arm = arm_of_model(arm_model(profile), base_gravity(profile))
    loaded = with_body(arm, 2.0, np.array([0.0, 0.02, 0.1]), np.zeros((3, 3)))
    first = arm.mass[-1] * arm.com[-1] + 2.0 * np.array([0.0, 0.02, 0.1])
    assert loaded.mass[-1] == pytest.approx(arm.mass[-1] + 2.0)
    np.testing.assert_allclose(loaded.mass[-1] * loaded.com[-1], first, atol=1e-12)
