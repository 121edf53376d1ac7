"""What friction of a load hides: as much of it as goes one way only reads as load.

A gear loses more while its motor drives the load than while the load drives the motor (spur, worm
and harmonic drives alike). Half the sum of both losses is friction; half their difference is, to
the last sample, a load that is larger by that share, and the bodies take it in. Of one joint alone
no motion tells it; of an arm, what no other joint contradicts. The difference is anything between
none and half the sum (nothing lost while the load drives, and then the load is less by just the
share of what is read that rubs): uniform, hence the third.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pa10d.regression.layout import Layout
from pa10d.regression.triangle import Triangle

Array = NDArray[np.float64]

UNIFORM = 3.0**-0.5  # RMS of what is anything between 0 and 1


def unseen_load(
    layout: Layout,
    beta: Array,
    factors: Sequence[Triangle],
    indices: Sequence[NDArray[np.int64]],
    sigma: Array,
    inverse: Array,
) -> Array:
    """(p, p) covariance of estimates by what their loads may be larger, all gears alike.

    beta: of the layout; factors[j]: of [columns, torque] of joint j, whose columns belong to
    unknowns indices[j]; sigma (n,) N·m; inverse (p, p) covariance under unit-variance errors
    """
    moved, bodies = np.zeros(len(inverse)), len(layout.base)
    for term, place in zip(layout.terms, layout.places, strict=True):
        if not term.effect.reads_as_load:
            continue
        (j,) = term.joints
        index, columns = indices[j], factors[j].r[:, :-1] / sigma[j]
        carried = np.where(index < bodies, beta[np.minimum(index, bodies - 1)], 0.0)
        share = UNIFORM * max(float(beta[place.start]), 0.0)
        moved += share * inverse[:, index] @ (columns.T @ (columns @ carried))
    return np.outer(moved, moved)
