"""What every motion of the daemon has: a number of its own, and bounds of patience."""

from __future__ import annotations

import itertools

NUMBERS = itertools.count(1)
SHIFTED = 1e-3  # rad between the pose that was checked and the one that is held
STOPPED = 15.0  # s for the arm to come to rest
