"""A known weight tells each joint's torque gain, whatever the arm weighs."""

from __future__ import annotations

import json

import numpy as np
import pytest
from pendulum import PENDULUM, swing

from backends.virtual.datasets import make_runs
from pa10d.cli import main
from pa10d.common.errors import UserError
from pa10d.dynamics.robot import robot_from_profile
from pa10d.identify.scale import Body, Load, prospects, torque_gains
from pa10d.identify.scale.prediction import best
from pa10d.profile import load_profile
from pa10d.services.documents import SCHEMAS

TRUE = {2: 1.15, 3: 0.9}
MASS, COM = 3.0, (0.0, 0.02, 0.1)
EXACT = Body(MASS, COM, 0.0, (0.0, 0.0, 0.0))


def hidden(body: Body) -> dict[str, object]:
    place = dict(zip(("cx", "cy", "cz"), body.com, strict=True))
    return {"effect": "payload", "mass": body.mass, **place}


@pytest.fixture(scope="module")
def recorded():
    arm = load_profile("ur5e")
    gains = [{"effect": "torque_gain", "joint": j, "gain": g} for j, g in TRUE.items()]
    kinds = ("train_a", "valid_a")
    empty, _ = make_runs(4, gains, "white", kinds, arm, seconds=15.0, rate=200.0)
    loaded, _ = make_runs(4, [*gains, hidden(EXACT)], "white", kinds, arm, seconds=15.0, rate=200.0)
    return robot_from_profile(arm), list(empty.values()), list(loaded.values())


def test_wrong_torque_constants_are_found_with_honest_errors(recorded):
    robot, empty, loaded = recorded
    found = torque_gains(robot, empty, [Load(loaded, EXACT)])
    for j in range(1, 7):
        off = found.gain[j - 1] - TRUE.get(j, 1.0)
        assert abs(off) < 4 * found.std_error[j - 1]
        assert found.std_error[j - 1] < 0.02


def test_what_is_not_known_of_the_weight_is_in_the_error(recorded):
    """A mass that is 2 % off makes the gains 2 % off: the stated error says so, and no more where
    the weight is known."""
    robot, empty, loaded = recorded
    exact = torque_gains(robot, empty, [Load(loaded, EXACT)])
    vague = Body(MASS, COM, 0.02 * MASS, (0.0, 0.0, 0.0))
    found = torque_gains(robot, empty, [Load(loaded, vague)])
    assert all(joint.told for joint in found.joints)
    for joint, sure in zip(found.joints, exact.joints, strict=True):
        assert joint.of_body == pytest.approx(0.02 * joint.gain, rel=1e-6)
        assert joint.std_error == pytest.approx(np.hypot(joint.of_noise, joint.of_body))
        assert sure.of_body == 0.0
    off = Body(1.02 * MASS, COM, 0.02 * MASS, (0.0, 0.0, 0.0))
    shifted = torque_gains(robot, empty, [Load(loaded, off)])
    np.testing.assert_allclose(shifted.gain * 1.02, found.gain, rtol=2e-3)


def test_the_place_of_the_centre_counts_where_it_is_a_part_of_the_lever(recorded):
    """2 mm at the flange are nothing for the shoulder and much for the last joint but one."""
    robot, empty, loaded = recorded
    vague = Body(MASS, COM, 0.0, (0.002, 0.002, 0.002))
    found = torque_gains(robot, empty, [Load(loaded, vague)])
    shoulder, wrist, last = (found.joints[j] for j in (1, 4, 5))
    assert shoulder.of_body / shoulder.gain == pytest.approx(0.002 / 1.0, rel=0.5)  # of a metre
    assert wrist.of_body / wrist.gain == pytest.approx(0.002 / 0.2, rel=0.5)
    assert last.of_body / last.gain == pytest.approx(0.002 / COM[1], rel=0.05)


def test_before_a_weight_is_hung_its_error_is_foretold(recorded):
    """From empty runs alone, to within what two recordings of noise can differ by."""
    robot, empty, loaded = recorded
    found = torque_gains(robot, empty[:1], [])
    assert np.isnan(found.gain).all()
    foretold = prospects(robot, found, [Body(0.5, COM, 0.0, (0.0, 0.0, 0.0)), EXACT])
    light, heavy = (one.std_error for one in foretold)
    np.testing.assert_allclose(heavy[[1, 3, 4, 5]] * 6.0, light[[1, 3, 4, 5]], rtol=0.12)
    came = torque_gains(robot, empty[:1], [Load(loaded[:1], EXACT)])
    for j in (1, 2, 3):
        assert 0.5 < heavy[j] / (came.std_error[j] / came.gain[j]) < 1.5
    assert foretold[1].too_much == 1  # in so fast a motion: joint 2's limit is 150 N·m
    assert best(found, foretold) is foretold[0]


def test_a_weight_that_the_arm_cannot_carry_is_not_advised(recorded):
    robot, empty, _ = recorded
    found = torque_gains(robot, empty[:1], [])
    seen = prospects(robot, found, [Body(500.0, COM, 0.0, (0.0, 0.0, 0.0))])
    assert seen[0].too_much is not None
    assert best(found, seen) is None


def test_a_joint_that_the_weight_does_not_load_is_not_told():
    """A weight beneath the axis, and one of a gram under noise of as many newton metres as a
    kilogram's."""
    light = Body(0.001, (0.0, 0.0, -0.5), 0.0, (0.0, 0.0, 0.0))
    beneath = Body(1.0, (0.0, 0.5, 0.0), 0.0, (0.0, 0.0, 0.0))
    for body, why in ((beneath, "asks nothing of it"), (light, "too little to tell")):
        run = swing("loaded", 1.0, 1.0, 1, body)
        found = torque_gains(PENDULUM, [], [Load([run], body)])
        assert np.isnan(found.gain).all()
        assert why in found.joints[0].why


@pytest.fixture
def servo(shared_data, tmp_path, capsys):
    """The published servo's recordings → what ``scale`` says of some of them."""
    folder = shared_data / "bam_xl330"
    urdf, data = str(folder / "robot.urdf"), ["--data", str(tmp_path)]
    known: set[str] = set()

    def ask(*names: str):
        for name in set(names) - known:
            known.add(name)
            file = str(folder / f"xl330_{name}.csv")
            assert main([*data, "run", "import", file, "--profile", urdf, "--name", name]) == 0
        capsys.readouterr()
        weight = ["--payload", "0.49+-0,0+-0,0+-0,-0.1+-0", *names]
        assert main([*data, "--json", "scale", "--alone", *weight, "--profile", urdf]) == 0
        found = json.loads(capsys.readouterr().out)
        SCHEMAS["scale"].model_validate(found)
        return found

    return ask


def test_a_servo_whose_friction_goes_with_the_load_is_bounded(servo):
    """Lifting takes 2.1 times the weight, sinking 0.7 times: three unknowns, two slopes. The
    maker's own scale (1) lies between the bounds, and outside of the bare standard error."""
    names = ["sin_sin_kp200", "sin_time_square_kp200", "up_and_down_kp200", "sin_sin_kp400"]
    found = servo(*names)
    joint = found["joints"][0]
    low, high = joint["between"]
    assert low < 1.0 < high
    assert high == pytest.approx(joint["gain"] + 2 * joint["std_error"])
    assert low < 0.8
    assert found["next_mass"] is None
    assert "no mass" in found["advice"]
    assert found["schema"] == "pa10d/scale/1"


def test_recordings_that_disagree_are_not_averaged_to_certainty(servo):
    """The same servo and weight: 1.0 of duty × voltage at small angles, 1.5 at large ones."""
    small, large = servo("sin_sin_kp100"), servo("sin_sin_kp800")
    assert large["joints"][0]["gain"] > 1.3 * small["joints"][0]["gain"]
    both = servo("sin_sin_kp100", "sin_sin_kp800")["joints"][0]
    assert both["disagree"]
    alone = max(one["joints"][0]["std_error"] for one in (small, large))
    assert both["std_error"] > 2 * alone


@pytest.mark.parametrize("second", [(), (0.3,), (3.0,), (0.3, 3.0)])
def test_no_second_mass_tells_directional_friction_from_gain(second):
    """Lifting 1.2·(1 + 0.3), sinking 1.2·(1 - 0.05): the bounds are 1.14 and the mean of both,
    1.35, by one mass, and by any number of them."""
    bodies = [Body(m, (0.0, 0.0, -0.5), 0.0, (0.0, 0.0, 0.0)) for m in (1.0, *second)]
    runs = [swing("a", 1.2, 0.01, k, b, driving=0.3, driven=0.05) for k, b in enumerate(bodies)]
    loads = [Load([run], body) for run, body in zip(runs, bodies, strict=True)]
    between = torque_gains(PENDULUM, [], loads).joints[0].between
    assert between == pytest.approx((1.14, 1.35), abs=0.003)


@pytest.mark.parametrize(
    "text",
    [
        "heavy",
        "3,0,0",
        "3,0,0,0,0",
        "-1,0,0,0",
        "3+-x,0,0,0",
        "3+--1,0,0,0",
        "nan,0,0,0",
        "3,0,0,99",
        "٣,0,0,0",
        "1_0,0,0,0",
        "3+-½,0,0,0",
    ],
)
def test_what_is_no_weight_is_one_line(text):
    with pytest.raises(UserError, match="expected MASS,X,Y,Z") as caught:
        Body.of(text)
    assert "\n" not in str(caught.value)


def test_a_weight_is_written_as_it_is_read():
    body = Body.of("3±0.005, 0, 0.02+-0.001, 0.1")
    assert body == Body(3.0, (0.0, 0.02, 0.1), 0.005, (0.002, 0.001, 0.002))
    assert Body.of(body.text) == body


@pytest.mark.parametrize(
    ("words", "status", "said"),
    [
        (["--alone", "--payload", "heavy", "a"], 2, "expected MASS,X,Y,Z"),
        (["--alone", "--payload", "0,0,0,0", "a"], 2, "expected MASS,X,Y,Z"),
        (["--alone", "--payload", "2,0,0,0"], 2, "no run, expected BODY and the runs"),
        (["--payload", "2,0,0,0", "a"], 2, "expected --empty RUN"),
    ],
)
def test_wrong_usage_is_one_line(tmp_path, capsys, words, status, said):
    assert main(["--data", str(tmp_path), "scale", *words, "--profile", "ur5e"]) == status
    error = capsys.readouterr().err
    assert said in error
    assert "Traceback" not in error
