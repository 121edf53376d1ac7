"""A pre-check is made with what the motion itself will be given."""

from __future__ import annotations

import json
from types import SimpleNamespace

import pytest
from known_joints import measured_joints

from pa10d.control.known_joints import MeasuredJoints
from pa10d.daemon.motions.experiment import carried_by
from pa10d.experiments.request import MotionRequest

MEASURED = measured_joints()
JOINTS = MEASURED.document()


def robot(law="pid", model=None):
    return SimpleNamespace(joints=MEASURED, law=SimpleNamespace(name=law, model=model))


def asked(controller=None, model=None, kind="tracking"):
    return MotionRequest(kind, controller=controller, model=model)


@pytest.mark.parametrize(
    ("arm", "request_", "joints", "model", "ahead"),
    [
        (robot(), asked(), JOINTS, None, True),
        (robot(), asked("pid"), JOINTS, None, False),
        (robot("computed_torque", "m1"), asked(), None, "m1", True),
        (robot("computed_torque", "m1"), asked("pid"), JOINTS, None, False),
        (robot(), asked("computed_torque", "m2"), None, "m2", False),
        (robot(), asked(kind="first_motion"), None, None, True),
    ],
)
def test_servo_and_model_are_those_of_the_motion(arm, request_, joints, model, ahead):
    found = carried_by(arm, request_)
    assert (found.joints, found.model, found.ahead) == (joints, model, ahead)


def test_a_first_motion_under_way_knows_its_figures_alone():
    far = MEASURED.known.figures
    found = carried_by(robot(), asked("pid", kind="first_motion"), far)
    assert (found.joints, found.ahead) == ({"figures": far.document()}, True)


def test_what_is_known_of_joints_goes_through_json_unchanged():
    text = json.dumps(JOINTS, allow_nan=False)  # infinite is null there
    assert MeasuredJoints.from_document(json.loads(text)).document() == JOINTS
    with pytest.raises(ValueError, match="schema: found pa10d/joints/1"):
        MeasuredJoints.from_document(JOINTS | {"schema": "pa10d/joints/1"})
