"""The textbook equation of one recording, and which of two readings of it is surely better.

The arm's geometry tells columns that are dealt, signed or scaled wrongly: the textbook model has
the lengths and axes of the URDF, not its masses, and fits a recording best as it should be read.
Only what joints do to each other tells: a joint may have a spring of its own, which on a standing
arm outweighs gravity as if the joint were turned.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri, stdtr

from pa10d.checks.textbook_fit import (
    blocks_of,
    fit_textbook,
    springs,
    steady_sign,
    textbook_columns,
)
from pa10d.dynamics import Robot, base_parameters
from pa10d.measurement.recording import Recording
from pa10d.regression.equation import prepare

Array = NDArray[np.float64]

CUTOFF = 5.0  # Hz
LONGEST = 30.0  # s of the recording that are used
FEWEST = 8  # blocks
BETTER = 0.7  # of what the textbook model leaves, that another reading must come down to
LIKELY = 2.0  # standard errors, over blocks, by which each torque has to agree
SURE = 4.0  # standard errors, over blocks: the 150 questions that order, signs and units of seven
# joints are asked leave one false in 200, by this alone


def middle_of(recording: Recording, longest: float = LONGEST) -> Recording:
    """As much of a recording as geometry is asked of, ``longest`` s."""
    count = min(len(recording.t), int(longest * recording.rate))
    first = (len(recording.t) - count) // 2
    return recording.part(first, first + count, "")


@dataclass(frozen=True)
class TextbookView:
    """Both sides of the textbook equation, with a spring in each joint: columns (M, n, p), tau
    (M, n), which samples count, and the block (M,) that each lies in."""

    columns: Array
    tau: Array
    keep: NDArray[np.bool_]
    blocks: NDArray[np.int64]

    @staticmethod
    def of(part: Recording, robot: Robot, kept: NDArray[np.int64]) -> TextbookView | None:
        """None where there is too little motion."""
        run = prepare(replace(part, dq=None), robot, min(CUTOFF, part.rate / 8))
        columns = np.concatenate([textbook_columns(run, kept), springs(run)], axis=2)
        keep = run.keep & steady_sign(run)
        if keep.sum() < 3 * columns.shape[2]:
            return None
        return TextbookView(columns, run.tau, keep, blocks_of(run))

    def scaled(self, joint: int, factor: float) -> TextbookView:
        """The same with a joint's torque times ``factor``: nothing else depends on it."""
        tau = self.tau.copy()
        tau[:, joint] *= factor
        return replace(self, tau=tau)

    def left(self) -> Array:
        """(blocks, n) sums of squares that the textbook model leaves, each by its torque's size."""
        scale = np.maximum(self.tau.std(axis=0), 1e-9)
        parameters, _ = fit_textbook(self.columns, self.tau, self.keep, 1.0 / scale)
        left = np.where(self.keep, (self.tau - self.columns @ parameters) / scale, 0.0)
        return np.column_stack([np.bincount(self.blocks, of_joint) for of_joint in (left**2).T])


def surely_less(new: Array, old: Array) -> bool:
    """Sums of squares per block."""
    less = len(new) == len(old) and new.sum() <= BETTER * old.sum()
    return bool(less and _errors_less(new, old) > SURE)


def surely_better(new: Array, old: Array, altered: NDArray[np.bool_]) -> bool:
    """Of squares by block and torque (blocks, n). On the whole, and likely of each torque that is
    ``altered`` (n,); likely worse of none: what an effect takes from one joint can be more than all
    that another has."""
    if not surely_less(new.sum(axis=1), old.sum(axis=1)):
        return False
    less = np.array([_errors_less(*pair) for pair in zip(new.T, old.T, strict=True)])
    return bool(np.all(less > np.where(altered, LIKELY, -LIKELY)))


def _errors_less(new: Array, old: Array) -> float:
    """Standard errors by which sums of squares per block are less than the old ones; by their
    ratios, because blocks differ widely in size. 0 of too few blocks; of few ones that know their
    own scatter badly, so many of a normal distribution as chance would leave as rarely."""
    seen = (old > 0) & (new > 0)
    if seen.sum() < FEWEST:
        return 0.0
    gain = np.log(old[seen] / new[seen])
    errors = gain.mean() / max(gain.std(ddof=1) / np.sqrt(len(gain)), 1e-300)
    return float(-np.sign(errors) * ndtri(stdtr(len(gain) - 1, -abs(errors))))


def squares_left(part: Recording, robot: Robot) -> Array:
    """Per block what the textbook model leaves of all torques, each joint by its torque's size;
    empty where there is too little motion."""
    view = TextbookView.of(part, robot, base_parameters(robot).kept)
    if view is None:
        return np.empty(0)
    left = view.left().sum(axis=1)
    return left if len(left) >= FEWEST else np.empty(0)
