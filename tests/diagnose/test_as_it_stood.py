"""A frozen model whose doubt is wide takes a payload up in silence: it is said what it had left."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from test_between_runs import more_mass
from two_links import recordings, textbook

from pa10d.diagnose.outcome.words import none_found
from pa10d.diagnose.procedure import diagnose
from pa10d.diagnose.unknown.as_it_stood import left_far_more, stood_words

DOUBT = 1e7
"""Of the covariance: as wide as after a short run of an arm that lacks much."""


def changed_since(change, doubt):
    runs = recordings(5, change)
    model = textbook(recordings(4))
    model = replace(model, covariance=doubt * model.covariance)
    fit, held = [runs["fit_a"], runs["fit_b"]], [runs["valid_a"], runs["valid_b"]]
    return diagnose(model, fit, held, frozen=True)


@pytest.mark.long
def test_a_payload_within_the_doubt_of_a_model_is_told_as_what_would_do_alone():
    found = changed_since(more_mass, DOUBT)
    assert (found.verdict, found.findings) == ("none", ())
    said = none_found(found)
    assert said.startswith("Whether something has changed this data cannot say: as it was given ")
    assert "; a payload (mass about 0.8 kg, " in said
    assert ") alone, all else as it was, takes more than 99 % of it" in said
    assert "joints 1 and 2" in said


@pytest.mark.long
@pytest.mark.parametrize(
    ("change", "doubt"), [(None, DOUBT), pytest.param(more_mass, 1.0, marks=pytest.mark.long)]
)
def test_nothing_is_said_where_nothing_changed_or_the_change_is_named(change, doubt):
    found = changed_since(change, doubt)
    assert found.stood == ""
    named = [finding.term.effect_id for finding in found.findings]
    assert named == ([] if change is None else ["payload"])


def test_a_model_is_not_moved_to_suit_a_slow_drift():
    """Moved within a wide doubt to suit a run that drifts it left 0.2 and 0.03 N·m of the next one,
    of which it had left the noise, 0.013, and lines and changes were of that."""

    def drifts(t, q, dq, ddq):
        return np.column_stack([1.5 * np.sin(0.31 * t), 0.7 * np.sin(0.44 * t + 1.0)])

    model = textbook(recordings(4))
    model = replace(model, covariance=1e4 * model.covariance)
    fit, held = [recordings(5, drifts)["fit_a"]], [recordings(6)["valid_a"]]
    found = diagnose(model, fit, held, frozen=True)
    assert found.findings == ()
    np.testing.assert_array_less(found.left.rms, 1.1 * found.as_given.rms)


def test_an_error_far_above_that_of_the_models_own_runs_is_told():
    """Friction that rose by five times what the model had left: "nothing that was looked for shows
    itself", because the doubt of a model of one short run took up nearly half of it."""
    given, moved, own = np.array([[9.1, 0.8], [5.4, 0.7], [1.8, 1.2]])
    said = stood_words(given, moved, own, np.array([True, False]), {})
    assert said.startswith(
        "as it was given the model leaves 9.1 where it leaves 1.8 on its own runs, and 5.4 moving "
        "within its own doubt, on joint 1; "
    )


@pytest.mark.parametrize(("floor", "told"), [(0.2729, False), (0.2, True), (np.nan, True)])
def test_what_keeps_no_more_than_noise_has_not_been_left_more(floor, told):
    """Of eight clean arms seven were said not to be known to be unchanged, by a joint that left
    8 % more than on the model's own runs and was "explained to the floor"."""
    state = SimpleNamespace(usual=np.array([0.258]), as_given=np.array([0.279]))
    far = left_far_more(state, np.array([0.279]), np.array([0.279]), np.array([floor]))
    assert far.tolist() == [told]


@pytest.mark.long
def test_a_change_no_larger_than_what_the_model_lacked_is_not_called_none():
    """An offset of 0.4 N·m beside 0.3 of noise that it always left: "nothing has changed that this
    data can show", while half of that joint's squared error was one constant."""
    rng = np.random.default_rng(2)

    def slow(samples):
        return np.convolve(rng.standard_normal(samples + 40), np.ones(41), "valid") / 41**0.5

    def lacked(t, q, dq, ddq):
        return np.column_stack([np.zeros(len(t)), 0.3 * slow(len(t))])

    def since(t, q, dq, ddq):
        return lacked(t, q, dq, ddq) + np.array([0.0, 0.4])

    model = textbook(recordings(4, lacked))
    for change, told in ((since, True), (lacked, False)):
        runs = recordings(5, change)
        fit, held = [runs["fit_a"], runs["fit_b"]], [runs["valid_a"], runs["valid_b"]]
        found = diagnose(model, fit, held, frozen=True)
        said = none_found(found)
        assert not found.findings
        assert ("; a torque offset (offset about 0." in said) == told
        assert ("on joint 2; a torque offset" in said) == told
        assert said.startswith("Whether something has changed this data cannot say") == told
        assert ("a torque offset (offset about" in found.remaining[1].sentence) == told
        alone = none_found(diagnose(model, fit, held, frozen=True, only=("torque_offset", (1,))))
        assert alone.startswith("Whether a torque offset came this data cannot say: ") == told
        assert alone.startswith("This data does not show a torque offset; ") != told
