"""A first motion whose arm swings: gains get calmer, it goes on, and says so; or it gives up."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from importlib import import_module
from types import SimpleNamespace

import numpy as np
import pytest
from known_joints import known_joints, measured_joints

from pa10d.common.errors import UserError
from pa10d.control.faults import Fault
from pa10d.control.joint_figures import JointFigures
from pa10d.control.known_joints import MeasuredJoints
from pa10d.control.ring import Ring
from pa10d.control.states import ArmState
from pa10d.daemon.motions import first_motion
from pa10d.daemon.motions.experiment import Experiment
from pa10d.daemon.robot.stops import Stops
from pa10d.experiments.outcome import Outcome
from pa10d.experiments.request import MotionRequest

FAULT = Fault("oscillation", "swings at 17 Hz", axis=1, hertz=17.0)
REQUEST = MotionRequest("first_motion")
OLD = 77.0  # damping from before


class Robot:
    """Swings until it was given calmer gains so many times."""

    def __init__(self, swings):
        self.swings, self.fault, self.moving = swings, None, False
        self.used, self.resets, self.joints = [], 0, None
        self.stops = Stops()

    def pose(self):
        return np.zeros(2)

    async def use_gains(self, gains, keep, felt=None):
        self.used.append((gains.kd[0], keep))

    async def reset(self):
        self.resets, self.fault = self.resets + 1, None


class Workers:
    """What the services would say; ``calmer`` until there is nothing calmer."""

    def __init__(self, calmest, slower=False):
        self.calmest, self.slower, self.calls = calmest, slower, []
        self.unmet, self.went = [], []
        self.more, self.soft = [], []  # parts, and joints, from 1

    async def run(self, what, _, **asked):
        name = what.split(":")[1]
        self.calls.append(name)
        if name == "parts_to_run":
            before = known_joints(OLD).gains.document()
            told = {"begin": known(0), "before": before, "notes": self.unmet}
            return {"parts": ["friction", *self.more], **told}
        if name == "soft_joints":
            return [j for j in self.soft if asked["of"] is None or j in asked["of"]]
        assert callable(getattr(import_module(what.split(":")[0]), name))
        if name == "way_out":
            assert Fault.from_document(asked["fault"]).joint == 2
            return f"the way out of step {asked['known']['gains']['kd'][0]:g}"
        if name == "slower":
            return 0.5 if self.slower and asked["speed"] == 1.0 else None
        if name == "calmer":
            assert Fault.from_document(asked["fault"]).joint == 2
            self.went.append(asked["went"])
            step = int(asked["known"]["gains"]["kd"][0]) + 1
            return None if step > self.calmest else known(step) | {"note": f"note {step}"}
        if name == "learn":
            return asked["known"]
        return measured_joints(
            asked["known"]["gains"]["kd"][0], sentences=("joint 1: …",)
        ).document()


def known(step):
    return known_joints(step).document()


def measured(
    monkeypatch,
    swings,
    calmest=10,
    fault=FAULT,
    slower=False,
    unmet=(),
    bandwidth_hz=4.0,
    soft=None,
    request=REQUEST,
):
    """→ the robot, the workers, and the result or the error."""
    robot, workers = Robot(swings), Workers(calmest, slower)
    workers.unmet = list(unmet)
    if soft is not None:
        workers.more, workers.soft = ["sliding"], soft
    robot.speeds, robot.parts = [], []

    class Experiment:
        falls, result = (), Outcome("first_motion")
        went = np.zeros((3, 2)), np.ones((3, 2))

        def __init__(self, daemon, request, report, figures):
            self.request = request
            robot.parts.append((request.parameters["part"], request.parameters.get("joints")))
            robot.speeds.append(request.parameters.get("speed", 1.0))
            assert isinstance(figures, JointFigures)

        async def carry_out(self):
            if robot.swings:
                robot.swings -= 1
                robot.fault = fault
                raise UserError("run x: aborted")
            return Outcome(self.request.kind, ["x"], seconds=1.0)

    monkeypatch.setattr(first_motion, "Experiment", Experiment)
    control = SimpleNamespace(bandwidth_hz=bandwidth_hz)
    profile = SimpleNamespace(path="arm.yaml", control=control)
    daemon = SimpleNamespace(
        robot=robot, workers=workers, data="data", profile=profile, measured_joints=lambda: None
    )
    try:
        found = asyncio.run(first_motion.FirstMotion(daemon, request, lambda *_: None).carry_out())
    except UserError as error:
        found = error
    return robot, workers, found


def test_calmer_gains_are_tried_said_and_kept(monkeypatch):
    robot, workers, found = measured(monkeypatch, swings=2)
    assert [gains for gains, _ in robot.used] == [0, 1, 2, 2]
    assert robot.used[-1] == (2, True)
    assert found.tuned == ["note 1", "note 2"]
    (slower,) = found.notes
    assert slower.startswith("The servo is slower than the 4 Hz asked for")
    assert "(joint 2: 1.5 Hz)" in slower
    assert robot.resets == 2
    assert robot.joints.known.gains.kd[0] == 2
    assert found.recommendation == ["joint 1: …"]
    assert MeasuredJoints.from_document(found.joints).document() == found.joints
    assert workers.calls[-1] == "keep_joints"


def test_of_a_servo_that_nobody_asked_for_it_is_said_that_nothing_is_wrong(monkeypatch):
    _, _, found = measured(monkeypatch, swings=0, bandwidth_hz=None)
    (slower,) = found.tuned
    assert slower.startswith("The servo is slower than the usual 4 Hz")
    assert "nothing is wrong with that" in slower


def test_a_doubt_that_no_gains_meet_is_said(monkeypatch):
    _, _, found = measured(monkeypatch, swings=1, unmet=["joint 2 from 0.5 on"])
    assert found.tuned[:2] == ["joint 2 from 0.5 on", "note 1"]


def test_where_nobody_has_to_do_anything_the_notes_say_nothing_of_gains(monkeypatch):
    unmet = ["joint 2 from 0.5 on"]
    _, _, found = measured(monkeypatch, swings=2, unmet=unmet, bandwidth_hz=None)
    assert found.notes == []
    assert len(found.tuned) == 4


@pytest.mark.parametrize(
    ("calmest", "behind", "last"), [(99, False, 4), (1, False, 1), (7, True, 7)]
)
def test_where_that_does_not_help_the_way_out_is_said(monkeypatch, calmest, behind, last):
    """What falls behind is not given up while its servo can be firmer: by its weight, and twice as
    firm four times."""
    fault = BEHIND if behind else FAULT
    robot, workers, found = measured(monkeypatch, 99, calmest, fault=fault)
    assert isinstance(found, UserError)
    assert str(found) == f"joint 2: {fault.cause}; the way out of step {last}"
    assert "keep_joints" not in workers.calls
    assert robot.used[-1] == (OLD, False), "the gains from before are back"


def test_another_fault_is_not_tried_again(monkeypatch):
    robot, _, found = measured(monkeypatch, 1, fault=replace(FAULT, kind="position_limit"))
    assert str(found) == "run x: aborted"
    assert robot.resets == 0


def test_a_joint_that_falls_behind_is_tried_again_or_the_way_out_is_said(monkeypatch):
    behind = replace(FAULT, kind="following_error", cause="is 0.15 rad from where it should be")
    robot, _, found = measured(monkeypatch, 1, fault=behind)
    assert found.tuned[0] == "note 1"
    assert robot.resets == 1
    robot, workers, found = measured(monkeypatch, 1, calmest=0, fault=behind)
    told = "joint 2: is 0.15 rad from where it should be; the way out of step 0"
    assert str(found) == told
    assert "keep_joints" not in workers.calls


BEHIND = Fault("following_error", "is 0.2 rad from where it should be", axis=1)


def test_a_joint_that_no_gains_help_strokes_more_slowly(monkeypatch):
    robot, _, found = measured(monkeypatch, 1, calmest=0, fault=BEHIND, slower=True)
    assert robot.speeds == [1.0, 0.5]
    assert found.notes[0].startswith("joint 2 fell behind: strokes at 0.5 of their speed")
    assert robot.resets == 1


def test_and_once_more_is_the_end(monkeypatch):
    robot, workers, found = measured(monkeypatch, 2, calmest=0, fault=BEHIND, slower=True)
    assert robot.speeds == [1.0, 0.5]
    assert isinstance(found, UserError)
    assert "keep_joints" not in workers.calls


def test_what_swings_is_never_tried_more_slowly(monkeypatch):
    robot, workers, _ = measured(monkeypatch, 9, calmest=0, slower=True)
    assert robot.speeds == [1.0]
    assert "slower" not in workers.calls


def test_one_that_fell_behind_is_weighed_by_its_way_to_the_start_as_well(monkeypatch):
    """Of that nothing is recorded: "its servo is as firm as it can be" was said."""
    behind = Fault("following_error", "is 0.2 rad from where it should be", axis=1)
    for fault, seen in ((behind, [3 * [[0.0, 0.0]], 3 * [[1.0, 1.0]]]), (FAULT, None)):
        _, workers, _ = measured(monkeypatch, 1, fault=fault)
        assert workers.went == [seen]


def test_all_that_a_fault_ended_is_looked_at(tmp_path):
    """From where the motion began until the drives have it."""
    robot = SimpleNamespace(ring=Ring.create(2, 512, 0.01))
    row, get = np.zeros(robot.ring.layout.width), robot.ring.layout.get
    for k in range(300):
        get(row, "q")[:], get(row, "torque")[:] = k, k < 280
        get(row, "state")[...] = ArmState.RUNNING if k < 250 else ArmState.STOPPING
        get(row, "state")[...] = ArmState.FAULT if k >= 290 else get(row, "state")
        robot.ring.append(row)
    daemon = SimpleNamespace(robot=robot, runtime=tmp_path)
    experiment = Experiment(daemon, REQUEST, lambda *_: None)
    experiment._began = 100
    q, torque = experiment.went
    assert q[:, 0].tolist() == list(range(100, 280))
    assert torque.shape == q.shape


def test_joints_with_a_soft_servo_are_slid_shortly_before_they_stroke(monkeypatch):
    robot, workers, found = measured(monkeypatch, swings=0, soft=[2])
    assert robot.parts == [("friction", None), ("sliding", [2])]
    assert found.runs == ["x", "x"]
    robot, workers, _ = measured(monkeypatch, swings=0, soft=[])
    assert robot.parts == [("friction", None)], "there are none"
    assert workers.calls.count("learn") == 1
    first = MotionRequest("first_motion", {"joints": [1]})
    robot, _, _ = measured(monkeypatch, swings=0, soft=[2], request=first)
    assert robot.parts == [("friction", [1])], "nobody asked for that one"
