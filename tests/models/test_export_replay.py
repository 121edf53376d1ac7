"""Exports replayed in their targets on held-out motion: what differs is what the export said."""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest

import pa10d
from pa10d.export.formats import export
from pa10d.face.questions import recordings
from pa10d.measurement.signals import Lowpass
from pa10d.regression.equation import prepare

ROWS = 150  # of the held-out motion that Octave computes


@pytest.fixture(scope="module")
def found(shared_data):
    """A model of a real machine with an offset that MJCF has no place for, and its held-out run."""
    folder = shared_data / "double_pendulum"
    robot = pa10d.load_robot(folder / "robot.urdf")
    train, valid = (pa10d.load_run(folder / f"{name}1.csv", robot) for name in ("train", "valid"))
    made = pa10d.identify(robot, [train], extra=["torque_offset"])
    seen = prepare(recordings([valid])[0], made.inner.robot, made.cutoff_hz).context
    return made.inner, seen


def test_mujoco_gives_the_models_torque_less_what_was_said(found):
    mujoco = pytest.importorskip("mujoco")
    model, seen = found
    made = export(model, "mjcf", motions={"valid": seen})
    assert "torque_offset" in " ".join(made.not_carried)
    arm = mujoco.MjModel.from_xml_string(made.text)
    arm.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_LIMIT
    data = mujoco.MjData(arm)
    expected = model.possible().predict(seen)
    rows = np.arange(len(seen.q))
    replayed = np.empty((len(rows), model.robot.n))
    for at, k in enumerate(rows):
        data.qpos, data.qvel, data.qacc = seen.q[k], seen.dq[k], seen.ddq[k]
        mujoco.mj_inverse(arm, data)
        replayed[at] = data.qfrc_inverse
    lowpass = Lowpass(len(rows), (len(rows) - 1) / (seen.t[-1] - seen.t[0]), model.cutoff)
    within = slice(lowpass.settle, -lowpass.settle)
    left = np.sqrt(np.mean(lowpass(replayed - expected)[within] ** 2, axis=0))
    assert left == pytest.approx(made.loss.rms, rel=0.25, abs=0.01)
    assert left.max() < 0.1, "MuJoCo's usual friction left 0.15"
    fast = np.abs(seen.dq[rows]).min(axis=1)  # no reversal near
    away = replayed[fast > 0.5] - expected[rows][fast > 0.5]
    assert away.std(axis=0).max() < 0.01


@pytest.mark.skipif(shutil.which("octave-cli") is None, reason="no Octave on this machine")
def test_octave_gives_the_models_torque(found, tmp_path):
    model, seen = found
    made = export(model, "matlab", motions={"valid": seen})
    assert made.loss is None
    called = made.text.split("= ", 1)[1].split("(", 1)[0]
    (tmp_path / f"{called}.m").write_text(made.text)
    rows = np.linspace(0, len(seen.q) - 1, ROWS).astype(int)
    table = np.hstack([seen.q[rows], seen.dq[rows], seen.ddq[rows]])
    np.savetxt(tmp_path / "motion.txt", table, fmt="%.17g")
    n = model.robot.n
    parts = ", ".join(f"x(k,{i * n + 1}:{(i + 1) * n})" for i in range(3))
    script = (
        f"x = load('motion.txt'); for k = 1:rows(x) tau = {called}({parts});"
        'printf("%.17g ", tau(:)); printf("\\n"); end'
    )
    said = subprocess.run(
        ["octave-cli", "--eval", script], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    replayed = np.array([[float(v) for v in line.split()] for line in said.stdout.splitlines()])
    expected = model.possible().predict(replace(seen, apart=True))[rows]  # as one call each
    np.testing.assert_allclose(replayed, expected, rtol=1e-9, atol=1e-9)
