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
from pa10d.identify.channel import find_channel
from pa10d.identify.cutoff import Cutoff
from pa10d.identify.excitation import excitation
from pa10d.identify.feasibility import find_feasible
from pa10d.identify.first_look import cut_off, sharpened
from pa10d.identify.fit import beside_bodies, trust, weighted_fit, wide_bodies
from pa10d.identify.late_apart import late_apart
from pa10d.identify.loads import look_through_all, look_through_textbook
from pa10d.identify.options import FitOptions
from pa10d.identify.outcome import cutoff_note, feasible_note, model_of
from pa10d.identify.prior import Prior
from pa10d.identify.refusals import check, check_length, check_motion, check_speeds
from pa10d.identify.robust import robust_fit
from pa10d.identify.shapes import with_starting_shapes
from pa10d.identify.timing import find_shift
from pa10d.identify.told import Errors, refined
from pa10d.measurement.recording import Recording
from pa10d.model import ModelNotes, TorqueModel
from pa10d.model.notes import ShiftNote
from pa10d.regression.layout import textbook
from pa10d.regression.noisy_limits import sharing_limits, torque_ends, with_limits
from pa10d.regression.problem import LinearProblem
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
    seen = check_motion(excitation(pieces), recordings, speeds)
    look_through_textbook(pieces, layout)
    layout = with_starting_shapes(layout, pieces)
    say(0.2, "smoothing speed of the friction sign")
    smoothing, layout = sharpened(pieces, layout)
    say(0.4, "timing of torque against position")
    shift = find_shift(pieces, layout)
    apart = late_apart(recordings, robot, layout, cutoff)
    if shift.seconds != 0.0:
        pieces.shift_by(shift.seconds)
        smoothing, layout = sharpened(pieces, layout)
    say(0.5, "what the torque channel has passed")
    channel = find_channel(pieces, layout, smoothing, shift)
    if channel is not None:
        pieces.pass_through(channel)
        smoothing, layout = sharpened(pieces, layout)
        rest = find_shift(pieces, layout)
        pieces.shift_by(rest.seconds)
        shift = shift.later(rest)
    told: Errors = {}
    if with_effects:
        say(0.55, "shapes of the effects that were asked for")
        for _ in range(2 if layout.has_springs else 1):  # whose loads follow their shapes
            layout = look_through_all(pieces, layout)
            layout, told = refined(layout, pieces)
        smoothing, layout = sharpened(pieces, layout)
    say(0.6, "least squares")
    layout = look_through_all(pieces, layout)
    fitted = robust_fit if options.robust else weighted_fit
    bodies = wide_bodies(layout) if known is None else None
    sigma, beside_them = trust(pieces, layout, bodies)
    problem = LinearProblem(layout, sigma=sigma)
    pieces.without_stands()
    fit = fitted(pieces, problem, smoothing)
    rank = fit.solution.rank
    if bodies is not None:
        again = replace(problem, sigma=beside_them)
        fit = beside_bodies(
            fit, bodies, lambda b: fitted(pieces, replace(again, bodies=b), smoothing)
        )
    beside, contradicted = None, []
    if known is not None:
        say(0.75, "least squares with what is known")
        beside, contradicted = known.beside(fit), list(known.contradicted(fit))
        fit = fitted(pieces, replace(problem, prior=beside.whole()), smoothing)
    say(0.9, "feasible parameters")
    feasible = find_feasible(fit, layout, beside)
    contradicted += [] if apart is None else [apart]
    warnings = contradicted + warnings_of(layout, fit, feasible, smoothing, shift, channel, seen)
    notes = ModelNotes(
        condition_number=pieces.condition_number(),
        warnings=tuple(warnings),
        cutoff=cutoff_note(cutoff, why),
        shift=ShiftNote(float(shift.estimate), float(shift.std_error)),
        feasible=feasible_note(layout.names()[len(layout.base) :], feasible),
        weights=tuple(map(float, fit.solution.sigma)),
        correlation_s=tuple(map(float, fit.uncertainty.correlation)),
        rank=int(fit.solution.rank if known else rank),
        open=tuple(names_of(layout.names(), fit.open)),
        robust=options.robust,
        faster_than=None if speeds is None else tuple(map(float, speeds)),
        prior=None if known is None else known.note(),
        torque_ends=ends,
    )
    say(1.0, "done")
    return model_of(
        name, layout, fit, smoothing, feasible, cutoff, shift, channel, recordings, notes, told
    )
