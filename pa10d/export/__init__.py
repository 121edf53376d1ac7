"""A model for other programs: see ``formats``."""

from pa10d.common.callable_room import answer_calls

answer_calls(__name__, "pa10d.face.model:export")
