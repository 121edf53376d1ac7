"""Errors of a line of models are told in the units of its joints."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from pa10d.cli.model_family import _errors


def test_of_a_slide_they_are_newtons():
    """4.82 N of a feeder's slide were 4.82 N·m."""
    judged = SimpleNamespace(
        rms=np.array([4.82, 0.5]), floor=SimpleNamespace(values=np.array([0.25, np.nan]))
    )
    info = SimpleNamespace(name="m0", id="x", change="textbook model", rms=(4.82, 0.5), runs=("a",))
    lines = _errors(SimpleNamespace(info=info, judgement=judged), "N or N·m")
    assert lines[1:] == ["  error     4.82 0.5 N or N·m", "  noise     0.25 ? N or N·m"]
    (_, fitted) = _errors(SimpleNamespace(info=info, judgement=None), "N or N·m")
    assert fitted == "  fit       4.82 0.5 N or N·m on a"
