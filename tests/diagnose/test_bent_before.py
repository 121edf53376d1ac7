"""How bristles were bent before a recording began is nobody's to know, and no model's error."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from two_links import recordings, textbook

from pa10d.judgement import MASK, mask_of, run_residual
from pa10d.model import Term

WAY, CARRIED = 0.4, 3.0  # rad, N·m


def test_friction_as_the_run_found_it_is_not_judged():
    """A joint that rested for 0.7 s "kept 5.8 times its floor, what the library has not"."""
    runs = recordings(4)
    plain, run = textbook(runs), runs["valid_a"]
    bristles = Term("presliding_hysteresis", (0,), np.array([CARRIED]), {"zs": WAY})
    model = replace(plain, terms=(*plain.terms, bristles))
    slid = np.cumsum(np.abs(np.diff(run.q[:, 0], prepend=run.q[0, 0])))
    bent = CARRIED * np.exp(-slid / WAY)  # at first, all the way
    seen = run_residual(model, run).seen
    found = run_residual(
        model, replace(run, tau=model.sensed(seen) + np.outer(bent, np.array([1.0, 0.0])))
    )
    error = np.abs(found.error[:, 0])
    assert error[found.counts[:, 0]].max() < 0.02 * CARRIED
    assert error[found.judged[:, 0]].max() < 0.02 * CARRIED
    without = run_residual(plain, run)
    assert mask_of([without]) == MASK
    assert mask_of([without, found]) == f"{MASK}, joint 1 once its bristles have slid"
    assert error[without.judged[:, 0]].max() > 0.1 * CARRIED
    assert np.array_equal(found.judged[:, 1], without.judged[:, 1])
    later = slid[:: found.equation.lowpass.factor] > 8.0 * WAY
    assert np.array_equal(found.judged[later, 0], without.judged[later, 0])
