"""Random effects of a size that shows: what test data hides in the simulated arm."""

from __future__ import annotations

from typing import Any

import numpy as np

from backends.virtual.datasets.draw_mechanics import MECHANICS
from backends.virtual.datasets.draw_rubbing import RUBBING
from backends.virtual.datasets.draw_senses import SENSES
from backends.virtual.datasets.figures import Draw, Figures, Rng
from backends.virtual.plant.laws import laws
from pa10d.common.jsonable import JsonObject

DRAWS: dict[str, Draw] = {**RUBBING, **MECHANICS, **SENSES}


def random_effect(rng: Rng, effect: str, robot: Figures) -> JsonObject:
    """One entry for the ``effects`` option: joint and parameters of a size that can be seen."""
    draw = DRAWS[effect] if effect in DRAWS else laws()[effect].draw
    drawn = {k: _plain(v) for k, v in draw(rng, robot).items()}
    return {"effect": effect, **drawn}


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic):
        value = value.item()
    return float(f"{value:.4g}") if isinstance(value, float) else value
