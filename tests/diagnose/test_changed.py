"""What a model always lacked is no change, however much more of it another motion shows."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from two_links import CUTOFF, motion, recordings, robot, textbook, textbook_torque

from pa10d.diagnose.asked import changed
from pa10d.diagnose.asked.changed import _loses, _there_before, what_changed
from pa10d.diagnose.outcome.diagnosis import Finding
from pa10d.diagnose.procedure import diagnose
from pa10d.dynamics import inverse_dynamics
from pa10d.effects import Value
from pa10d.effects.base import smooth_sign
from pa10d.identify.procedure import identify
from pa10d.measurement.recording import Recording
from pa10d.model import Term

MU, MORE_VISCOUS = 0.12, 0.6


def rubbing(name, seed, wide=1.0, more=0.0):
    """Friction that grows with the load of joint 1; more: N·m·s/rad of friction in joint 2."""
    rng = np.random.default_rng(seed)
    t, q, dq, ddq = motion(seed)
    q, dq, ddq = wide * q, wide * dq, wide * ddq
    load = inverse_dynamics(robot(), robot().parameters, q, dq, ddq)[:, 0]
    tau = textbook_torque(q, dq, ddq) + 0.03 * rng.standard_normal(q.shape)
    tau[:, 0] += MU * np.abs(load) * smooth_sign(dq[:, 0], 0.01)
    tau[:, 1] += more * dq[:, 1]
    return Recording(name, t, q, tau)


@cache
def own():
    """The runs of the model and the model, which lacks that friction."""
    runs = (rubbing("own_a", 1, 0.5), rubbing("own_b", 2, 0.5))
    return runs, identify(list(runs), robot(), name="m0", cutoff=CUTOFF)


@cache
def on_a_day():
    """Runs of another motion, and what would be said of them without the model's own."""
    day = [rubbing("day_a", 3), rubbing("day_b", 4)]
    return day, diagnose(own()[1], day[:1], day[1:], frozen=True)


@pytest.mark.long
def test_a_lack_that_another_motion_shows_more_is_told_as_a_lack():
    runs, model = own()
    day, alone = on_a_day()
    assert alone.verdict != "none", "without its own runs it looks like a change"
    found = what_changed(model, day[:1], day[1:], runs)
    assert found.verdict == "none"
    assert all(line.ratio < 1.2 for line in found.remaining)
    assert found.document()["refitted"], "it is not the model as it was given that leaves so little"
    np.testing.assert_array_equal(found.as_given.rms, alone.as_given.rms)
    assert found.as_given.ratio[0] > 2.0
    (told,) = found.warnings
    assert told.startswith(
        "m0 lacks load_friction J1 on the runs that it was identified from (own_a"
    )


@pytest.mark.long
def test_a_change_is_named_beside_the_lack():
    runs, model = own()
    day = [rubbing("day_a", 3, more=MORE_VISCOUS), rubbing("day_b", 4, more=MORE_VISCOUS)]
    found = what_changed(model, day[:1], day[1:], runs)
    (only,) = found.findings
    assert (only.term.effect_id, only.term.joints) == ("viscous", (1,))
    change = only.parameters["Fv"]
    assert abs(change.value - MORE_VISCOUS) < 3.0 * change.std_error + 0.02
    assert found.beside


@pytest.mark.long
def test_a_lack_that_does_not_hold_on_the_new_data_is_left_out(monkeypatch):
    """As if the lack had been found with the wrong sign: the change is told as without it."""
    runs, model = own()
    day, alone = on_a_day()

    def asked(given, fit, validate=(), **options):
        found = diagnose(given, fit, validate, **options)
        if options.get("frozen"):
            return found
        (lack,) = found.stored[-1:]
        wrong = [
            replace(t, coefficients=-t.coefficients) if t.effect_id == "load_friction" else t
            for t in lack.terms
        ]
        return replace(found, stored=(replace(lack, terms=tuple(wrong)),))

    monkeypatch.setattr(changed, "diagnose", asked)
    found = what_changed(model, day[:1], day[1:], runs)
    assert not found.beside
    assert found.verdict == alone.verdict


@pytest.mark.parametrize(
    ("joint", "again", "lost"), [(2, [], True), (2, [2], False), (5, [], False)]
)
def test_what_a_model_lacked_elsewhere_does_not_hide_a_change(joint, again, lost):
    """Friction of joint 3 that had risen by 1.8 kN·m was told, and not beside joint 6's warming up,
    which the model had lacked: the wider doubt of all had taken it up."""
    rose = diagnosed([joint])
    assert _loses(diagnosed(again), rose, [5]) is lost


@pytest.mark.by_default("0.4-True")
@pytest.mark.parametrize(("always", "there"), [(0.4, True), (0.0, False)])
def test_what_a_model_s_own_runs_have_as_well_has_not_changed(always, there):
    """Bumps of friction that a real arm had all along "now" were there: its own runs knew better,
    and nobody had asked them."""
    runs = recordings(4, lambda t, q, dq, ddq: np.broadcast_to([0.0, always], q.shape))
    own = [runs["fit_a"], runs["fit_b"]]
    model = replace(textbook(recordings(5)), name="m0")
    term = Term("torque_offset", (1,), np.array([0.3]), {})
    before, after = np.array([0.1, 0.4]), np.array([0.1, 0.1])
    size = Value(0.3, 0.01, "N·m")
    said = "Joint 2 now has a torque offset."
    found = Finding(term, {}, before, after, 0.0, 1.0, size, (), None, said)
    told = _there_before(found, model, own)
    assert told.was_there is there
    assert told.sentence.startswith("Joint 2 has a torque offset. No change: on the runs") is there
    assert (told.sentence == said) is not there


def test_what_a_model_s_own_runs_never_touched_is_not_said_to_have_been_there():
    """A stop beyond all angles of the own runs leaves them as they are."""
    runs = recordings(4)
    model = replace(textbook(recordings(5)), name="m0")
    far = float(max(run.q[:, 1].max() for run in runs.values())) + 0.1
    stop = Term("contact", (1,), np.array([5.0]), {"qs": far, "side": 1.0})
    before, after = np.array([0.1, 0.4]), np.array([0.1, 0.1])
    size = Value(0.3, 0.01, "N·m")
    found = Finding(stop, {}, before, after, 0.0, 1.0, size, (), None, "Joint 2 now has a contact.")
    told = _there_before(found, model, [runs["fit_a"]])
    assert told.was_there is None
    assert told.sentence.startswith("Joint 2 has a contact. Whether it came since, the runs that")


def diagnosed(joints):
    return SimpleNamespace(
        findings=[SimpleNamespace(term=SimpleNamespace(joints=(j,))) for j in joints]
    )
