"""What a joint was told to weigh in one pose, in another one near by.

Masses are wrong, so what is told of one pose is a share of what the description says there, and
the same share holds where the joint went on to. Told as so many N·m more or less, the change along
the way would be the description's, with all that is wrong about it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pa10d.control.joint_figures import ROUGH

Array = NDArray[np.float64]


def carried(torque: Array, there: Array, here: Array) -> Array:
    """N·m (n,) that hold joints ``here``, where ``torque`` held them ``there``: by the description
    the weights of both poses. A share that no masses explain is none, but something besides the
    weight: then it is as much, wherever the joint is."""
    share, masses = share_of(torque, there)
    return np.where(masses, share * here, torque + (here - there))  # what is described stays so


def share_of(torque: Array, described: Array) -> tuple[Array, NDArray[np.bool_]]:
    """(n,) how many times what is described, and whether masses explain as much."""
    share = torque / np.where(described == 0.0, np.inf, described)
    return share, (share >= 1.0 / ROUGH) & (share <= ROUGH)
