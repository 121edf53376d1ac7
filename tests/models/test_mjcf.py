"""MJCF against what it stands for: read by Pinocchio, by MuJoCo where it is installed, and the
torque that it cannot hold."""

import xml.etree.ElementTree as ET
from dataclasses import replace

import model_examples as examples
import numpy as np
import pytest

from pa10d.common.errors import UserError
from pa10d.dynamics import inverse_dynamics
from pa10d.export.formats import export
from pa10d.measurement.signals import Lowpass
from pa10d.model import ModelNotes

RNG = np.random.default_rng(4)
Q, DQ, DDQ = RNG.uniform(-0.9, 0.9, (3, 20, 4))


def bodies_only(model):
    return replace(model, terms=(), notes=ModelNotes())


def test_bodies_are_the_models_in_pinocchio(tmp_path):
    pin = pytest.importorskip("pinocchio")
    model = bodies_only(examples.textbook())
    (tmp_path / "arm.xml").write_text(export(model, "mjcf").text)
    arm = pin.buildModelFromMJCF(str(tmp_path / "arm.xml"))
    data = arm.createData()
    expected = inverse_dynamics(model.robot, model.standard, Q, DQ, DDQ)
    assert [name for name in arm.names][1:] == list(model.robot.joint_names)
    arm.gravity.linear = model.robot.gravity
    for k in range(len(Q)):
        assert pin.rnea(arm, data, Q[k], DQ[k], DDQ[k]) == pytest.approx(expected[k], abs=1e-9)


def test_torque_is_the_models_in_mujoco():
    """Rotors, damping and friction included; dry friction is full while a joint moves."""
    mujoco = pytest.importorskip("mujoco")
    model = examples.textbook()
    made = export(model, "mjcf")
    arm = mujoco.MjModel.from_xml_string(made.text)
    arm.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_LIMIT
    data = mujoco.MjData(arm)
    fast = np.where(np.abs(DQ) < 0.4, 0.4 * np.sign(DQ), DQ)
    expected = model.torque(Q, fast, DDQ, parameters="feasible")
    for k in range(len(Q)):
        data.qpos, data.qvel, data.qacc = Q[k], fast[k], DDQ[k]
        mujoco.mj_inverse(arm, data)
        assert data.qfrc_inverse == pytest.approx(expected[k], rel=1e-6, abs=1e-6)


def test_joints_have_their_rotors_and_friction():
    model = examples.textbook()
    root = ET.fromstring(export(model, "mjcf").text)
    joints = {joint.get("name"): joint for joint in root.iter("joint")}
    found = {t.label: float(t.coefficients[0]) for t in model.possible().terms}
    for key, effect in (
        ("armature", "rotor_inertia"), ("damping", "viscous"), ("frictionloss", "coulomb"),
    ):  # fmt: skip
        assert float(joints["j3"].get(key)) == found[f"{effect} J3"]
    assert joints["j3"].get("type") == "slide"
    assert joints["j2"].get("range") is None
    assert next(m.get("ctrlrange") for m in root.iter("motor")) == "-100.0 100.0"


def seen_of(torque, motion, model):
    """(n,) N·m RMS in the model's band."""
    rate = (len(motion.t) - 1) / (motion.t[-1] - motion.t[0])
    lowpass = Lowpass(len(motion.t), rate, model.cutoff)
    return np.sqrt(np.mean(lowpass(torque)[lowpass.settle : -lowpass.settle] ** 2, axis=0))


def test_noise_of_accelerations_is_nothing_that_a_format_lacks():
    """A URDF knows no rotors: 4.4 N·m of a joint that misses 0.4 were twice differentiated steps of
    an encoder."""
    model, motion = examples.textbook(), examples.motion()
    rate = (len(motion.t) - 1) / (motion.t[-1] - motion.t[0])
    hum = 100.0 * np.sin(2 * np.pi * 0.4 * rate * motion.t)[:, None]
    assert 0.4 * rate > 2.0 * model.cutoff
    clean, noisy = (
        export(model, "urdf", motions={"held": seen}).loss.rms
        for seen in (motion, replace(motion, ddq=motion.ddq + hum))
    )
    np.testing.assert_allclose(noisy, clean, rtol=0.05)


def test_what_it_cannot_hold_is_told_in_newton_metres():
    model = examples.with_effects(examples.textbook(), "stribeck", "payload")
    motion = examples.motion()
    made = export(model, "mjcf", motions={"held": motion})
    possible = model.possible()
    rest = replace(possible, terms=tuple(
        term for term in possible.terms[:-2] if term.effect_id != "coulomb"
    )).predict(motion)  # fmt: skip
    for term in possible.terms[:-2]:
        if term.effect_id == "coulomb":
            j = term.joints[0]
            way = np.sign(motion.dq[:, j] + 0.0019 * motion.ddq[:, j])
            rest[:, j] += term.coefficients[0] * way
    gone = seen_of(possible.predict(motion) - rest, motion, model)
    assert made.loss.rms == pytest.approx(gone)
    assert "what it does not hold amounts to j1 " in made.text
    assert f"j2 {gone[1]:.2g} N·m" in made.loss.sentence
    assert f"(RMS on held, low-pass {model.cutoff:.3g} Hz)" in made.loss.sentence
    assert [line.split(" not in")[0] for line in made.not_carried] == [
        "stribeck of joint 2",
        "payload",
    ]
    assert export(model, "python", motions={"held": motion}).loss is None
    urdf = export(examples.textbook(), "urdf", motions={"held": motion})
    assert "rotor_inertia" in urdf.not_carried[0]
    assert urdf.loss.rms.min() > 0.0


def test_what_c_forgets_is_told_too():
    model = examples.with_effects(examples.textbook(), "presliding_hysteresis")
    made = export(model, "c", motions={"held": examples.motion()})
    assert made.not_carried == ()
    assert made.loss.rms[1] > 1e-3
    assert "presliding_hysteresis of joint 2 remembers the way" in made.text


def test_what_only_a_thermometer_tells_is_told_too():
    """C has no temperature: what friction does with it had been told as next to nothing."""
    model = examples.with_effects(examples.textbook(), "thermal_friction")
    motion = examples.motion()
    warm = np.tile(30 + 2.0 * motion.t[:, None], (1, model.robot.n))
    motion = replace(motion, temperature=warm)
    made = export(model, "c", motions={"held": motion})
    possible = model.possible()
    cold = possible.predict(replace(motion, temperature=None, apart=True))
    gone = seen_of(possible.predict(motion) - cold, motion, model)
    assert made.loss.rms == pytest.approx(gone)
    assert gone[1] > 1e-3


def test_a_slope_of_friction_that_a_format_makes_dry_is_told_above_the_noise():
    model = examples.textbook()
    slow = replace(examples.motion(), dq=0.05 * examples.motion().dq)
    wide = tuple(
        replace(term, shape={"v0": 0.05}) if term.effect_id == "coulomb" else term
        for term in model.terms
    )
    quiet = replace(model, terms=wide, notes=ModelNotes(noise_floor=(1e-3,) * model.robot.n))
    told = export(quiet, "mjcf", motions={"held": slow})
    assert told.not_carried == ()
    assert told.loss.rms.min() > 0.1
    loud = replace(quiet, notes=ModelNotes(noise_floor=(1e3,) * model.robot.n))
    assert export(loud, "mjcf", motions={"held": slow}).loss is None


def test_a_free_fit_is_no_body():
    with pytest.raises(UserError, match="base parameters of a free fit alone do not make"):
        export(examples.textbook(), "mjcf", "free")
