"""What an investigation says is whole: whose figure, with which unit, and what was only chosen."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
from made_up import SET, investigation

from pa10d.compare.comparison import RunScores
from pa10d.diagnose.unknown.claims import Unnamed
from pa10d.effects import Value
from pa10d.identify.summary import FitSummary
from pa10d.investigation import course
from pa10d.investigation.results import LastWord
from pa10d.investigation.words import (
    compared_words,
    fall_words,
    fit_notes,
    found_words,
    identified_words,
    left_words,
    units_of,
)
from pa10d.judgement import NoiseFloor
from pa10d.model import Term

JUDGED = LastWord(
    fresh=True, seen="no fit has seen", runs=["r"], models=["a", "b"], before=[1.0, 0.2],
    after=[0.25, 0.4], noise_floor=[None, 0.1], cutoff_hz=10.0, mask="all", units=["N", "N·m"],
    run_names=["fresh"],
)  # fmt: skip


def test_an_error_that_falls_has_the_unit_of_its_joint():
    assert fall_words(JUDGED) == (
        "The error of joint 1 falls from 1 to 0.25 N on runs that no fit has seen "
        "(fresh; low-pass 10 Hz, all). "
        "That of joint 2 rises from 0.2 to 0.4 N·m."
    )
    old = fall_words(replace(JUDGED, run_names=[]))
    assert "no fit has seen (low-pass 10 Hz, all)." in old
    assert "to 0.25 N·m on" in fall_words(replace(JUDGED, units=[])), "kept without them"


def test_an_error_of_a_torque_that_is_known_nowhere_is_no_fall():
    """A real arm's headline was of a joint whose current was never seen."""
    assert "joint 1 falls" not in fall_words(replace(JUDGED, hidden=[1]))
    assert fall_words(replace(JUDGED, hidden=[1, 2])).startswith("No joint's torque is known on")


def test_what_a_joint_keeps_on_fresh_motion_is_said_with_its_place():
    """Ten times its noise stood in a table without a word."""
    where = (SimpleNamespace(joint=1, sentence="Joint 2 below 0.01 rad/s carries 89 %"),)
    robot = SimpleNamespace(torque_unit=lambda j: ("N", "N·m")[j])
    pooled = SimpleNamespace(where=where)
    said = left_words({0: 0.25, 1: 0.4}, np.array([2.5, 4.0]), pooled, robot)
    assert said == [
        "Joint 1 keeps 0.25 N there, 2.5 times its noise floor.",
        "Joint 2 keeps 0.4 N·m there, 4.0 times its noise floor. "
        "Joint 2 below 0.01 rad/s carries 89 %.",
    ]
    assert fall_words(replace(JUDGED, left=said)).endswith(" ".join(said))
    assert fall_words(replace(JUDGED, models=["a"], left=said)).endswith(" ".join(said))


def found(*terms, parameters, **more):
    """A diagnosis, as far as its words go."""
    findings = [
        SimpleNamespace(term=term, parameters=sizes, was_there=False)
        for term, sizes in zip(terms, parameters, strict=True)
    ]
    told = {"verdict": "missing", "frozen": False, "unexplained": (), "lacked": (), "only": ""}
    told |= {"contradicted": (), "misplaced": (), "stood": ""}
    left = SimpleNamespace(mask="in motion")
    told |= {"findings": findings, "judged_on": "valid", "cutoff": 12.0, "left": left}
    return SimpleNamespace(**(told | more))


STRIBECK = Term("stribeck", (3,), np.ones(1))
SIZE = {"Fs": Value(2.0, 0.01, "N·m")}
JUDGED_ON = "Judged on valid; low-pass 12 Hz, in motion."


def test_what_was_chosen_has_no_error():
    said = found_words(found(STRIBECK, parameters=[SIZE | {"ratio": Value(1.0, 0.0, "1")}]))
    assert said == (
        "Missing in the model: Stribeck friction in joint 4. Fs = 2 ± 0.01 N·m, ratio = 1. "
        + JUDGED_ON
    )


def test_of_several_effects_each_figure_has_its_owner():
    other = Term("torque_offset", (1,), np.ones(1))
    offset = {"offset": Value(0.5, 0.1, "N·m"), "open": Value(1.0, 3.0, "1", determined=False)}
    said = found_words(found(STRIBECK, other, parameters=[SIZE, offset], unexplained=(1,)))
    assert said.endswith(
        " Stribeck friction in joint 4: Fs = 2 ± 0.01 N·m."
        " Torque offset in joint 2: offset = 0.5 ± 0.1 N·m."
        f" Something besides is left that no effect of the library explains. {JUDGED_ON}"
    )


def test_what_a_model_always_lacked_has_not_changed_here_either():
    """The sentence had a second place, which did not know what the model lacked before."""
    place = Unnamed(0, 0.4, 0.1, 1e-9, "motion", ("dq1",))
    asked = {"verdict": "unknown", "frozen": True, "unexplained": (place,)}
    said = found_words(found(parameters=[], lacked=(0,), **asked))
    assert said.startswith("The model keeps an error that it had before: something is missing")
    said = found_words(found(parameters=[], **asked))
    assert said.startswith("Something has changed that no effect of the library explains: 40 %")


def test_the_ratio_to_the_noise_says_through_which_model_it_is_seen():
    floor = NoiseFloor(np.array([0.1, 0.1]), ("standstill",) * 2, np.full(2, 0.05), np.ones(2))
    rms = np.array([0.1, 0.29])
    pooled = RunScores("all", SimpleNamespace(rms=rms, nrmse=rms), floor, ())
    assert compared_words(pooled, "look-m0") == (
        "Worst is joint 2: its error is 2.9 times the noise, as far as look-m0 shows it. "
        "No region stands out."
    )


def test_without_fresh_motion_nothing_is_judged_on_it():
    def title(state):
        return state.step("judge").title

    state = investigation()
    assert title(state) == "Judge it on fresh motion"
    course.left_out(state, state.step("motion-6"), "beyond the budget")
    assert title(state) == "Judge all versions on the runs to judge by"
    assert title(investigation(minutes=5.0)) == "Judge it on fresh motion"
    assert title(investigation(minutes=3.0)) == "Judge all versions on the runs to judge by"
    assert title(investigation(motions=SET[:-1])) == "Judge all versions on the runs to judge by"
    assert title(investigation(motions=[])) == "Judge all versions on the runs to judge by"


def test_errors_of_slides_stand_in_newtons():
    assert units_of({"units": ["N·m", "N", "N"]}) == "N or N·m"
    assert units_of({"units": []}) == "N·m", "an older version wrote none"


def test_a_fit_is_told_in_a_line_and_its_notes_for_who_asks():
    """Of an arm of seven joints they were thirty lines amid the story."""
    fit = FitSummary("m0", "m0", 62, 43, 81.12, 12.0, [0.1], True, ["joint 1 hardly moves", "b."])
    assert identified_words(fit) == (
        "62 base parameters, condition number 81.1, fitted below 12 Hz. "
        "2 notes on it: with the model, and in the report."
    )
    assert fit_notes(fit) == ["Joint 1 hardly moves.", "B."]
    assert "note" not in identified_words(replace(fit, warnings=[]))
