"""Changes of models that always lacked something, or that have what has changed already."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from small_machines import machine
from test_changes import CHANGES, asked
from two_links import recordings, textbook

from pa10d.diagnose.procedure import diagnose
from pa10d.diagnose.search.frozen import always_lacked
from pa10d.effects import effect
from pa10d.identify.procedure import identify
from pa10d.measurement.recording import Recording

MADE_FROM = ("sin_sin_kp200", "up_and_down_kp200", "sin_time_square_kp400")
SINCE = ("sin_time_square_kp200", "sin_sin_kp400")
ROSE = 0.224  # N·m


@pytest.mark.long
def test_what_a_model_leaves_open_of_its_own_is_not_open_of_a_change():
    """Both have one name: a base that leant by 0.037 ± 0.003 rad more was "not determined", since
    the tilt that the model had already was, and the search dropped it."""
    torque = CHANGES["coulomb rose"][-1]
    model = textbook(recordings(4))
    model = replace(model, notes=model.notes.with_open(["coulomb J2: Fc"]))
    found = asked(model, recordings(3, lambda t, q, dq, ddq: torque(dq)))
    (finding,) = found.findings
    assert (finding.term.effect_id, finding.term.joints) == ("coulomb", (1,))
    assert finding.parameters["Fc"].determined


@pytest.mark.parametrize(
    ("kind", "leaves", "lacked"),
    [("spring", 0.09, False), ("stribeck", 0.06, True), ("stribeck", 0.36, False)],
)
def test_only_a_bent_law_poses_as_what_a_model_always_lacked_and_no_larger(kind, leaves, lacked):
    """A spring of 0.36 N·m, where 0.034 had been lacking, was not even looked for."""
    given = SimpleNamespace(floor=SimpleNamespace(values=np.array([0.006])), rms=np.array([leaves]))
    model = SimpleNamespace(noise=np.array([0.034]))
    assert always_lacked(effect(kind), (0,), model, given) == lacked


def rubbed(run: Recording) -> Recording:
    """The servo's run with more dry friction."""
    speed = np.gradient(run.q[:, 0]) * run.rate
    return Recording(run.name, run.t, run.q, run.tau + ROSE * np.tanh(speed / 0.05)[:, None])


@pytest.mark.long
def test_what_one_change_alone_explains_better_is_not_told_as_another():
    """More dry friction of a real servo was "a torque gain", and under it stood that friction alone
    takes more: a model that is moved within a wide doubt had taken up half of it."""
    robot, runs = machine("bam_xl330", [f"xl330_{name}.csv" for name in (*MADE_FROM, *SINCE)])
    model = identify(runs[: len(MADE_FROM)], robot, name="m0")
    fit, judge = map(rubbed, runs[len(MADE_FROM) :])
    found = diagnose(model, [fit], [judge], frozen=True)
    (finding,) = found.findings
    assert finding.term.effect_id == "coulomb"
    assert abs(finding.parameters["Fc"].value - ROSE) < 0.15 * ROSE
    assert found.stood == ""
