"""A search in doubt, in a whole investigation: its experiment is run, or written for others."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest
import yaml
from small_arm import small_arm

from backends.virtual.datasets import make_runs
from pa10d.cli import main
from pa10d.client import local_daemon
from pa10d.investigation import motions
from pa10d.investigation.begin import begin
from pa10d.services.library import open_library
from pa10d.services.robots import load_robot
from pa10d.services.starting_set import SuggestedMotion
from pa10d.store import Channels, Samples
from pa10d.trajectory.kinds import KINDS

pytestmark = [pytest.mark.long, pytest.mark.timeout(1800)]

BRAKE = {"effect": "nonlinear_viscous", "joint": 3, "Fp": 6.0, "p": 2.0}
SLOWLY = 16.0  # s of slow motion, in which position and speed go together


def slow_sine(purpose: str, phase: float) -> tuple[SuggestedMotion, str]:
    """Two periods in which every joint's speed is a function of its angle, but for its sign."""
    share = np.array([0.3, 0.25, 0.4])
    parameters = {
        "fundamental": 0.1, "harmonics": 1, "cycles": 2, "centre": [0.0, 0.6, 1.0],
        "a": [(share * np.cos(phase)).tolist()], "b": [(share * np.sin(phase)).tolist()],
    }  # fmt: skip
    return SuggestedMotion(kind="excitation", parameters=parameters, why="slowly"), purpose


def test_it_is_settled_by_motion(tmp_path, monkeypatch):
    """Slow motion first, which cannot tell; what the arm is then asked for can."""
    path = small_arm(tmp_path, BRAKE)
    data = tmp_path / "data"
    slowly = [slow_sine("fit", 0.0), slow_sine("judge", 1.0)]
    monkeypatch.setattr(motions, "_asked", lambda *_, **__: [*slowly, (motions.FRESH, "fresh")])
    state, _ = begin(str(data), str(path), minutes=10)
    with local_daemon(data, str(path), clock="simulated") as client:
        client.wait_for_robot("inactive", timeout=240)
        client.investigate(state.id)
        found = client.investigation(state.id)
        runs = {run["id"]: run for run in client.runs()}
    steps = {step["id"]: step for step in found["steps"]}
    assert found["status"] == "done"
    asked = [s for s in steps if s.startswith(("settle", "diagnose"))]
    assert asked[:3] == ["diagnose-1", "settle-1", "diagnose-2"], json.dumps(found["steps"])
    about = "Nonlinear viscous friction in joint 3 could also be"  # beside what else is in doubt
    (settle,) = [s for s in asked if steps[s].get("why", "").startswith(about)]
    (settling,) = steps[settle]["runs"]
    assert set(runs[settling]["tags"]) >= {"fit", "judge"}
    after = asked[asked.index(settle) + 1]
    assert "Nonlinear viscous friction in joint 3" in steps[after]["said"]
    assert steps["judge"]["said"].startswith("The error of joint 3 falls from")


def test_its_experiment_is_written_for_others(tmp_path, capsys):
    """On recordings nothing moves: a plan for this program, and a motion as a table."""
    path = small_arm(tmp_path, BRAKE)
    data = tmp_path / "data"
    profile, robot = load_robot(str(path))
    (run,) = make_runs(5, [BRAKE], "white", ("train_b",), profile, seconds=SLOWLY)[0].values()
    stamps = (run.t * 1e9).round().astype("int64")
    with open_library(data).runs.building(
        "slow", "slow", Channels(joints=robot.joint_names), profile
    ) as writer:
        writer.append(Samples(stamps, run.q, run.tau))
    report = tmp_path / "found.html"
    asked = ["--data", str(data), "investigate", "--profile", str(path), "--fit", "slow"]
    assert main([*asked, "--report", str(report)]) == 0
    out = capsys.readouterr().out
    (plan,), (motion,) = (list((tmp_path / "doubts").glob(f"*.{end}")) for end in ("yaml", "csv"))
    assert str(plan) in out
    assert str(motion) in out
    asks = yaml.safe_load(plan.read_text())
    doubt = plan.read_text().splitlines()[0].lower()
    assert "could also be" in doubt
    assert "nonlinear viscous friction in joint 3" in doubt
    assert asks["kind"] in KINDS
    with motion.open() as file:
        head, *rows = csv.reader(file)
    assert head == ["time", "q1", "q2", "q3"]
    t, *q = np.array(rows, dtype=float).T
    assert np.allclose(np.diff(t), 0.01, atol=1e-6)
    assert max(np.abs(one[[0, -1]] - one[[1, -2]]).max() for one in q) < 1e-3, "rest to rest"
    assert np.ptp(q[2]) > 0.5, "the joint in doubt moves"
