"""A known weight tells each joint's torque gain, whatever the arm weighs."""

from __future__ import annotations

import json

import numpy as np
import pytest

from backends.virtual.datasets import make_runs
from pa10d.cli import main
from pa10d.dynamics.robot import rigid_body, robot_from_profile
from pa10d.identify.scale import Load, torque_gains
from pa10d.profile import load_profile

TRUE = {2: 1.15, 3: 0.9}
MASS, COM = 3.0, (0.0, 0.02, 0.1)


@pytest.fixture(scope="module")
def recorded():
    arm = load_profile("ur5e")
    gains = [{"effect": "torque_gain", "joint": j, "gain": g} for j, g in TRUE.items()]
    body = {"effect": "payload", "mass": MASS, **dict(zip(("cx", "cy", "cz"), COM, strict=True))}
    kinds = ("train_a", "valid_a")
    empty, _ = make_runs(4, gains, "white", kinds, arm, seconds=15.0, rate=200.0)
    loaded, _ = make_runs(4, [*gains, body], "white", kinds, arm, seconds=15.0, rate=200.0)
    return robot_from_profile(arm), list(empty.values()), list(loaded.values())


def test_wrong_torque_constants_are_found_with_honest_errors(recorded):
    robot, empty, loaded = recorded
    known = np.zeros((robot.n, 10))
    known[-1] = rigid_body(MASS, COM)
    found = torque_gains(robot, empty, [Load(loaded, known, MASS)])
    for j in (2, 3, 4):
        off = found.gain[j - 1] - TRUE.get(j, 1.0)
        assert abs(off) < 4 * found.std_error[j - 1]
        assert found.std_error[j - 1] < 0.05
    if found.next_mass is not None:
        assert found.next_mass > MASS


def test_a_joint_that_the_weight_does_not_load_is_not_told():
    arm = load_profile("cobra600")
    robot = robot_from_profile(arm)
    runs, _ = make_runs(1, [], "white", ("train_a",), arm, seconds=6.0, rate=100.0)
    body = np.zeros((robot.n, 10))
    found = torque_gains(robot, list(runs.values()), [Load(list(runs.values()), body, 0.0)])
    assert np.isnan(found.gain).all()
    assert found.next_mass is None


def test_a_servo_with_a_known_weight(shared_data, tmp_path, capsys):
    """Plain least squares give 1.58 times the known weight; with friction that goes with the load
    set apart, what is left over 1 is half of its part that depends on the direction of power."""
    folder = shared_data / "bam_xl330"
    urdf, data = str(folder / "robot.urdf"), ["--data", str(tmp_path)]
    names = ["sin_sin_kp200", "sin_time_square_kp200", "up_and_down_kp200", "sin_sin_kp400"]
    for name in names:
        file = str(folder / f"xl330_{name}.csv")
        assert main([*data, "run", "import", file, "--profile", urdf, "--name", name]) == 0
    capsys.readouterr()
    weight = ["--payload", "0.49,0,0,-0.1", *names]
    assert main([*data, "--json", "scale", "--alone", *weight, "--profile", urdf]) == 0
    found = json.loads(capsys.readouterr().out)
    assert 0.9 < found["joints"][0]["gain"] < 1.35
    assert found["schema"] == "pa10d/scale/1"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--alone", "--payload", "heavy", "a"], "expected MASS,X,Y,Z"),
        (["--alone", "--payload", "0,0,0,0", "a"], "expected MASS,X,Y,Z"),
        (["--alone", "--payload", "2,0,0,0"], "no run, expected BODY and the runs"),
        (["--payload", "2,0,0,0", "a"], "expected --empty RUN"),
    ],
)
def test_wrong_usage_is_one_line(tmp_path, capsys, words, said):
    assert main(["--data", str(tmp_path), "scale", *words, "--profile", "ur5e"]) == 1
    error = capsys.readouterr().err
    assert said in error
    assert "Traceback" not in error
