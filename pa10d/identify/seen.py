"""The runs as the fit is to see them: in time, behind their torque channel, in the right shapes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from pa10d.identify.blocks import Pieces
from pa10d.identify.channel import FoundChannel, find_channel
from pa10d.identify.first_look import sharpened
from pa10d.identify.late_apart import late_apart
from pa10d.identify.loads import look_through_all, look_through_textbook
from pa10d.identify.shapes import with_starting_shapes
from pa10d.identify.smoothing import Smoothing
from pa10d.identify.timing import Shift, find_shift
from pa10d.identify.told import Errors, refined
from pa10d.regression.layout import Layout


@dataclass(frozen=True)
class SeenRuns:
    """layout: in the shapes that the runs show; smoothing: of the friction sign; shift: of torque
    against position; apart: in words, runs that are late by different times; channel: what the
    torque has passed; told: standard errors of shapes of the effects that were asked for."""

    layout: Layout
    smoothing: Smoothing
    shift: Shift
    apart: str | None
    channel: FoundChannel | None
    told: Errors


def seen_in(
    pieces: Pieces, layout: Layout, with_effects: bool, say: Callable[[float, str], None]
) -> SeenRuns:
    """What the pieces show before anything is fitted; they are moved in time and taken through the
    channel as that says. with_effects: effects were asked for beside the textbook's terms."""
    look_through_textbook(pieces, layout)
    layout = with_starting_shapes(layout, pieces)
    say(0.2, "smoothing speed of the friction sign")
    smoothing, layout = sharpened(pieces, layout)
    say(0.4, "timing of torque against position")
    shift = find_shift(pieces, layout)
    apart = late_apart(pieces.recordings, pieces.robot, layout, pieces.cutoff)
    if shift.seconds != 0.0:
        pieces.shift_by(shift.seconds)
        smoothing, layout = sharpened(pieces, layout)
    say(0.5, "what the torque channel has passed")
    channel = find_channel(pieces, layout, smoothing, shift)
    if channel is not None:
        pieces.pass_through(channel.passed)
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
    layout = look_through_all(pieces, layout)
    return SeenRuns(layout, smoothing, shift, apart, channel, told)
