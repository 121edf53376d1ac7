"""A dead band of a reading is no friction by place, no contact and no offset."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from two_links import recordings, state_of, textbook

from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.dead_bands import dead_bands, with_dead_bands
from pa10d.diagnose.search.harm import rms
from pa10d.effects import effect
from pa10d.effects.dead_band import DeadBand
from pa10d.effects.registry import all_effects

SIZE = 0.8  # N·m


def swallowed(tau: np.ndarray) -> np.ndarray:
    return np.sign(tau) * np.maximum(np.abs(tau) - SIZE, 0.0)


@cache
def bare(banded: bool) -> SearchState:
    runs = recordings(7)
    if banded:
        runs = {name: replace(run, tau=swallowed(run.tau)) for name, run in runs.items()}
    return state_of(runs, textbook(runs))


def test_it_is_found_with_its_size_and_leaves_noise():
    """Friction by place, a contact and an offset were told of a small servo, and 2.4 times its
    noise was left, where this leaves 1.3 times."""
    state, clean = bare(True), rms(bare(False).held_residual())
    left = rms(state.held_residual())
    assert np.all(left > 2.0 * clean)
    assert np.all(rms(with_dead_bands(state).held_residual()) < 1.3 * clean)
    found = dead_bands(state, [0, 1], left, clean)
    assert sorted(found) == [0, 1]
    for size, share in found.values():
        assert size == pytest.approx(SIZE, rel=0.1)
        assert share > 0.7


def test_what_leaves_no_more_than_noise_is_not_asked():
    state = bare(True)
    left = rms(state.held_residual())
    assert dead_bands(state, [0, 1], left, left) == {}


def test_there_is_none_where_nothing_is_swallowed():
    state = bare(False)
    left = rms(state.held_residual())
    assert dead_bands(state, [0, 1], left, 0.1 * left) == {}


def test_it_is_in_no_list_of_effects():
    assert DeadBand.id not in all_effects()
    assert effect(DeadBand.id).sensing
