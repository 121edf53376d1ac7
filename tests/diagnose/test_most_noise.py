"""Noise is no more than what a model leaves on the runs that it was fitted to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from two_links import recordings, textbook

from pa10d.diagnose.regression.sides import two_sides
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.unknown.at_most import most_noise


@pytest.mark.by_default("6.0")
@pytest.mark.parametrize("seconds", [30.0, 6.0])
def test_what_coefficients_took_along_of_it_is_added(seconds):
    """Of six seconds they take a quarter of the noise's power."""
    made = recordings(3)
    whole = textbook(made)
    fit = made["fit_a"].part(0, int(seconds * made["fit_a"].rate), "short")
    state = SearchState.start(whole, *two_sides(whole, [fit], [made["valid_a"]])[:2], False)
    assert most_noise(state) == pytest.approx(whole.noise, rel=0.25)
    assert np.all(most_noise(state) >= state.fit.rms())


def test_a_frozen_model_was_fitted_to_runs_of_its_own():
    made = recordings(3)
    model = replace(textbook(made), noise=np.array([0.5, 0.25]))
    sides = two_sides(model, [made["fit_a"]], [made["valid_a"]])[:2]
    assert most_noise(SearchState.start(model, *sides, True)).tolist() == [0.5, 0.25]
