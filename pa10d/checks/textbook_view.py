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
OWN = 5  # columns of each joint's own: rotor, Coulomb and viscous friction, offset, spring
LONGEST = 30.0  # s of the recording that are used
FEWEST = 8  # blocks
BETTER = 0.7  # of what the textbook model leaves, that another reading must come down to; of all
# torques together: the product of their shares
BY_CHANCE = 1.0  # standard error: no more than what is not there shows
LIKELY = 2.0  # standard errors, over blocks, by which each torque has to agree
SURE = 4.0  # standard errors, over blocks: the 150 questions that order, signs and units of seven
# joints are asked, each in two ways, leave one false in 100, by this alone


def middle_of(recording: Recording, longest: float = LONGEST) -> Recording:
    """As much of a recording as geometry is asked of, ``longest`` s."""
    count = min(len(recording.t), int(longest * recording.rate))
    first = (len(recording.t) - count) // 2
    return recording.part(first, first + count, "")


@dataclass(frozen=True)
class TextbookView:
    """Both sides of the textbook equation, with a spring in each joint: columns (M, n, p), tau
    (M, n), which samples count, the block (M,) that each lies in, and (n,) N·m that each joint's
    error is measured by."""

    columns: Array
    tau: Array
    keep: NDArray[np.bool_]
    blocks: NDArray[np.int64]
    scale: Array

    @staticmethod
    def of(
        part: Recording, robot: Robot, kept: NDArray[np.int64], scale: Array | None = None
    ) -> TextbookView | None:
        """None where there is too little motion. scale: another reading's, to be compared with it;
        None: what the model itself leaves."""
        run = prepare(replace(part, dq=None), robot, min(CUTOFF, part.rate / 8))
        columns = np.concatenate([textbook_columns(run, kept), springs(run)], axis=2)
        keep = run.keep & steady_sign(run)
        if keep.sum() < 3 * columns.shape[2]:
            return None
        if scale is not None:
            return TextbookView(columns, run.tau, keep, blocks_of(run), scale)
        size = np.maximum(run.tau.std(axis=0), 1e-9)
        view = TextbookView(columns, run.tau, keep, blocks_of(run), size)
        share = np.sqrt(view.left().sum(axis=0) / np.maximum(keep.sum(axis=0), 1))
        return replace(view, scale=size * np.maximum(share, 1e-6))

    def scaled(self, joint: int, factor: float) -> TextbookView:
        """The same with a joint's torque times ``factor``: nothing else depends on it."""
        tau, scale = self.tau.copy(), self.scale.copy()
        tau[:, joint] *= factor
        scale[joint] *= abs(factor)
        return replace(self, tau=tau, scale=scale)

    def dealt(self, places: list[int]) -> TextbookView:
        """The same with the torque of joint places[j] as joint j's."""
        return replace(self, tau=self.tau[:, places], scale=self.scale[places])

    def drives(self, joint: int) -> bool:
        """Would the friction of a joint drive it, more than none would by chance?"""
        return self.rubs(joint)[0] < -BY_CHANCE

    def rubs(self, joint: int) -> tuple[float, float]:
        """Standard errors by which friction explains a joint's torque, negative where it would
        drive the joint; and the share of the squared error that it leaves."""
        n = self.tau.shape[1]
        rigid = self.columns.shape[2] - OWN * n
        coulomb, viscous = (rigid + kind * n + joint for kind in (1, 2))
        parameters, _ = fit_textbook(self.columns, self.tau, self.keep, 1.0 / self.scale)
        rows = self.keep[:, joint]
        own = self.columns[rows, joint]
        friction = own[:, [coulomb, viscous]] @ parameters[[coulomb, viscous]]
        bare = replace(self, columns=np.delete(self.columns, [coulomb, viscous], axis=2))
        left, without = self.left()[:, joint], bare.left()[:, joint]
        errors = max(_errors_less(left, without), 0.0)
        driven = friction @ own[:, viscous] < 0.0
        return -errors if driven else errors, float(left.sum() / max(without.sum(), 1e-300))

    def left(self) -> Array:
        """(blocks, n) sums of squares that the textbook model leaves, each by its joint's scale."""
        parameters, _ = fit_textbook(self.columns, self.tau, self.keep, 1.0 / self.scale)
        left = np.where(self.keep, (self.tau - self.columns @ parameters) / self.scale, 0.0)
        by_joint = [np.bincount(self.blocks, squares) for squares in (left**2).T]
        return np.column_stack(by_joint).astype(float, copy=False)


def surely_less(new: Array, old: Array) -> bool:
    """Sums of squares per block."""
    less = len(new) == len(old) and new.sum() <= BETTER * old.sum()
    return bool(less and _errors_less(new, old) > SURE)


def likelihood(new: Array, old: Array) -> float:
    """Of squares by block and torque (blocks, n): twice the gain in log-likelihood per sample, the
    noise of every torque being unknown."""
    per_joint = np.maximum([new.sum(axis=0), old.sum(axis=0)], 1e-12)
    return float(np.sum(np.log(per_joint[1] / per_joint[0])))


def ahead(new: Array, other: Array) -> bool:
    """Of squares by block and torque (blocks, n): does one reading surely explain more than
    another?"""
    return len(new) != len(other) or _sure(new, other)


def surely_better(new: Array, old: Array, altered: NDArray[np.bool_]) -> bool:
    """Of squares by block and torque (blocks, n). On the whole, and likely of each torque that is
    ``altered`` (n,); likely worse of none: what an effect takes from one joint can be more than all
    that another has."""
    if len(new) != len(old) or likelihood(new, old) < -np.log(BETTER):
        return False
    if not _sure(new, old):
        return False
    less = np.array([_errors_less(*pair) for pair in zip(new.T, old.T, strict=True)])
    return bool(np.all(less > np.where(altered, LIKELY, -LIKELY)))


def _sure(new: Array, old: Array) -> bool:
    """Of all torques alike, or as one has it that leaves most."""
    seen = (new > 0) & (old > 0)
    gain = np.log(np.where(seen, old, 1.0) / np.where(seen, new, 1.0)).sum(axis=1)
    whole = _errors_less(new.sum(axis=1), old.sum(axis=1))
    return max(_errors(gain[seen.any(axis=1)]), whole) > SURE


def _errors_less(new: Array, old: Array) -> float:
    """Standard errors by which sums of squares per block are less than the old ones; by their
    ratios, because blocks differ widely in size."""
    seen = (old > 0) & (new > 0)
    return _errors(np.log(old[seen] / new[seen]))


def _errors(gain: Array) -> float:
    """Standard errors by which the mean over blocks is above 0. 0 of too few blocks; of few ones
    that know their own scatter badly, so many of a normal distribution as chance would leave as
    rarely."""
    if len(gain) < FEWEST:
        return 0.0
    errors = gain.mean() / max(gain.std(ddof=1) / np.sqrt(len(gain)), 1e-300)
    return float(-np.sign(errors) * ndtri(stdtr(len(gain) - 1, -abs(errors))))


def squares_left(part: Recording, robot: Robot) -> Array:
    """Per block what the textbook model leaves of all torques, each joint by its torque's size;
    empty where there is too little motion."""
    size = np.maximum(part.tau.std(axis=0), 1e-9)
    view = TextbookView.of(part, robot, base_parameters(robot).kept, size)
    if view is None:
        return np.empty(0)
    left = view.left().sum(axis=1)
    return left if len(left) >= FEWEST else np.empty(0)
