"""Which other effects a finding cannot be told from, and when that is asked."""

from __future__ import annotations

import importlib
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from pa10d.diagnose.procedure import diagnose
from pa10d.diagnose.search import looking
from pa10d.dynamics import Robot, inverse_dynamics
from pa10d.dynamics.robot import rigid_body
from pa10d.identify import identify
from pa10d.measurement.recording import Recording

sys.path.append(str(Path(__file__).parents[2] / "scripts"))
bench_real = importlib.import_module("bench_real")


def carrying(run: Recording, robot: Robot, mass: float, com: tuple[float, ...]) -> Recording:
    """The same motion with a weight at the flange: Newton's and Euler's torque of it joins."""
    with_it = robot.parameters.copy()
    with_it[-1] += rigid_body(mass, np.array(com))
    dq = np.gradient(run.q, 1.0 / run.rate, axis=0)
    ddq = np.gradient(dq, 1.0 / run.rate, axis=0)
    both = [inverse_dynamics(robot, p, run.q, dq, ddq) for p in (with_it, robot.parameters)]
    return replace(run, tau=run.tau + both[0] - both[1])


@pytest.mark.long
def test_what_explains_more_and_was_not_sure_is_not_denied(shared_data):
    """A UR10 that was given 0.9 kg: "joint 3 now has a torque gain that is off", without a doubt;
    a payload takes three times as much, and more of that joint."""
    case = bench_real.case("ur10")
    model = identify(list(case.train), case.robot, name="m0")
    run = carrying(case.valid, case.robot, 0.9, (0.03, 0.02, 0.1))
    half = len(run.t) // 2
    fit, held = run.part(0, half, "b"), run.part(half, len(run.t), "c")
    found = diagnose(model, [fit], [held], frozen=True)
    named = {f.term.effect_id for f in found.findings}
    doubted = {c.effect for f in found.findings for c in f.confounded_with}
    assert "payload" in named | doubted


def test_a_rival_is_one_no_more_once_it_is_told_apart(monkeypatch):
    own, alike, behind, unasked = (SimpleNamespace(place=(name, (1,))) for name in "abcd")
    monkeypatch.setattr(looking, "look", lambda judging: ([own], [own, alike, behind]))
    monkeypatch.setattr(looking, "_tied", lambda state, one, other: other is alike)
    judging = SimpleNamespace(state=None)
    still = looking.still_tied(judging, own.place, [alike, behind, unasked])
    assert still == [alike, unasked]
