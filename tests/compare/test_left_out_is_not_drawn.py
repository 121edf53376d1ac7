"""Where a stretch is left out of a run, a fit has a straight line of torque: nobody measured it."""

from __future__ import annotations

import base64

import compare_arm as arm
import numpy as np
import pytest

from pa10d.figures import torque_over_time
from pa10d.judgement import run_residual


@pytest.fixture(scope="module")
def run():
    return run_residual(arm.model(), arm.recording(1, 12.0).without([(4.0, 6.0)]))


@pytest.mark.parametrize("raw", [False, True])
def test_measured_torque_has_a_gap_there_and_the_model_none(run, raw):
    figure = torque_over_time(run, 0, raw=raw)
    time, measured = drawn(figure, "measured")
    inside = (time > 4.1) & (time < 5.9)
    assert np.isnan(measured[inside]).all()
    assert np.isfinite(measured[(time < 3.0) | (time > 7.0)]).all()
    assert np.isfinite(drawn(figure, "model")[1]).all()


def drawn(figure, name):
    """Time and value of a line."""
    (line,) = (one for one in figure["data"] if one["name"] == name)
    kind = {"f4": "<f4", "f8": "<f8"}[line["y"]["dtype"]]
    values = np.frombuffer(base64.b64decode(line["y"]["bdata"]), dtype=kind)
    return line["x0"] + line["dx"] * np.arange(len(values)), values
