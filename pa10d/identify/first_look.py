"""What has to be known of the data before a fit: the band, how sharp friction turns, how late
torque is; and all three of one recording, for whoever asks before anything is identified."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.common.parallel import one_thread
from pa10d.dynamics import Robot
from pa10d.identify.blocks import Pieces, middle
from pa10d.identify.cutoff import Cutoff, choose_cutoff, probe_cutoff
from pa10d.identify.excitation import excitation
from pa10d.identify.fit import plain_fit
from pa10d.identify.jackknife import moved_by_stretches, without_each
from pa10d.identify.loads import first_model
from pa10d.identify.refusals import check, check_length, check_motion
from pa10d.identify.rows import rows_of
from pa10d.identify.shapes import with_starting_shapes
from pa10d.identify.smoothing import (
    Smoothing,
    find_smoothing,
    sharp_where_unseen,
    with_smoothing,
)
from pa10d.identify.timing import Shift, find_shift
from pa10d.measurement.recording import Recording
from pa10d.regression.layout import Layout, textbook
from pa10d.regression.solution import estimate_weights, solve
from pa10d.regression.triangle import Triangle

Array = NDArray[np.float64]

LONGEST = 120.0  # s of a recording that are looked at: more does not sharpen the answer


@dataclass(frozen=True)
class FirstLook:
    """shift: how late torque is; braking: (n,) W that friction takes from the motion on average,
    negative where it would drive; braking_error: (n,) W, by how much it differs from stretch to
    stretch, 0 where it brakes."""

    shift: Shift
    braking: Array
    braking_error: Array


@one_thread()
def first_look(recording: Recording, robot: Robot) -> FirstLook | None:
    """What identification would find in one recording; None where it could not begin with it."""
    spare = max(0, len(recording.t) - int(LONGEST * recording.rate)) // 2
    part = recording.part(spare, len(recording.t) - spare, "")
    layout = textbook(robot)
    try:
        check([part], robot)
        cutoff = cut_off([part], robot, layout).hertz
        check_length([part], cutoff)
        pieces = Pieces([part], robot, layout, cutoff)
        check_motion(excitation(pieces), [part])
    except UserError:
        return None
    layout = with_starting_shapes(layout, pieces)
    layout = sharpened(pieces, layout)[1]
    shift = find_shift(pieces, layout)
    if shift.seconds != 0.0:
        pieces.shift_by(shift.seconds)
        layout = sharpened(pieces, layout)[1]
    return FirstLook(shift, *_braking(pieces, layout))


def sharpened(pieces: Pieces, layout: Layout) -> tuple[Smoothing, Layout]:
    """How sharp the friction signs are, and the layout with them."""
    smoothing = sharp_where_unseen(find_smoothing(pieces, layout), pieces.faster_than)
    return smoothing, with_smoothing(layout, smoothing)


def cut_off(
    recordings: Sequence[Recording],
    robot: Robot,
    layout: Layout,
    tick: Callable[[], None] = lambda: None,
) -> Cutoff:
    """From a first fit with a wide band to no more data than the question needs."""
    parts = [middle(r) for r in recordings]
    check_length(parts, probe_cutoff(parts))
    pieces = Pieces(parts, robot, layout, probe_cutoff(parts), 0.0, tick)
    check_motion(excitation(pieces), parts)
    return choose_cutoff(first_model(pieces, sharpened(pieces, layout)[1]), parts)


def _braking(pieces: Pieces, layout: Layout) -> tuple[Array, Array]:
    """(n,) W, of what the model has of each joint's friction, and its error where it drives."""
    contexts = [piece.context for piece in pieces.some()]
    samples = max(sum(len(c.dq) for c in contexts), 1)

    def braking(beta: Array) -> Array:
        rubs = [t for t in layout.fitted(beta) if not t.effect.is_rotor]
        power = [np.sum(sum(t.torque(c) for t in rubs) * c.dq, axis=0) for c in contexts]
        return np.asarray(np.sum(power, axis=0) / samples)

    found = braking(plain_fit(pieces, layout))
    error = np.zeros(layout.robot.n)
    if np.any(found < 0.0):
        rows = [rows_of(piece, layout) for piece in pieces.some()]
        without = without_each(rows, lambda rest: braking(_solved(rest, layout)))
        error = np.array([moved_by_stretches(of_joint) for of_joint in without.T])
    return found, np.where(found < 0.0, error, 0.0)


def _solved(triangles: list[Triangle], layout: Layout) -> Array:
    none = [Triangle(t.width) for t in triangles]
    sigma = estimate_weights(triangles, none, layout.of_joint, layout.size)
    return solve(triangles, layout.of_joint, layout.size, sigma).beta
