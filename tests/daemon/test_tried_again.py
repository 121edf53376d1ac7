"""An experiment whose joint left its path against the prediction: slower, and it is said."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from known_joints import measured_joints

from pa10d.common.errors import Stopped, UserError
from pa10d.control.faults import Fault
from pa10d.control.stop import DIES_AWAY
from pa10d.daemon.motions.experiment import FALLS, TRIES, WEIGHINGS, Experiment, WeightsInDoubt
from pa10d.daemon.motions.numbers import STOPPED
from pa10d.daemon.robot.stops import Stops
from pa10d.experiments.checks import Check
from pa10d.experiments.request import MotionRequest

FAST = Fault("velocity_limit", "moves at 2.1 rad/s, more than it may", axis=1)


def tried(monkeypatch, faults, request, tmp_path, stopped_at=0):
    """→ what each try was asked to be slower by, and the outcome or the error. stopped_at: the try
    during which somebody presses stop."""
    law = SimpleNamespace(name="pid")
    robot = SimpleNamespace(fault=None, joints=measured_joints(), law=law, stops=Stops())
    paces = []

    async def reset():
        robot.fault = None

    async def once(self):
        pace = 1.0 if self._slower is None else self._slower.pace
        paces.append(pace)
        self.result.adjusted = {"pace": pace}
        self.result.runs.append(f"run{len(paces)}")
        if len(paces) == stopped_at:
            robot.stops.ask()
        if len(paces) <= len(faults):
            robot.fault = faults[len(paces) - 1]
            raise UserError("run x: aborted")
        return self.result

    robot.reset, robot.pose = reset, lambda: np.zeros(2)
    monkeypatch.setattr(Experiment, "_once", once)
    daemon = SimpleNamespace(robot=robot, runtime=tmp_path)
    experiment = Experiment(daemon, request, lambda *_: None)
    try:
        with robot.stops.heard_by(robot.stops.count):
            return paces, asyncio.run(experiment.carry_out())
    except UserError as error:
        return paces, error


def test_half_as_fast_and_half_of_that(monkeypatch, tmp_path):
    paces, found = tried(monkeypatch, [FAST, FAST], MotionRequest("excitation"), tmp_path)
    assert paces == [1.0, 2.0, 4.0]
    assert found.runs == ["run3"], "of what was broken off nothing is analysed"
    assert found.notes[0].startswith("joint 2 moves at 2.1 rad/s")


@pytest.mark.parametrize(
    ("fault", "request_"),
    [
        (replace(FAST, kind="following_error"), MotionRequest("excitation")),
        (replace(FAST, kind="emcy"), MotionRequest("excitation")),
        (FAST, MotionRequest("excitation", controller="computed_torque", model="m")),
    ],
)
def test_what_a_lower_speed_does_not_mend_is_left(monkeypatch, fault, request_, tmp_path):
    paces, found = tried(monkeypatch, [fault], request_, tmp_path)
    assert paces == [1.0]
    assert isinstance(found, UserError)


def test_three_tries_are_the_most(monkeypatch, tmp_path):
    paces, found = tried(monkeypatch, [FAST] * 9, MotionRequest("excitation"), tmp_path)
    assert len(paces) == TRIES
    assert isinstance(found, UserError)


def test_what_somebody_has_stopped_is_not_tried_again(monkeypatch, tmp_path):
    asked = MotionRequest("excitation")
    paces, found = tried(monkeypatch, [FAST, FAST], asked, tmp_path, stopped_at=1)
    assert paces == [1.0]
    assert isinstance(found, Stopped)


FELL = Fault("not_held", "moves at 0.8 rad/s; about 0.3 N·m would have held it", 5, weighed=6)


def test_a_joint_that_told_its_weight_as_it_fell_is_enabled_again(monkeypatch, tmp_path):
    """Each joint of its own, whichever is too fast, and as fast as before: it was never moved."""
    other = replace(FELL, weighed=2)
    falls = [*FALLS * [FELL], other]
    paces, found = tried(monkeypatch, falls, MotionRequest("x"), tmp_path)
    assert paces == (FALLS + 2) * [1.0]
    assert [note[:7] for note in found.notes] == (FALLS + 1) * ["joint 6"]


def test_what_is_going_to_happen_is_said_and_not_what_nobody_has_to_do(
    monkeypatch, tmp_path, caplog
):
    tried(monkeypatch, [FELL], MotionRequest("x"), tmp_path)
    assert "the arm rests, and is enabled again by itself" in caplog.text
    _, error = tried(monkeypatch, [FELL] * 9, MotionRequest("x"), tmp_path)
    for said in (caplog.text, str(error)):
        assert "'reset'" not in said
    assert f"not held {FALLS + 1} times, and is not tried again by itself" in str(error)
    assert "base.rpy" in str(error)


def test_it_tells_three_times_at_most_and_not_at_all_where_nothing_was_learnt(
    monkeypatch, tmp_path
):
    for faults, tries in (([FELL] * 9, FALLS + 1), ([replace(FELL, weighed=0)], 1)):
        paces, error = tried(monkeypatch, faults, MotionRequest("x"), tmp_path)
        assert (len(paces), type(error)) == (tries, UserError)


GAVE = Fault("brake_gave", "left its place in its brake as that of joint 1 opened", 1, device=True)


def test_brakes_that_do_not_open_alone_are_opened_together_by_itself(monkeypatch, tmp_path, caplog):
    """Control does that with the next enabling; if the same is seen again, it is something else."""
    falls = [FELL, FELL, FELL, GAVE, FELL]
    paces, found = tried(monkeypatch, falls, MotionRequest("x"), tmp_path)
    assert paces == (len(falls) + 1) * [1.0]
    assert "with all brakes opening together" in found.notes[3]
    assert "all brakes opening together" in caplog.text
    paces, error = tried(monkeypatch, [GAVE, GAVE], MotionRequest("x"), tmp_path)
    assert (len(paces), type(error)) == (2, UserError)
    paces, error = tried(monkeypatch, [GAVE], MotionRequest("x"), tmp_path, stopped_at=1)
    assert (len(paces), type(error)) == (1, Stopped)


LOST = replace(FELL, weighed=0, alone_next=True)


def test_after_a_fall_that_told_nothing_each_brake_opens_alone(monkeypatch, tmp_path, caplog):
    """A slide that rubs nowhere fell twice with its neighbours, and that was the end."""
    paces, found = tried(monkeypatch, [FELL, LOST, FELL], MotionRequest("x"), tmp_path)
    assert paces == 4 * [1.0]
    assert "with each brake opening alone first" in found.notes[1]
    assert "each brake opening alone first" in caplog.text
    paces, error = tried(monkeypatch, [LOST, LOST], MotionRequest("x"), tmp_path)
    assert (len(paces), type(error)) == (2, UserError)
    paces, error = tried(monkeypatch, [LOST], MotionRequest("x"), tmp_path, stopped_at=1)
    assert (len(paces), type(error)) == (1, Stopped)


def test_nor_where_the_next_fall_would_go_over_a_limit():
    """Brakes take their time: a slide went a centimetre or two each time, onto its end."""
    arm = SimpleNamespace(lower=np.array([-0.09, -3.0]), upper=np.array([0.09, 3.0]))
    experiment = Experiment.__new__(Experiment)
    experiment._robot, experiment._stood = SimpleNamespace(robot=arm), np.array([0.03, 0.0])
    assert experiment._falls_out(np.array([0.05, 1.4])) is None
    assert experiment._falls_out(np.array([0.07, 1.4])) == 1
    assert experiment._falls_out(np.array([0.05, -1.6])) == 2


def test_nobody_tries_again_before_a_slow_servo_has_brought_the_arm_to_rest():
    """Of 0.1 Hz, in simulated time that goes half as fast as ours."""
    assert 2.0 * DIES_AWAY / (2.0 * np.pi * 0.1) < STOPPED


def test_nor_after_a_stop(monkeypatch, tmp_path):
    paces, error = tried(monkeypatch, [FELL], MotionRequest("x"), tmp_path, stopped_at=1)
    assert (len(paces), type(error)) == (1, Stopped)


def leant(measured, lean):
    return replace(measured, known=measured.known.leaning(lean))


def weighed(monkeypatch, tmp_path, enough, lean="", knew=""):
    """→ which share was run in each try, which runs told weights, and the outcome or the error.
    enough: smaller motions after which the whole of it is taken; lean: what they show of the base,
    of which somebody ``knew``."""
    shares, told, used = [], [], []

    class Workers:
        async def run(self, what, _, **asked):
            told.append((what.partition(":")[2], asked["runs"]))
            return leant(measured_joints(kd=7.0), lean).document()

    async def use_gains(gains, keep, felt):
        used.append((gains.kd[0], keep))

    async def once(self):
        share = 1.0 if self._slower is None else self._slower.small
        if share == 1.0 and len(told) < enough:
            raise WeightsInDoubt([Check("warning", "tracking", "joint 7 would be off")], 0.25)
        shares.append(share)
        self.result.runs.append(f"run{len(shares)}")
        return self.result

    monkeypatch.setattr(Experiment, "_once", once)
    law = SimpleNamespace(name="pid")
    robot = SimpleNamespace(
        fault=None,
        joints=leant(measured_joints(), knew),
        law=law,
        stops=Stops(),
        use_gains=use_gains,
    )
    profile = SimpleNamespace(path="arm.yaml")
    daemon = SimpleNamespace(
        robot=robot, runtime=tmp_path, workers=Workers(), data="data", profile=profile
    )
    experiment = Experiment(daemon, MotionRequest("excitation"), lambda *_: None)
    try:
        with robot.stops.heard_by(robot.stops.count):
            found = asyncio.run(experiment.carry_out())
    except UserError as error:
        found = error
    return shares, told, used, robot, found


def test_a_smaller_motion_weighs_the_arm_before(monkeypatch, tmp_path):
    shares, told, used, robot, found = weighed(monkeypatch, tmp_path, enough=1)
    assert shares == [0.25, 1.0]
    assert told == [("keep_felt", ["run1"])]
    assert used == [(7.0, True)]
    assert robot.joints.known.gains.kd[0] == 7.0
    assert found.runs == ["run2"], "what was run before is not what was asked for"
    assert "25% of the motion was run before" in found.notes[0]


@pytest.mark.parametrize(("knew", "said"), [("", 1), ("it leans", 0)])
def test_a_lean_that_only_a_smaller_motion_shows_is_said(monkeypatch, tmp_path, knew, said):
    *_, found = weighed(monkeypatch, tmp_path, 1, "it leans by 9°", knew)
    assert found.notes.count("it leans by 9°") == said


def test_not_for_ever(monkeypatch, tmp_path):
    shares, _, _, _, found = weighed(monkeypatch, tmp_path, enough=99)
    assert shares == [0.25] * WEIGHINGS
    assert isinstance(found, UserError)
    assert "joint 7 would be off" in str(found)
    assert "a smaller motion" in str(found)
