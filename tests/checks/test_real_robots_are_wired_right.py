"""Real robots, logged as they are: no joint is said to be turned round, to be another's, or in
another unit; and with one torque of ten in another, that one."""

from __future__ import annotations

import importlib
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy

from pa10d.checks.geometry import check_geometry
from pa10d.checks.order import check_order

sys.path.append(str(Path(__file__).parents[2] / "scripts"))
bench_real = importlib.import_module("bench_real")

ALWAYS = "kuka_lwr4"  # its textbook model lacks most of what moves its wrist


@pytest.mark.long  # a UR10's run below, by default, is one of them
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[] if name == ALWAYS else pytest.mark.long)
        for name in sorted(bench_real.ROBOTS)
    ],
)
def test_every_joint_is_in_its_place(shared_data, name):
    case = bench_real.case(name)
    for run in (*case.train, case.valid):
        assert [f.sentence for f in check_order(run, case.robot)] == []
        assert _said(run, case.robot) == []


def test_nine_blocks_of_a_slow_channel_turn_no_neighbour_round(shared_data):
    """Eight seconds of a UR10, joint 2's torque behind 0.1 s: joint 4's seemed to be turned."""
    case = bench_real.case("ur10")
    run = case.valid
    pole = np.exp(-1.0 / run.rate / 0.1)
    tau = run.tau.copy()
    tau[:, 1], _ = scipy.signal.lfilter(
        [1 - pole], [1, -pole], run.tau[:, 1], zi=pole * run.tau[:1, 1]
    )
    assert _said(replace(run, tau=tau), case.robot) == []
    q = run.q.copy()
    q[:, 1] *= -1.0
    assert _said(replace(run, q=q, dq=None), case.robot) == [("turned", 2)]


@pytest.mark.long
def test_a_forearm_turned_round_is_seen_beside_a_wrist_that_no_textbook_knows(shared_data):
    """An LWR4's: the sum over all joints hardly fell, and nothing was said."""
    case = bench_real.case(ALWAYS)
    tau = case.valid.tau * np.where(np.arange(7) == 3, -1.0, 1.0)
    (found,) = check_geometry(replace(case.valid, tau=tau), case.robot)
    assert (found.code, found.joint) == ("turned", 4)
    assert [mend.field for mend in found.mends] == ["tau4"]


@pytest.mark.by_default("50.0")
@pytest.mark.parametrize("factor", [0.1, 50.0])
def test_one_torque_in_another_unit_is_told_with_what_it_lacks(shared_data, factor):
    """A tenth of the elbow's: nothing was said, and its neighbour's error was "no more than noise"
    for all that the data could say."""
    case = bench_real.case("ur10")
    run = case.valid
    tau = run.tau * np.where(np.arange(6) == 2, factor, 1.0)
    (found,) = check_geometry(replace(run, tau=tau), case.robot)
    assert (found.code, found.joint) == ("torque_scale", 3)
    (mend,) = found.mends
    assert float(mend.unit) == pytest.approx(1.0 / factor, rel=0.25)


def _said(run, robot):
    return [(f.code, f.joint) for f in check_geometry(run, robot)]
