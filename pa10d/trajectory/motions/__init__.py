"""Motions: what one segment of a plan does. Importing the room makes all of them known."""

from pa10d.trajectory.motions.base import Motion, MotionSamples, motion_from_dict
from pa10d.trajectory.motions.chirp import Chirp
from pa10d.trajectory.motions.entered import Entered
from pa10d.trajectory.motions.fourier import Fourier
from pa10d.trajectory.motions.knots import Drawing, Knots, move_time, ramp_time
from pa10d.trajectory.motions.narrowed import Narrowed
from pa10d.trajectory.motions.sines import Sines
from pa10d.trajectory.motions.slowed import Slowed

__all__ = [
    "Chirp",
    "Drawing",
    "Entered",
    "Fourier",
    "Knots",
    "Motion",
    "MotionSamples",
    "Narrowed",
    "Sines",
    "Slowed",
    "motion_from_dict",
    "move_time",
    "ramp_time",
]
