"""What holds may come behind several names of one direction that do not hold."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from pa10d.diagnose.constants import LEAST_GAIN, PER_JOINT
from pa10d.diagnose.regression.partial import PartialFit
from pa10d.diagnose.search import looking
from pa10d.diagnose.search.candidates import Candidate
from pa10d.effects import all_effects

KINDS = [e for e in all_effects().values() if e.scope == "joint" and not e.seen_by_shared_bodies][
    : PER_JOINT + 3
]


def candidates(gains):
    nothing = np.zeros((1, 1))
    return [
        Candidate(kind, (0,), {}, PartialFit(nothing, np.zeros(1), nothing, np.zeros(1), g, True))
        for kind, g in zip(KINDS, gains, strict=True)
    ]


@pytest.fixture
def judged(monkeypatch):
    """Candidates by falling gain; the one at ``holds`` is acceptable. → good, all that was judged,
    and among how many each was."""

    def look(gains, holds, refused=()):
        found, among = candidates(gains), []

        def judge(_judging, some, count):
            among.extend([count] * len(some))
            return [
                SimpleNamespace(place=(c.effect.id, c.joints), acceptable=c is found[holds])
                for c in some
            ]

        monkeypatch.setattr(looking, "scan", lambda state, suspects: found)
        monkeypatch.setattr(looking, "_open", lambda judging: [])
        monkeypatch.setattr(looking, "_judged", judge)
        good, every = looking.look(SimpleNamespace(state=None), refused)
        return [one.place[0] for one in good], len(every), among

    return look


def test_the_first_shortlist_is_enough_where_one_holds(judged):
    good, count, _ = judged([900.0 - k for k in range(len(KINDS))], 1)
    assert (good, count) == ([KINDS[1].id], PER_JOINT)


def test_what_holds_is_found_behind_what_does_not(judged):
    good, count, among = judged([900.0 - k for k in range(len(KINDS))], PER_JOINT + 1)
    assert (good, count) == ([KINDS[PER_JOINT + 1].id], len(KINDS))
    assert among == [PER_JOINT] * PER_JOINT + [len(KINDS)] * 3, "each pays for all before it"


def test_what_was_refused_is_passed_over(judged):
    refused = {(KINDS[0].id, (0,))}
    good, count, _ = judged([900.0 - k for k in range(len(KINDS))], 0, refused)
    assert (good, count) == ([], len(KINDS))


def test_where_the_fit_side_does_not_speak_for_any_more_it_ends(judged):
    gains = [900.0] * PER_JOINT + [0.9 * LEAST_GAIN] * 3
    assert judged(gains, PER_JOINT)[:2] == ([], PER_JOINT)
