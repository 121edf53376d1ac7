"""A pre-check is made with what the motion itself will be given."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from pa10d.daemon.motions.experiment import carried_by
from pa10d.experiments.request import MotionRequest

JOINTS = {"figures": {"of": "them"}, "gains": {"of": "them"}}


def robot(law="pid", model=None):
    return SimpleNamespace(joints=JOINTS, controller={"name": law}, model=model)


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
    found = carried_by(robot(), asked("pid", kind="first_motion"), {"so": "far"})
    assert (found.joints, found.ahead) == ({"figures": {"so": "far"}}, True)
