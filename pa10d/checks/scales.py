"""Torques that are not in N·m at the joint: one unlike its neighbours', or all unlike the weight.

A torque in another unit than the others' shows by what joints do to each other, as a sign does: the
textbook model, all its masses free, explains a recording best with every torque in one unit. One
that all torques share only the URDF's bodies tell.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.checks.finding import CheckFinding, Mend, joint_label
from pa10d.checks.textbook_fit import blocks_of
from pa10d.checks.textbook_view import CUTOFF, SURE, TextbookView, likelihood, surely_better
from pa10d.dynamics import Robot, inverse_dynamics
from pa10d.measurement.recording import Recording
from pa10d.regression.equation import prepare

Array = NDArray[np.float64]

UNITS = (3.0, 10.0, 100.0, 1000.0)  # and gears; a torque constant is off by less
TRIED = (*UNITS, *(1.0 / s for s in UNITS))
SCALED_TO = 0.01  # of a decade: the unit shows
OFF = 40.0  # times: real URDFs have links that weigh a twentieth of the true ones, not a fortieth
TOLD = 0.5  # of the torque that weight must explain before its size is believed


def check_scales(
    part: Recording, robot: Robot, view: TextbookView | None
) -> Iterator[CheckFinding]:
    """Joints whose torque is in another unit than the others'; where there are none, than the
    weight of the URDF's bodies. view: of that part, None where it moves too little."""
    unlike = {} if view is None else dict(_unlike_others(view))
    for j, (factor, share) in sorted(unlike.items()):
        mend = Mend(f"tau{j + 1}", f"{factor:.3g}")
        yield CheckFinding(
            "warning",
            "torque_scale",
            f"{joint_label(j, robot.joint_names)}: tau is {1 / factor:.2g} times what the other "
            f"joints' torques ask for: scaled, the textbook model leaves {share:.0%} of the error",
            f"--map {mend.option}, better with the unit or gear ratio that it lacks",
            j + 1,
            (mend,),
        )
    if not unlike:
        yield from _weighed(part, robot)


def _unlike_others(view: TextbookView) -> Iterator[tuple[int, tuple[float, float]]]:
    """Joints with the factor that their torque lacks, and the share of the error that is left with
    it. The one that helps most is scaled, if it surely helps; then the others are asked again."""
    joints = np.arange(view.tau.shape[1])
    asked = set(joints.tolist())
    while asked:
        left = view.left()
        found = {(j, f): view.scaled(j, f).left() for j in sorted(asked) for f in TRIED}
        if not found:
            return
        j, near = max(found, key=lambda way: likelihood(found[way], left))
        if not surely_better(found[j, near], left, joints == j):
            return
        factor = _best(view, j, near)
        view = view.scaled(j, factor)
        yield j, (factor, float(view.left().sum() / left.sum()))
        asked.remove(j)


def _best(view: TextbookView, joint: int, near: float) -> float:
    """The factor, within half a decade, by which least is left."""
    decade, left = float(np.log10(near)), view.left()
    found = scipy.optimize.minimize_scalar(
        lambda power: -likelihood(view.scaled(joint, 10**power).left(), left),
        bounds=(decade - 0.5, decade + 0.5),
        method="bounded",
        options={"xatol": SCALED_TO},
    )
    return float(10**found.x)


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
