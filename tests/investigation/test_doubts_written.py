"""What would settle a doubt lies in files: a plan for this program, a motion for any other."""

from __future__ import annotations

import json

import numpy as np
import yaml
from made_up import finding

from pa10d.common.jsonable import parsed
from pa10d.investigation.doubts import FOLDER, write_doubts
from pa10d.investigation.motions import MOTIONS
from pa10d.investigation.results import NamedEffect

STROKES = {"kind": "reversals", "parameters": {"joints": [4]}}


def test_each_doubt_gets_its_plan_and_its_motion(tmp_path):
    (tmp_path / FOLDER).mkdir()
    (tmp_path / FOLDER / "1-of-before.yaml").write_text("")
    findings = [parsed(NamedEffect, one) for one in (finding(), finding(STROKES))]
    none, way = write_doubts("pa10-sim", findings, tmp_path)
    assert none is None
    assert way.problem == ""
    assert "could also be Coulomb friction in joint 4" in way.says
    assert {path.name for path in (tmp_path / FOLDER).iterdir()} == {way.plan, way.motion}
    plan = (tmp_path / FOLDER / way.plan).read_text(encoding="utf-8")
    assert plan.startswith(f"# {way.says}\n")
    assert yaml.safe_load(plan) == STROKES
    rows = np.loadtxt(tmp_path / FOLDER / way.motion, delimiter=",", skiprows=1)
    assert rows[-1, 0] <= way.seconds, "without the way to it"
    assert np.ptp(rows[:, 4]) > 0.1
    (kept,) = json.loads((tmp_path / MOTIONS).read_text())
    assert (kept["kind"], kept["purpose"]) == ("reversals", "settle")
