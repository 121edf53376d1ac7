"""What an investigation says is whole: whose figure, with which unit, and what was only chosen."""

from __future__ import annotations

from dataclasses import replace

from made_up import answer, finding

from pa10d.common.jsonable import parsed
from pa10d.investigation.results import LastWord, Searched
from pa10d.investigation.words import fall_words, found_words

JUDGED = LastWord(
    fresh=True, seen="no fit has seen", runs=["r"], models=["a", "b"], before=[1.0, 0.2],
    after=[0.25, 0.4], noise_floor=[None, 0.1], cutoff_hz=10.0, mask="all", units=["N", "N·m"],
)  # fmt: skip


def test_an_error_that_falls_has_the_unit_of_its_joint():
    assert fall_words(JUDGED) == (
        "The error of joint 1 falls from 1 to 0.25 N on runs that no fit has seen. "
        "That of joint 2 rises from 0.2 to 0.4 N·m."
    )
    assert "to 0.25 N·m on" in fall_words(replace(JUDGED, units=[])), "kept without them"


def test_what_was_chosen_has_no_error():
    found = finding()
    found["parameters"]["ratio"] = {"value": 1.0, "std_error": 0.0, "unit": "1"}
    said = found_words(parsed(Searched, answer(found)))
    assert (
        said == "Missing in the model: Stribeck friction in joint 4. Fs = 2 ± 0.01 N·m, ratio = 1."
    )


def test_of_several_effects_each_figure_has_its_owner():
    other = finding() | {"effect": "torque_offset", "joints": [2]}
    other["parameters"] = {"offset": {"value": 0.5, "std_error": 0.1, "unit": "N·m"}}
    said = found_words(parsed(Searched, answer(finding(), other)))
    assert "Stribeck friction in joint 4: Fs = 2 ± 0.01 N·m." in said
    assert "Torque offset in joint 2: offset = 0.5 ± 0.1 N·m." in said
