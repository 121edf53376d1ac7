"""How sharply dry friction turns round, where neither identification nor both sides agree on it.

What builds up over a way looks, on fast motion, like a sign that is soft: the fit side pays for a
blunt corner with something else, and slow motion pays it back. So a corner that was open moves only
where what is held out is not worse for it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pa10d.diagnose.constants import MATERIAL_HARM
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.harm import rms
from pa10d.diagnose.search.refining import refine


def with_corners(state: SearchState) -> SearchState:
    """Open corners of the given model as the fit side has them, or where they were: then they are
    known no better than the two sides agree."""
    for index, term in enumerate(state.terms):
        over = term.effect.smoothed_over
        if not over or state.frozen or np.isfinite(term.shape_errors.get(over, np.inf)):
            continue
        moved = turned(state, len(state.terms), index)
        if moved is None:
            continue
        if not _costs(state, moved, term.joints[0]):
            state = moved
            continue
        apart = abs(moved.terms[index].shape[over] - term.shape[over])
        kept = replace(state.terms[index], shape_errors={**term.shape_errors, over: apart})
        state.problem = state.problem.with_term(index, kept)
    return state


def turned(state: SearchState, fixed: int, index: int) -> SearchState | None:
    """A copy with the corner of a term as the fit side has it; None where it stays."""
    trial = state.copy()
    refine(trial, fixed, index)
    return None if trial.terms[index].shape == state.terms[index].shape else trial


def _costs(before: SearchState, after: SearchState, joint: int) -> bool:
    """Is a joint's error on the held-out side larger than it was?"""
    left = [rms(s.held_residual())[joint] for s in (before, after)]
    return bool(left[1] > (1.0 + MATERIAL_HARM) * left[0])
