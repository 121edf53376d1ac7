"""What has to be known of the data before a fit: the band, how sharp friction turns, how late
torque is; and all three of one recording, for whoever asks before anything is identified."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from pa10d.common.errors import UserError
from pa10d.common.parallel import one_thread
from pa10d.dynamics import Robot
from pa10d.identify.blocks import Pieces, middle
from pa10d.identify.cutoff import Cutoff, choose_cutoff, probe_cutoff
from pa10d.identify.excitation import excitation
from pa10d.identify.loads import first_model
from pa10d.identify.refusals import check, check_length, check_motion
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

LONGEST = 120.0  # s of a recording that are looked at: more does not sharpen the answer


@one_thread()
def first_look(recording: Recording, robot: Robot) -> Shift | None:
    """How late the torque of one recording is, as identification would find it; None where it could
    not begin with it."""
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
    return find_shift(pieces, layout)


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
