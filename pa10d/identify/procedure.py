"""From recordings to the textbook torque model."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import Cancelled
from pa10d.common.parallel import one_thread
from pa10d.dynamics import Robot
from pa10d.identify.advice import warnings_of
from pa10d.identify.blocks import Pieces
from pa10d.identify.cutoff import Cutoff
from pa10d.identify.excitation import excitation
from pa10d.identify.first_look import cut_off
from pa10d.identify.options import FitOptions
from pa10d.identify.outcome import cutoff_note, feasible_note, model_of
from pa10d.identify.prior import Prior
from pa10d.identify.refusals import check, check_length, check_motion, check_speeds
from pa10d.identify.seen import seen_in
from pa10d.identify.solved import solved
from pa10d.measurement.recording import Recording
from pa10d.model import ModelNotes, TorqueModel
from pa10d.model.notes import ShiftNote
from pa10d.regression.layout import textbook
from pa10d.regression.noisy_limits import sharing_limits, torque_ends, with_limits
from pa10d.regression.told import names_of

Array = NDArray[np.float64]


@one_thread()
def identify(
    recordings: Sequence[Recording],
    robot: Robot,
    *,
    name: str,
    options: FitOptions | None = None,
    progress: Callable[[float, str], None] | None = None,
    cancel: Callable[[], bool] | None = None,
    **asked: Any,
) -> TorqueModel:
    """The textbook model (rigid bodies, rotor inertia, Coulomb and viscous friction) of a robot.

    options, or single ones by name: see ``FitOptions``
    progress: called with (share done, what is being done)
    cancel: asked now and then; True raises ``Cancelled``
    """
    options = replace(options or FitOptions(), **asked)
    cutoff, with_effects = options.cutoff, options.with_effects

    def say(share: float, what: str) -> None:
        if progress is not None:
            progress(share, what)

    def tick() -> None:
        if cancel is not None and cancel():
            raise Cancelled("identification was cancelled")

    check(recordings, robot)
    ends = torque_ends(recordings, robot)
    recordings = [with_limits(run, robot) for run in sharing_limits(recordings, robot)]
    slowest = options.faster_than
    speeds = None if slowest is None else check_speeds(slowest, robot)
    say(0.0, "base parameters")
    layout = textbook(robot, with_effects)
    known = Prior.of(layout, options.prior, options.given)
    why: Cutoff | None = None
    if cutoff is None:
        say(0.05, "cut-off")
        why = cut_off(recordings, robot, textbook(robot) if with_effects else layout, tick)
        cutoff = why.hertz
    check_length(recordings, cutoff)
    pieces = Pieces(recordings, robot, layout, cutoff, 0.0, tick, speeds)
    excited = check_motion(excitation(pieces), recordings, speeds)
    seen = seen_in(pieces, layout, bool(with_effects), say)
    solution = solved(pieces, seen, known, options.robust, say)
    fit, feasible, layout = solution.fit, solution.feasible, seen.layout
    contradicted = [*solution.contradicted, *([] if seen.apart is None else [seen.apart])]
    warnings = warnings_of(layout, fit, feasible, seen.smoothing, seen.shift, seen.channel, excited)
    notes = ModelNotes(
        condition_number=pieces.condition_number(),
        warnings=(*contradicted, *warnings),
        cutoff=cutoff_note(cutoff, why),
        shift=ShiftNote(float(seen.shift.estimate), float(seen.shift.std_error)),
        feasible=feasible_note(layout.names()[len(layout.base) :], feasible),
        weights=tuple(map(float, fit.solution.sigma)),
        correlation_s=tuple(map(float, fit.uncertainty.correlation)),
        rank=solution.rank,
        open=tuple(names_of(layout.names(), fit.open)),
        robust=options.robust,
        faster_than=None if speeds is None else tuple(map(float, speeds)),
        prior=None if known is None else known.note(),
        torque_ends=ends,
    )
    say(1.0, "done")
    return model_of(name, seen, fit, feasible, cutoff, recordings, notes)
