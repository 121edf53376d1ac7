"""How many joints are down to their noise, as a card of a report has it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def near_noise(ratio: NDArray[np.float64], limit: float, when: str = "") -> tuple[str, str]:
    """(``3 of 7``, what that means) for RMS ÷ noise floor (n,), nan where no noise is known: such
    joints count neither way. when: behind the limit."""
    known = int(np.sum(np.isfinite(ratio)))
    if not known:
        return "–", "noise not known"
    said = f"below {limit:g} × noise{when}"
    if known < len(ratio):
        said += f"; not known of {len(ratio) - known}"
    return f"{int(np.sum(ratio < limit))} of {known}", said
