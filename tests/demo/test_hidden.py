"""What the demo hides stays with the simulator, and is of the seed alone."""

from __future__ import annotations

import pytest

from backends.virtual.plant.catalogue import LISTED
from pa10d.common.errors import UserError
from pa10d.demo.bench import Bench
from pa10d.demo.hidden import Hidden, hide
from pa10d.effects import all_effects
from pa10d.profile import Simulation, load_profile

PROFILE = load_profile("pa10-sim")
PAYLOAD = Hidden(({"effect": "payload", "mass": 1.0},))
SPRING = Hidden(({"effect": "spring", "joint": 2, "k": 12.0},))


def with_simulation(**more):
    return PROFILE.model_copy(update={"simulation": Simulation(**more)})


def test_it_follows_from_the_seed_alone():
    drawn = [hide(None, seed, PROFILE) for seed in range(40)]
    assert drawn == [hide(None, seed, PROFILE) for seed in range(40)]
    assert {h.name for h in drawn} <= set(LISTED)
    assert not any(all_effects()[h.name].escapes_demo for h in drawn)
    assert len({h.name for h in drawn}) > 10


@pytest.mark.parametrize(
    ("asked", "joints"), [("stribeck:4", (4,)), ("torque_ripple:1", (1,)), ("none", ())]
)
def test_an_effect_sits_where_it_was_asked_for(asked, joints):
    assert hide(asked, 5, PROFILE).joints == joints


def test_a_pair_holds_the_joint_asked_for():
    assert 6 in hide("coupling_friction:6", 5, PROFILE).joints


@pytest.mark.parametrize(
    ("asked", "says"),
    [
        ("gremlins", "no such effect, expected none or one of torque_offset"),
        ("stribeck:8", "joint '8', expected 1 to 7"),
        ("stribeck:x", "joint 'x', expected 1 to 7"),
        ("stribeck:²", "joint '²', expected 1 to 7"),
        ("payload:3", "payload is of the whole arm, expected no joint"),
    ],
)
def test_what_cannot_be_hidden_is_refused(asked, says):
    with pytest.raises(UserError, match=says):
        hide(asked, 1, PROFILE)


def test_a_profile_may_hide_something_itself():
    entry = dict(SPRING.effects[0])
    assert hide(None, 1, with_simulation(options={"effects": [entry]})) == SPRING


def test_a_foreign_plant_keeps_its_secret():
    profile = with_simulation(plant="somewhere:plant", options={"weight": 3})
    hidden = hide(None, 1, profile)
    assert hidden == Hidden(foreign=True)
    with pytest.raises(UserError, match="brings a plant of its own"):
        hide("stribeck", 1, profile)
    assert Bench(profile, hidden, 1)._secret(later=True).simulation.options == {"weight": 3}


@pytest.mark.parametrize(("hidden", "first"), [(PAYLOAD, []), (SPRING, list(SPRING.effects))])
def test_a_change_happens_between_the_two_days(hidden, first):
    """The arm itself stays the same one; a trait is there from the beginning."""
    bench = Bench(PROFILE, hidden, 5)
    days = [bench._secret(later).simulation for later in (False, True)]
    assert [day.options["effects"] for day in days] == [first, list(hidden.effects)]
    assert days[0].options["dynamics"] == days[1].options["dynamics"]
    assert days[0].seed != days[1].seed
    assert PROFILE.simulation.options == {}, "the daemon's profile knows nothing of it"


def test_a_real_arm_is_not_moved():
    with pytest.raises(UserError, match="expected a profile with 'simulation'"):
        Bench(load_profile("pa10-7c"), Hidden(), 1)


def test_what_was_hidden_is_told_in_units():
    stribeck = {"effect": "stribeck", "joint": 4, "Fs": 4.0, "vs": 0.1, "delta": 1.0}
    told = "stribeck in joint 4 (Fs = 4.0 N·m, vs = 0.1 rad/s, delta = 1.0)"
    assert Hidden((stribeck,)).in_words() == told
    ripple = {"effect": "torque_ripple", "joint": 4, "N": 25.0, "sin": 1.4, "cos": 0.5}
    told = "torque_ripple in joint 4 (N = 25.0 cycles/rev, sin = 1.4 N·m, cos = 0.5 N·m)"
    assert Hidden((ripple,)).in_words() == told
    payload = {"effect": "payload", "mass": 1.5, "cx": 0.01}
    assert Hidden((payload,)).in_words() == "payload (mass = 1.5 kg, cx = 0.01 m)"


def test_an_arm_of_one_light_joint_hides_what_it_can_show(tmp_path):
    """Half of the draws were tracebacks: no second joint, no link beside a rotor of 1000 N·m."""
    (tmp_path / "arm.urdf").write_text(
        '<robot name="one"><link name="base"/><joint name="a" type="revolute">'
        '<parent link="base"/><child link="l"/><axis xyz="0 1 0"/><origin xyz="0 0 0.5"/>'
        '<limit lower="-2" upper="2" effort="1000" velocity="2"/></joint><link name="l"><inertial>'
        '<origin xyz="0 0 0.1"/><mass value="0.2"/><inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001"'
        ' iyz="0" izz="0.001"/></inertial></link></robot>'
    )
    (tmp_path / "arm.yaml").write_text(
        "urdf: arm.urdf\nsimulation: {plant: backends.virtual.plant:build}\n"
    )
    profile = load_profile(tmp_path / "arm.yaml")
    names = {hide(None, seed, profile).name for seed in range(40)}
    two = {"coupling_friction", "coupling_inertia", "joint_elasticity", "backlash"}
    assert len(names) > 8
    assert not names & two
    for name in two:
        with pytest.raises(UserError, match=f"--hide {name}: .*, expected another effect"):
            hide(name, 1, profile)
