"""Which joints count the other way round, and whose torque is not in N·m at the joint.

The arm's geometry alone tells a sign: the textbook model has the lengths and axes of the URDF, not
its masses, and fits a recording with a joint turned round worse than the same recording with that
joint turned back. Only what joints do to each other tells: a joint may have a spring of its own,
which on a standing arm outweighs gravity as if the joint were turned. Which of two joints is
turned round, where either would do, and what the torque is measured in, the URDF's bodies tell.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri, stdtr

from pa10d.checks.finding import CheckFinding, Mend, joint_label
from pa10d.checks.textbook_fit import (
    blocks_of,
    fit_textbook,
    springs,
    steady_sign,
    textbook_columns,
)
from pa10d.dynamics import Robot, base_parameters, inverse_dynamics
from pa10d.measurement.recording import Recording
from pa10d.regression.equation import prepare

Array = NDArray[np.float64]

CUTOFF = 5.0  # Hz
LONGEST = 30.0  # s of the recording that are used
FEWEST = 8  # blocks
BETTER = 0.7  # of what the textbook model leaves, that a joint turned round must come down to
LIKELY = 2.0  # standard errors, over blocks, by which each torque has to agree
SURE = 4.0  # standard errors, over blocks: 21 questions to seven joints leave one false in 10^3
OFF = 40.0  # times: real URDFs have links that weigh a twentieth of the true ones, not a fortieth
TOLD = 0.5  # of the torque that weight must explain before its size is believed
ALIKE = 1e-3  # share of what is left by which two ways to turn joints are equally good
Way = tuple[int, tuple[int, int]]
"""A joint, and the signs of its q and its tau."""
TURNED = {(-1, 1): ("q", "dq"), (1, -1): ("tau",), (-1, -1): ("q", "dq", "tau")}


def check_geometry(recording: Recording, robot: Robot) -> Iterator[CheckFinding]:
    """Joints that are turned round, and torques that weigh another arm."""
    part = middle_of(recording)
    turned = dict(_turned(part, robot))
    for j, (signs, share) in sorted(turned.items()):
        label = joint_label(j, robot.joint_names)
        what = " and ".join(name for name in TURNED[signs] if name != "dq")
        have = [name for name in TURNED[signs] if name != "dq" or recording.dq is not None]
        turns = tuple(Mend(f"{name}{j + 1}", "-1") for name in have)
        yield CheckFinding(
            "warning",
            "turned",
            f"{label}: {what} counts the other way than the URDF: turned round, the textbook model "
            f"leaves {share:.0%} of the error",
            f"--map {' '.join(turn.option for turn in turns)}",
            j + 1,
            turns,
        )
    if not turned:
        yield from _weighed(part, robot)


def middle_of(recording: Recording, longest: float = LONGEST) -> Recording:
    """As much of a recording as geometry is asked of, ``longest`` s."""
    count = min(len(recording.t), int(longest * recording.rate))
    first = (len(recording.t) - count) // 2
    return recording.part(first, first + count, "")


def _turned(part: Recording, robot: Robot) -> Iterator[tuple[int, tuple[tuple[int, int], float]]]:
    """The joint whose turning round helps most is turned; then the others are asked again."""
    kept = base_parameters(robot).kept
    view = TextbookView.of(part, robot, kept)
    if view is None:
        return
    scale = np.maximum(view.tau.std(axis=0), 1e-9)
    left = view.left(scale)
    if len(left) < FEWEST:
        return
    joints = np.arange(robot.n)
    asked = set(range(robot.n))
    while asked:
        found = {}
        for j in sorted(asked):
            other = TextbookView.of(_with_signs(part, j, (-1, 1)), robot, kept)
            for signs in TURNED:
                seen = view if signs[0] > 0 else other
                if seen is not None:
                    found[j, signs] = seen.turned(j, signs[1]).left(scale)
        shares = {
            key: float(new.sum() / max(left.sum(), 1e-300))
            for key, new in found.items()
            if surely_better(new, left, joints == key[0])
        }
        if not shares:
            return
        j, signs = _likeliest(shares, part, robot)
        yield j, (signs, shares[j, signs])
        part = _with_signs(part, j, signs)
        view, left = TextbookView.of(part, robot, kept) or view, found[j, signs]
        asked.remove(j)


def _likeliest(shares: Mapping[Way, float], part: Recording, robot: Robot) -> Way:
    """The way that leaves least. Turning one of two joints is as good as turning the other with
    everything mirrored or of negative mass; of such the one nearest to the URDF's bodies."""
    least = min(shares.values())
    alike = [way for way, share in shares.items() if share <= (1 + ALIKE) * least]
    if len(alike) == 1:
        return alike[0]
    return max(alike, key=lambda way: _likeness(_with_signs(part, *way), robot))


def _likeness(part: Recording, robot: Robot) -> float:
    """Correlation of the torques with those of the URDF's bodies, over all joints."""
    run = prepare(replace(part, dq=None), robot, min(CUTOFF, part.rate / 8))
    c = run.context
    bodies = run.lowpass(inverse_dynamics(robot, robot.parameters, c.q, c.dq, c.ddq))
    scale = np.maximum(run.tau.std(axis=0), 1e-9)
    a, b = (each * run.keep for each in (run.tau / scale, bodies / scale))
    return float((a * b).sum() / max(np.linalg.norm(a) * np.linalg.norm(b), 1e-300))


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
    left = view.left(np.maximum(view.tau.std(axis=0), 1e-9)).sum(axis=1)
    return left if len(left) >= FEWEST else np.empty(0)


def _with_signs(part: Recording, joint: int, signs: tuple[int, int]) -> Recording:
    q, tau = part.q.copy(), part.tau.copy()
    q[:, joint] *= signs[0]
    tau[:, joint] *= signs[1]
    return replace(part, q=q, tau=tau)


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

    def turned(self, joint: int, sign: int) -> TextbookView:
        """The same with a joint's torque times ``sign``: nothing else depends on it."""
        tau = self.tau.copy()
        tau[:, joint] *= sign
        return replace(self, tau=tau)

    def left(self, scale: Array) -> Array:
        """(blocks, n) sums of squares that the textbook model leaves, each joint by its torque's
        size ``scale`` (n,)."""
        parameters, _ = fit_textbook(self.columns, self.tau, self.keep, 1.0 / scale)
        left = np.where(self.keep, (self.tau - self.columns @ parameters) / scale, 0.0)
        return np.column_stack([np.bincount(self.blocks, of_joint) for of_joint in (left**2).T])


def _weighed(part: Recording, robot: Robot) -> Iterator[CheckFinding]:
    """The slope of each torque over the weight of the URDF's bodies, beside friction and whatever
    goes with accelerations."""
    run = prepare(replace(part, dq=None), robot, min(CUTOFF, part.rate / 8))
    factor = run.lowpass.factor
    c = run.context
    still = np.zeros_like(c.q)
    weight = run.lowpass(inverse_dynamics(robot, robot.parameters, c.q, still, still))
    dq, ddq = c.dq[::factor], c.ddq[::factor]
    blocks = blocks_of(run)
    for j in range(robot.n):
        keep = run.keep[:, j]
        if keep.sum() < 50 or np.ptp(weight[keep, j]) < 1e-3 * np.abs(weight).max() + 1e-9:
            continue
        rubbing = [np.ones(keep.sum()), np.sign(dq[keep, j]), dq[keep, j]]
        others = np.hstack([np.stack(rubbing, axis=1), ddq[keep]])
        x, y = _without(others, weight[keep, j]), _without(others, run.tau[keep, j])
        power = float(x @ x)
        slope = float(x @ y) / power
        told = slope * float(x @ y) / max(float(y @ y), 1e-300)
        scores = np.bincount(blocks[keep], x * (y - slope * x))
        error = float(np.sqrt((scores**2).sum()) / power)
        if told < TOLD or abs(slope) < SURE * error or 1 / OFF < abs(slope) < OFF:
            continue
        scaled = Mend(f"tau{j + 1}", f"{1 / abs(slope):.3g}")
        yield CheckFinding(
            "warning",
            "torque_scale",
            f"{joint_label(j, robot.joint_names)}: tau is {abs(slope):.2g} times the weight of the "
            "URDF's bodies: motor-side, in another unit, or bodies that are placeholders?",
            f"--map {scaled.option}, better with the gear ratio",
            j + 1,
            (scaled,),
        )


def _without(columns: Array, values: Array) -> Array:
    found, *_ = np.linalg.lstsq(columns, values, rcond=None)
    return np.asarray(values - columns @ found)
