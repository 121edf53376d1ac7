"""A torque channel gives way to no other that is farther from being as late as torque is."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import pa10d.diagnose.search.channel as search
from pa10d.measurement.torque_filter import FIRST_ORDER, MEAN, TorqueFilter

LATE = 0.008  # s that torque is
KNOWN = TorqueFilter(FIRST_ORDER, 0.010)
NEARER, LATER = TorqueFilter(FIRST_ORDER, 0.0084), TorqueFilter(MEAN, 0.032)


@pytest.fixture
def asked(monkeypatch):
    """What takes the place of a channel that is known, where a mean suits surely best."""
    gains = {KNOWN: 0.0, NEARER: 60.0, LATER: 460.0, TorqueFilter("second order", 0.1): -900.0}
    told = {channel.kind: channel for channel in gains}

    def asking(*_):
        return lambda channel: (np.full(3, gains[channel] / 3.0 + 50.0), np.full(3, 5.0))

    monkeypatch.setattr(search, "clear_of_knocks", lambda state: (state,))
    monkeypatch.setattr(search, "_asking", asking)
    monkeypatch.setattr(
        search,
        "_of_kind",
        lambda kind, *_: (told[kind], (np.full(3, gains[told[kind]] / 3.0), np.full(3, 5.0))),
    )
    monkeypatch.setattr(search, "_as_late", lambda _, each: max(each, key=lambda o: o[1][0].sum()))
    left = iter([np.full((2, 3), 2.0), np.full((2, 3), 1.0)])
    monkeypatch.setattr(search, "made_held_out", lambda _: np.zeros(3))
    monkeypatch.setattr(search, "sizes", lambda *_: next(left))

    def of(known):
        run = SimpleNamespace(shift=LATE, lowpass=SimpleNamespace(cutoff=12.0, channel=known))
        train = SimpleNamespace(runs=[run], n=3)
        return search.behind_channel(
            SimpleNamespace(train=train, frozen=False, behind=lambda channel: channel)
        )

    return of


def test_smoothness_that_a_law_asks_for_makes_no_channel_twice_as_late(asked):
    """Knocks asked for "a mean over 31.9 ms" of a torque that is 8 ms late behind 20 Hz."""
    assert asked(KNOWN) == NEARER


def test_where_none_was_known_the_best_one_is_taken(asked):
    assert asked(None) == LATER


def test_one_that_is_as_late_as_torque_stays(asked):
    assert asked(TorqueFilter(FIRST_ORDER, LATE)) is None
