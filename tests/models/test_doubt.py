"""One standard error that says what it includes; what the data leave open is said to be open."""

from __future__ import annotations

from dataclasses import replace

import model_examples as examples
import numpy as np
import pytest

from pa10d.common.errors import UserError
from pa10d.dynamics import robot_from_profile
from pa10d.effects import Value, effect
from pa10d.profile import load_profile
from pa10d.services.model_details import model_details
from pa10d.store.models import ModelStore


def test_a_torque_constant_makes_torques_and_masses_uncertain_and_shares_not():
    assert Value(10.0, 0.1, "N·m").with_gain_error(0.05).std_error == pytest.approx(
        0.5099, rel=1e-3
    )
    assert Value(3.0, 0.03, "kg").with_gain_error(0.1).std_error == pytest.approx(0.3015, rel=1e-3)
    for unit in ("1", "rad/s", "cycles/rev", "s"):
        assert Value(0.1, 0.01, unit).with_gain_error(0.1).std_error == 0.01
    known = Value(10.0, 0.1, "N·m").with_gain_error(0.05).document()
    assert known["std_error_random"] == 0.1


def test_the_share_of_a_load_is_known_no_better_than_a_torque_constant():
    """What both directions of the power lose unlike is a gain of the joint, to the last sample."""
    shape = {"v0": 0.01, "directional": 1.0, "uneven": 0.2}
    told = effect("load_friction").values(
        np.array([0.25]), np.array([[1e-8]]), shape, {"v0": 1e-3, "uneven": 1e-3}
    )
    mu, dmu = (told[name].with_gain_error(0.05) for name in ("mu", "dmu"))
    assert mu.std_error == pytest.approx(0.05 * 0.25, rel=1e-3)
    assert dmu.value == pytest.approx(0.05)
    assert dmu.std_error == pytest.approx(0.05, rel=1e-3)
    assert dmu.std_error_random == pytest.approx(0.25 * 1e-3, rel=0.01)


def test_a_profile_states_how_well_its_torque_constants_are_known(tmp_path):
    (tmp_path / "robot.urdf").write_text(examples.ROBOT.urdf)
    profile = tmp_path / "robot.yaml"
    n = examples.ROBOT.n
    profile.write_text("urdf: robot.urdf\n")
    assert robot_from_profile(load_profile(profile)).gain_share((0,)) == 0.05
    profile.write_text("urdf: robot.urdf\ntorque_gain_error: 0.1\n")
    assert robot_from_profile(load_profile(profile)).gain_share((0,)) == pytest.approx(0.1)
    shares = ", ".join(["0.02"] * (n - 1) + ["0.2"])
    profile.write_text(f"urdf: robot.urdf\ntorque_gain_error: [{shares}]\n")
    robot = robot_from_profile(load_profile(profile))
    assert robot.gain_share((n - 1,)) == pytest.approx(0.2)
    assert 0.02 < robot.gain_share(()) < 0.2
    profile.write_text("urdf: robot.urdf\ntorque_gain_error: 5\n")
    with pytest.raises(UserError, match="torque_gain_error"):
        load_profile(profile)


def test_it_travels_with_the_model_and_stands_in_its_details(tmp_path):
    model = examples.textbook()
    robot = replace(model.robot, gain_error=np.full(model.robot.n, 0.2))
    store = ModelStore(tmp_path)
    stored = store.load(store.save(replace(model, robot=robot)))
    assert np.array_equal(stored.robot.gain_error, robot.gain_error)
    few, many = (model_details(m).document()["parameters"] for m in (model, stored))
    for a, b in zip(few, many, strict=True):
        if a["std_error"] is None:  # assumed
            assert (b["std_error"], a["determined"]) == (None, False)
            continue
        assert a["std_error_random"] == b["std_error_random"] <= a["std_error"] <= b["std_error"]


def test_what_was_assumed_has_no_error_of_nought():
    found = effect("coulomb").values(np.array([2.0]), np.eye(1) * 1e-4, {"v0": 0.01}, {})
    told = found["v0"].document()
    assert (told["determined"], told["std_error"], told["std_error_random"]) == (False, None, None)
    assert found["Fc"].document()["std_error"] == pytest.approx(0.01)


def test_a_shape_whose_error_exceeds_it_is_not_determined():
    friction = effect("load_friction")
    shape, errors = {"v0": 0.02, "rotor": 0.0}, {"v0": 0.9, "rotor": 18.0}
    open_ = friction.values(np.array([0.1]), np.eye(1) * 1e-4, shape, errors)
    assert str(open_["v0"]) == str(open_["rotor"]) == "not determined"
    assert open_["mu"].determined
    told = friction.values(np.array([0.1]), np.eye(1) * 1e-4, shape, {"v0": 0.004, "rotor": 0.0})
    assert str(told["v0"]) == "0.02 ± 0.004 rad/s"
