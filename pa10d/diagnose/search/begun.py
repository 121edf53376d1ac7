"""What a search begins with: the model as it is and refitted, and both sides of the runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.regression.sides import two_sides
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.search.harm import rms
from pa10d.diagnose.search.versions import held_out
from pa10d.judgement import (
    Judgement,
    RunResidual,
    in_band,
    judged,
    of_own_runs,
    with_known_floor,
)
from pa10d.measurement.recording import Recording
from pa10d.model import TorqueModel
from pa10d.regression.noisy_limits import sharing_limits

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Begun:
    """A model and its runs, ready to be searched.

    whole   the model with all of its band; model: in the band of the search
    fit     recordings that are fitted to; judged_on: in words, what is held out
    state   the model fitted to them, unless it is frozen; given: how many of its terms it had
    moved   (n,) N·m RMS that ``state`` leaves held out as it begins
    as_given, error   the held-out side as the model sees it, before anything is refitted, and how
            it is judged by that
    """

    whole: TorqueModel
    model: TorqueModel
    fit: Sequence[Recording]
    judged_on: str
    state: SearchState
    given: int
    moved: Array
    as_given: list[RunResidual]
    error: Judgement


def begin(
    model: TorqueModel,
    fit: Sequence[Recording],
    validate: Sequence[Recording],
    frozen: bool = False,
    none_at_least: bool = False,
) -> Begun:
    """validate: recordings to judge by; none: parts of the others are held out; none_at_least:
    friction and rotor inertia are held at nothing where a fit wants less."""
    whole, model = model, in_band(model)
    fit, validate = _sharing_limits(fit, validate, model)
    train, held, words = two_sides(model, fit, validate)
    state = SearchState.start(model, train, held, frozen, none_at_least=none_at_least)
    as_given = held_out(model, state)
    error = with_known_floor(judged(model.name, as_given), of_own_runs([whole], model.cutoff))
    moved = rms(state.held_residual())
    return Begun(whole, model, fit, words, state, len(state.terms), moved, as_given, error)


def _sharing_limits(
    fit: Sequence[Recording], held_out: Sequence[Recording], model: TorqueModel
) -> tuple[list[Recording], list[Recording]]:
    """Both sides are of one arm: what ends a torque in one ends it in the other."""
    both = sharing_limits([*fit, *held_out], model.robot, model.notes.torque_ends)
    return both[: len(fit)], both[len(fit) :]
