"""Recordings in, torque model out: weighted least squares with honest errors."""

from pa10d.common.callable_room import answer_calls
from pa10d.identify.condition import condition_number
from pa10d.identify.options import FitOptions
from pa10d.identify.procedure import identify
from pa10d.identify.summary import summary

__all__ = ["FitOptions", "condition_number", "identify", "summary"]

answer_calls(__name__, "pa10d.face.questions:identify")
