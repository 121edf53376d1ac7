"""What lies in the knocks of a gap is said to, and nothing is found in them."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from test_remaining import judged
from two_links import recordings, state_of

from pa10d.diagnose.outcome.diagnosis import Diagnosis
from pa10d.diagnose.search import looking
from pa10d.diagnose.search.candidates import scan
from pa10d.diagnose.search.judging import Judging
from pa10d.diagnose.search.looking import evidence_of, holds_clear
from pa10d.diagnose.unknown.among_knocks import AmongKnocks
from pa10d.diagnose.unknown.of_joint import KnownBesides
from pa10d.diagnose.unknown.remaining import remaining
from pa10d.effects import effect


@pytest.mark.parametrize(("rest", "said"), [(0.101, True), (0.2, False)])
def test_it_is_said_where_it_is_all_that_is_left(rest, said):
    """ "What the library has not, or slow noise that was larger there" was said instead."""
    known = KnownBesides(knocks={0: AmongKnocks((1,), 0.85, 0.13, rest)}, undetermined={0: 1.5})
    (line,) = remaining(judged(2.4), [None], [], ["N·m"], known)
    told = (
        "85 % of its squared error lies in the knocks of the gap of joint 2 (13 % of its samples)"
    )
    assert (told in line.sentence) == said
    assert ("Elsewhere it keeps 1.0 times its floor." in line.sentence) == said
    (quiet,) = remaining(judged(1.0), [None], [], ["N·m"], known)
    assert "knocks" not in quiet.sentence


def rubbing_more_beyond(t, q, dq, ddq):
    """A worn spot of joint 1."""
    return np.outer(2.0 * (q[:, 0] > 0.3) * np.tanh(dq[:, 0] / 0.01), [1.0, 0.0])


def outside(state, place):
    """Samples (M, n) per run of either side in which joint 1 is not there."""
    return tuple(
        [
            np.repeat(~place(c.q[:: run.lowpass.factor, :1]), 2, axis=1)
            for run, c in zip(side.runs, side.contexts, strict=True)
        ]
        for side in (state.train, state.held)
    )


@pytest.mark.parametrize(
    ("knocks", "holds"),
    [(lambda q: q > 0.1, False), (lambda q: q < -0.3, True)],
    ids=["where it acts", "elsewhere"],
)
def test_what_is_found_beside_a_gap_holds_clear_of_its_knocks(monkeypatch, knocks, holds):
    """Bristles without a way were found on the joint with the gap, and on its neighbour."""
    state = state_of(recordings(3, rubbing_more_beyond))
    judging = Judging(state, [(effect("position_friction"), (0,))], len(state.terms))
    (spot,) = (j for j in evidence_of(judging, scan(state, judging.suspects)[:1], 1))
    assert spot.acceptable
    assert holds_clear(judging, spot), "there are none"
    clear = state.where(outside(state, knocks))
    monkeypatch.setattr(looking, "clear_of_knocks", lambda state: (clear,))
    assert holds_clear(judging, spot) == holds


@pytest.mark.parametrize(
    ("passed", "thought", "said"),
    [
        ("20 Hz", "", "has passed 20 Hz, or something like it (identification saw none)"),
        ("20 Hz", "10 Hz", "(identification took it for 10 Hz); the model fitted anew"),
        ("", "10 Hz", "took the recorded torque to have passed 10 Hz; beside what is told here it"),
    ],
)
def test_what_the_torque_has_passed_is_told_beside_what_identification_saw(passed, thought, said):
    told = SimpleNamespace(passed=passed, thought=thought, findings=())
    (alone,) = Diagnosis._smoothed(told)
    assert said in alone
    told.findings = ("a gap",)
    (beside,) = Diagnosis._smoothed(told)
    assert said in beside
    assert ("beside all that is told here" in beside) == bool(passed)
