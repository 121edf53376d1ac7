"""What two joints share sticks where they stand together, though each of them moves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_remaining import judged
from two_links import recordings, textbook

from pa10d.diagnose.unknown.of_joint import KnownBesides
from pa10d.diagnose.unknown.remaining import remaining
from pa10d.diagnose.unknown.stuck_together import StuckTogether, stuck_together
from pa10d.judgement import run_residual
from pa10d.model import Term

F = 3.0  # N·m


def test_error_at_their_standstill_is_found_there():
    """Error of 0.16 of 0.43 N·m in a fiftieth of the samples made joints keep 2.4 times."""
    runs = recordings(4)
    plain, run = textbook(runs), runs["valid_a"]
    shared = Term("coupling_friction", (0, 1), np.array([F, 0.0]), {"ratio": 1.0, "viscous": 0.0})
    model = replace(plain, terms=(*plain.terms, shared))
    seen = run_residual(model, run)
    speed = np.abs(seen.seen.dq.sum(axis=1))
    sticks = speed < 0.01 * speed.max()
    tau = model.sensed(seen.seen) + 0.02 * np.sin(np.arange(len(run.t)))[:, None]
    tau[:, 0] += F * sticks
    found = stuck_together(model, [run_residual(model, replace(run, tau=tau))])
    assert set(found) == {0, 1}
    assert (found[0].other, found[1].other) == (1, 0)
    assert found[0].share > 0.5 > found[1].share
    judged_rms = np.sqrt(np.mean(run_residual(model, replace(run, tau=tau)).error[:, 0] ** 2))
    assert found[0].rest < 0.5 * judged_rms
    assert stuck_together(plain, [seen]) == {}, "nothing is shared"


@pytest.mark.parametrize(("rest", "said"), [(0.101, True), (0.2, False)])
def test_it_is_said_where_it_is_all_that_is_left(rest, said):
    """ "What the library has not, or slow noise that was larger there" was said instead."""
    known = KnownBesides(together={0: StuckTogether(5, 0.85, rest)})
    (line,) = remaining(judged(2.4), [None], [], ["N·m"], known)
    assert ("shares with joint 6 stands still or turns round" in line.sentence) == said
    assert ("Elsewhere it keeps 1.0 times its floor." in line.sentence) == said
    (quiet,) = remaining(judged(1.0), [None], [], ["N·m"], known)
    assert "shares" not in quiet.sentence
