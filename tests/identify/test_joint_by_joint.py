"""Sweeps of one joint after the other, around one pose, leave bodies open: they stay what a robot's
file says, and do not run off to what no arm has."""

from __future__ import annotations

import sys
from functools import cache
from pathlib import Path

import numpy as np

from pa10d.dynamics import robot_from_urdf
from pa10d.identify.fit import mostly_known
from pa10d.identify.procedure import identify
from pa10d.judgement import judge
from pa10d.measurement.recording import Recording

sys.path.append(str(Path(__file__).parents[1] / "diagnose"))
import two_links

HEAVIER = two_links.URDF.replace('mass value="4"', 'mass value="5"').replace(
    'mass value="2"', 'mass value="2.5"'
)


@cache
def sweeps() -> Recording:
    """Of each joint in its turn, 0.25 rad about one pose; the torque wanders a little."""
    rng, half = np.random.default_rng(1), 15.0
    t = np.arange(round(2 * half * two_links.RATE)) / two_links.RATE
    q, dq, ddq = np.tile((0.4, 0.7), (len(t), 1)), np.zeros((len(t), 2)), np.zeros((len(t), 2))
    w, slow = 2 * np.pi * 0.8, np.pi / half
    for j in range(2):
        there = (t >= j * half) & (t < (j + 1) * half)
        u = t[there] - j * half
        a, da = np.sin(slow * u) ** 2, slow * np.sin(2 * slow * u)
        s, c = np.sin(w * u), np.cos(w * u)
        q[there, j] += 0.25 * a * s
        dq[there, j] = 0.25 * (da * s + a * w * c)
        ddq[there, j] = 0.25 * (
            (2 * slow**2 * np.cos(2 * slow * u) - a * w**2) * s + 2 * da * w * c
        )
    tau = two_links.textbook_torque(q, dq, ddq)
    wander = np.cumsum(rng.standard_normal(tau.shape), axis=0)
    tau += 0.05 * (rng.standard_normal(tau.shape) + wander / wander.std(axis=0))
    return Recording("sweeps", t, q, tau)


@cache
def model():
    return identify([sweeps()], robot_from_urdf(HEAVIER), name="m0", cutoff=two_links.CUTOFF)


def test_what_the_motion_leaves_open_is_the_files():
    m = model()
    assert any(line.startswith("rank lost") for line in m.notes.warnings)
    assert m.notes.rank < len(m.covariance)
    assert "m2" in m.left_open
    error = judge(m, [two_links.recordings()["valid_a"]]).rms
    assert np.all(error < 0.3)  # a mass of nothing left 1.9 and 2.5 N·m


def test_a_joint_is_trusted_by_poses_that_its_own_motion_never_saw():
    assert np.all(np.array(model().notes.weights) < 0.2)


def test_who_knows_more_of_some_direction():
    data = np.diag([100.0, 1e-3])
    assert mostly_known(data, np.eye(2))
    assert not mostly_known(data, np.diag([1.0, 1e-4]))
    other = np.array([[1.0, 0.0, 1.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1e-3]])
    assert mostly_known(other, np.eye(2) * 0.1)  # the first is one with the third
