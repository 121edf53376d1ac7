"""Which unknowns a fit leaves open though it gives them a number.

A standard error above the value is no sign of it: a friction of 0.001 ± 0.003 N·m beside 10 N·m is
known well enough, it is next to nothing. What counts is the torque that the interval allows. Of
the textbook's own unknowns it is held against the joint's torque over the motion: where it holds
more, other unknowns take it back, and the number says nothing. What was added to explain an error
is held against the error that is left.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pa10d.model import Term
from pa10d.model.names import told_apart

Array = NDArray[np.float64]

INTERVAL = 1.96  # standard errors: half of a 95 % interval


def left_open(
    values: Array, errors: Array, peaks: Array, torque: Array, rest: Array, added: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """(p,) where the standard error exceeds the value and the interval allows more torque than
    there is to explain.

    errors: (p,) standard errors; peaks: (n, p) largest torque of one unit in a sample of each joint
    torque, rest: (n,) N·m RMS of the joints' torque, and of what is left of it
    added: (p,) unknowns beyond the textbook's
    """
    scale = np.where(added, rest[:, None], torque[:, None])
    reach = np.max(peaks / np.maximum(scale, 1e-300), axis=0)
    return np.asarray((errors > np.abs(values)) & (INTERVAL * errors * reach > 1.0))


def added_ones(count: int, terms: Sequence[Term]) -> NDArray[np.bool_]:
    """(p,) of ``count`` base parameters and all coefficients: which are beyond the textbook's."""
    found = [np.zeros(count, dtype=bool)]
    found += [np.full(len(t.coefficients), t.effect.question != "textbook") for t in terms]
    return np.concatenate(found)


def names_of(names: Sequence[str], chosen: NDArray[np.bool_]) -> list[str]:
    """Those that are chosen, each told from one of the same name before it."""
    return [name for name, one in zip(told_apart(names), chosen, strict=True) if one]
