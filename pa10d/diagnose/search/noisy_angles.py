"""Findings that noise of the angles alone asks for.

Noise of an encoder is in the columns of a fit and in what it leaves over, on either side of a
split: an effect whose columns hold the same derivatives takes part of it, on new data, too. How
much, the same noise once more on the same motion shows, seen through the model without the finding
and with it. Where that is most of what the finding took, it is no effect of the arm.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from pa10d.diagnose.constants import OF_NOISE
from pa10d.diagnose.search.steps import Search
from pa10d.diagnose.search.versions import held_out, versions_of
from pa10d.judgement import RunResidual
from pa10d.judgement.noise import made_by_angles
from pa10d.judgement.scores import scores
from pa10d.model import Term, TorqueModel


def none_of_noise(search: Search, given: TorqueModel, as_given: Sequence[RunResidual]) -> None:
    """Drop those of which noise of the angles makes most of what they take.

    as_given: the held-out side as the given model saw it
    """
    if not any(np.any(run.of_angles[0]) for run in as_given):
        return
    while len(search.state.terms) > search.fixed:
        state = search.state
        seen = [held_out(m, state) for m in versions_of(given, state, search.fixed, as_given)]
        found = list(enumerate(state.terms))[search.fixed :]
        of_noise = [
            index
            for (index, term), (before, after) in zip(found, pairwise(seen), strict=True)
            if _of_noise(term, before, after)
        ]
        if not of_noise:
            return
        for index in reversed(of_noise):
            state.drop(index)
        search.settle()


def _of_noise(term: Term, before: Sequence[RunResidual], after: Sequence[RunResidual]) -> bool:
    """Judged on the joint of which a finding takes most; between two models, one without it."""
    was, now = scores(before).rms ** 2, scores(after).rms ** 2
    joints = list(term.joints) or list(range(len(was)))
    joint = max(joints, key=lambda j: 1.0 - now[j] / was[j])
    took = float(was[joint] - now[joint])
    made = [made_by_angles(runs, joint)[0] ** 2 for runs in (before, after)]
    return made[0] - made[1] > OF_NOISE * max(took, 0.0)
