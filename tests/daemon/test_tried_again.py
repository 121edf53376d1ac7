"""An experiment whose joint left its path against the prediction: slower, and it is said."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from types import SimpleNamespace

import pytest
from known_joints import measured_joints

from pa10d.common.errors import UserError
from pa10d.control.faults import Fault
from pa10d.daemon.motions.experiment import TRIES, Experiment
from pa10d.experiments.request import MotionRequest

FAST = Fault("velocity_limit", "moves at 2.1 rad/s, more than it may", axis=1)


def tried(monkeypatch, faults, request, tmp_path):
    """→ what each try was asked to be slower by, and the outcome or the error."""
    law = SimpleNamespace(name="pid")
    robot = SimpleNamespace(fault=None, joints=measured_joints(), law=law)
    paces = []

    async def reset():
        robot.fault = None

    async def once(self):
        pace = 1.0 if self._slower is None else self._slower.pace
        paces.append(pace)
        self.result.adjusted = {"pace": pace}
        self.result.runs.append(f"run{len(paces)}")
        if len(paces) <= len(faults):
            robot.fault = faults[len(paces) - 1]
            raise UserError("run x: aborted")
        return self.result

    robot.reset = reset
    monkeypatch.setattr(Experiment, "_once", once)
    daemon = SimpleNamespace(robot=robot, runtime=tmp_path)
    experiment = Experiment(daemon, request, lambda *_: None)
    try:
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
