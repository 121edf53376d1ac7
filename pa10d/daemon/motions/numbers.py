"""What every motion of the daemon has: a number of its own, and bounds of patience."""

from __future__ import annotations

import itertools

NUMBERS = itertools.count(1)
SHIFTED = 1e-3  # rad between the pose that was checked and the one that is held
STOPPED = 60.0  # s for the arm to come to rest: 14/ω of a servo of 0.1 Hz, twice and more
