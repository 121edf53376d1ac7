"""Where does a model fail? Figures of the error, the regions that carry it, its spectra."""

from pa10d.common.callable_room import answer_calls
from pa10d.compare.comparison import Comparison, RunScores, compare
from pa10d.compare.document import document
from pa10d.compare.places import Place, places
from pa10d.judgement import (
    NoiseFloor,
    RunResidual,
    Scores,
    noise_floor,
    residual_of,
    run_residual,
    scores,
)

__all__ = [
    "Comparison",
    "NoiseFloor",
    "Place",
    "RunResidual",
    "RunScores",
    "Scores",
    "compare",
    "document",
    "noise_floor",
    "places",
    "residual_of",
    "run_residual",
    "scores",
]

answer_calls(__name__, "pa10d.face.questions:compare")
