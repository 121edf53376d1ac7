"""Where does a model fail, which effect is missing, what changed, and what would settle a doubt."""

from pa10d.common.callable_room import answer_calls

answer_calls(__name__, "pa10d.face.questions:diagnose")
