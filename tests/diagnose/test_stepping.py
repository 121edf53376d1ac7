"""Friction or an offset that changes at one moment is told as that, and as no warming up."""

from __future__ import annotations

import numpy as np
import pytest
from bare_sides import ar1
from two_links import recordings, state_of, textbook

from pa10d.diagnose.procedure import diagnose
from pa10d.diagnose.unknown.stepping import steps_in_time
from pa10d.report.finding_section import Asked
from pa10d.report.unexplained_section import unexplained_section
from pa10d.report.verdict import headline

AT, JOINT = 6.0, 1


def let_go(t, q, dq, ddq):
    """A brake's 1 N·m until it lets go."""
    return np.outer((t < AT) * np.tanh(dq[:, JOINT] / 0.01), [0.0, 1.0])


def warming(t, q, dq, ddq):
    """Friction of 1 N·m that goes as it warms."""
    return np.outer(np.exp(-t / AT) * np.tanh(dq[:, JOINT] / 0.01), [0.0, 1.0])


def slipped(t, q, dq, ddq):
    return np.outer(t >= AT, [0.8, 0.0])


def asked(runs):
    return diagnose(
        textbook(runs), [runs["fit_a"], runs["fit_b"]], [runs["valid_a"], runs["valid_b"]]
    )


@pytest.mark.by_default("slipped")
@pytest.mark.parametrize(("change", "joint"), [(let_go, 1), (slipped, 0)])
def test_when_and_where_it_changes_is_found(change, joint):
    (step,) = steps_in_time(state_of(recordings(12, change)), [0, 1])
    assert (step.joint, step.runs) == (joint, ())
    assert step.seconds == pytest.approx(AT, abs=0.2)
    assert step.share > 0.98


@pytest.mark.long
@pytest.mark.by_default("fit_a")
@pytest.mark.parametrize(("name", "other"), [("fit_a", "fit_b"), ("fit_b", "fit_a")])
def test_a_fitted_run_without_it_is_no_part_of_it(name, other):
    """Whichever of the others' two states that run is in."""
    runs = {**recordings(12, let_go), other: recordings(12)[other]}
    (step,) = steps_in_time(state_of(runs), [0, 1])
    assert (step.joint, step.runs) == (JOINT, (name, "valid_a", "valid_b"))
    assert step.seconds == pytest.approx(AT, abs=0.2)
    assert step.share > 0.98


@pytest.mark.by_default("0.99")
@pytest.mark.parametrize("phi", [0.0, 0.99, 0.9995])
def test_no_noise_changes_at_one_moment(phi):
    runs = recordings(41, colour=lambda rng, samples: ar1(rng, samples, phi))
    assert steps_in_time(state_of(runs), [0, 1]) == []


@pytest.mark.long
def test_what_is_there_from_the_beginning_is_no_step():
    """An offset of a real arm changed "at t = 2.55 s of every run", as early as was looked."""
    runs = recordings(12, lambda t, q, dq, ddq: np.outer(np.ones(len(t)), [0.8, 0.0]))
    assert steps_in_time(state_of(runs), [0]) == []


def test_what_changes_in_no_other_run_is_no_step_of_the_joint():
    runs = {**recordings(12), "fit_a": recordings(12, let_go)["fit_a"]}
    assert steps_in_time(state_of(runs), [0, 1]) == []


@pytest.mark.long
def test_it_is_said_with_its_moment_and_not_as_warming_up():
    """It was thermal_friction."""
    found = asked(recordings(12, let_go))
    assert (found.verdict, found.findings) == ("unknown", ())
    (line,) = (one for one in found.remaining if one.significant)
    assert line.joint == JOINT
    assert "its friction or offset changes at t = 6 s of every run, at once" in line.sentence
    said = "of joint 2's squared error is gone if its friction or offset changes at t = 6 s of"
    assert said in headline(found)
    (one,) = found.unexplained
    section = unexplained_section(found, one, None, Asked("m0", ["fit_a", "fit_b"], ["valid_a"]))
    assert section.title == "Joint 2: a change at one moment"


@pytest.mark.long
def test_what_does_warm_up_stays_that():
    (finding,) = asked(recordings(12, warming)).findings
    assert (finding.term.effect_id, finding.term.joints) == ("thermal_friction", (JOINT,))
    assert finding.parameters["T"].value == pytest.approx(AT, rel=0.05)
