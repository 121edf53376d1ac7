"""Which numbers a sensor may have said: no arithmetic on them leaves what a computer can count."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pa10d.common.errors import UserError

LARGEST = 1e19  # of any unit: stamps in ns since 1970 are less, and fourth powers still numbers
SMALLEST = 1e-60  # N·m: squares of squares of what is less are nothing to a computer
EXPECTED = "a finite number of no more than 1e19"


def believable(values: ArrayLike) -> NDArray[np.bool_]:
    """Of each number; none is that is not finite."""
    return np.asarray(np.abs(np.asarray(values, dtype=np.float64)) <= LARGEST)


def refuse_vanishing(where: str, torque: NDArray[np.float64]) -> None:
    """UserError where that of a joint, of (N, n) N·m, is never more than nothing, and not zero."""
    most = np.abs(torque).max(axis=0, initial=0.0)
    for j in np.flatnonzero((most > 0) & (most < SMALLEST)):
        raise UserError(
            f"{where}: the torque of joint {j + 1} is {most[j]:.3g} N·m at most, expected at least "
            f"{SMALLEST:g} or none at all; was it scaled?"
        )
