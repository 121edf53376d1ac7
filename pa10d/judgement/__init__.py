"""How large is a model's error on runs? One answer, whoever asks: band, mask and floor named."""

from pa10d.judgement.band import HIGHEST_HZ, band, common_band, in_band
from pa10d.judgement.elsewhere import worse_elsewhere
from pa10d.judgement.judge import (
    MASK,
    MATERIAL,
    Judgement,
    first_and_last,
    judge,
    judge_alike,
    judged,
    mask_of,
    with_known_floor,
    with_one_floor,
)
from pa10d.judgement.noise import NoiseFloor, noise_floor
from pa10d.judgement.one_floor import (
    beside_its_own,
    least_floor,
    of_own_runs,
    or_of_own_runs,
    through,
)
from pa10d.judgement.repeatable import Repeatable, repeatable
from pa10d.judgement.residuals import RunResidual, hidden_in, residual_of, run_residual
from pa10d.judgement.reversing import Reversing, reversing
from pa10d.judgement.scores import Scores, scores
from pa10d.judgement.turning import Turning, turning
from pa10d.judgement.worse import worse

__all__ = [
    "HIGHEST_HZ",
    "MASK",
    "MATERIAL",
    "Judgement",
    "NoiseFloor",
    "Repeatable",
    "Reversing",
    "RunResidual",
    "Scores",
    "Turning",
    "band",
    "beside_its_own",
    "common_band",
    "first_and_last",
    "hidden_in",
    "in_band",
    "judge",
    "judge_alike",
    "judged",
    "least_floor",
    "mask_of",
    "noise_floor",
    "of_own_runs",
    "or_of_own_runs",
    "repeatable",
    "residual_of",
    "reversing",
    "run_residual",
    "scores",
    "through",
    "turning",
    "with_known_floor",
    "with_one_floor",
    "worse",
    "worse_elsewhere",
]
