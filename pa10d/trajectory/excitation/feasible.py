"""Requests that cannot be met, found before the search and said in words to act on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.trajectory.excitation.problem import CLEAR, ExcitationProblem
from pa10d.trajectory.excitation.result import ExcitationFigures

Array = NDArray[np.float64]

LEAST_TRAVEL = 0.05  # rad that a joint must be able to move
LEAST_SPEED = 0.01  # rad/s
POSES = 3000  # looked at for collisions and gravity
LARGE = 150.0  # condition number worth a warning: good ones lie below 100
UNEVEN = 8.0  # times the usual joint's standard error that is worth a warning
HOPELESS = 1e4  # condition number from which some parameter is as good as not excited


def refuse_hopeless(problem: ExcitationProblem) -> None:
    """Raise UserError, one line per reason, where no search can succeed."""
    reasons = [*_counts(problem), *_rooms(problem)]
    if not reasons:
        reasons = _bodies(problem)
    if reasons:
        raise UserError("\n".join(reasons))


def _counts(problem: ExcitationProblem) -> list[str]:
    moving, h = len(problem.joints), problem.harmonics
    columns = len(problem.columns)
    rows = problem.samples * moving
    needed = max(int(np.ceil(columns / moving)), 4 * h + 2)
    found = []
    if problem.samples < needed:
        found.append(
            f"samples: {problem.samples} in a period give {rows} equations for {columns} "
            f"parameters and must resolve {h} harmonics; expected at least {needed}"
        )
    if problem.fundamental <= 0:
        found.append(f"fundamental: found {problem.fundamental:g} Hz, expected more than 0")
    return found


def _rooms(problem: ExcitationProblem) -> list[str]:
    room, found = problem.room, []
    omega = 2 * np.pi * problem.fundamental
    for k, j in enumerate(problem.joints):
        travel = 2 * room.half[k]
        # slower than one swing per period no joint can move, faster ones need less travel
        speed = min(
            room.velocity[k],
            room.acceleration[k] / omega,
            room.half[k] * omega * problem.harmonics,
        )
        if travel < LEAST_TRAVEL:
            found.append(
                f"joint {j + 1}: may move by {travel:.3g} rad only, too little to excite anything; "
                f"expected at least {LEAST_TRAVEL:g} rad, or leave this joint out"
            )
        elif speed < LEAST_SPEED:
            found.append(
                f"joint {j + 1}: its limits of {room.velocity[k]:.3g} rad/s and "
                f"{room.acceleration[k]:.3g} rad/s² allow {speed:.2g} rad/s at "
                f"{problem.fundamental:g} Hz; expected at least {LEAST_SPEED:g} rad/s: wider "
                "limits, or leave this joint out"
            )
    return found


def _bodies(problem: ExcitationProblem) -> list[str]:
    """Is there a region of poses in which gravity can be held and nothing touches?"""
    rng = np.random.default_rng(0)
    room = problem.room
    q = rng.uniform(room.lower, room.upper, (POSES, len(problem.joints)))
    zero = np.zeros_like(q)
    tau = np.abs(problem.arm_torque(q, zero, zero))
    light = tau <= room.torque
    heavy = [
        f"joint {problem.joints[k] + 1}: gravity alone asks for {tau[:, k].min():.3g} N·m or more "
        f"in {100 * (1 - light[:, k].mean()):.0f} % of all poses, allowed are "
        f"{room.torque[k]:.3g} N·m; expected a stronger joint, a lighter tool or a narrower range "
        "around a pose where it hangs or stands"
        for k in range(q.shape[1])
        if light[:, k].mean() < 0.02
    ]
    if heavy:
        return heavy
    gaps = problem.capsules.clearance(problem.whole(q))
    bad = gaps < CLEAR
    if gaps.size and bad.any(axis=1).mean() > 0.98:
        worst = int(np.argmax(bad.mean(axis=0)))
        return [
            f"{problem.capsules.name(worst)} come nearer than {CLEAR:g} m in "
            f"{100 * bad[:, worst].mean():.0f} % of all poses; expected another pose of the joints "
            "that stand, other position limits, or another environment in the profile"
        ]
    return []


def refuse_unfit(problem: ExcitationProblem, x: Array) -> None:
    """After the search: raise UserError where even the best motion breaks a limit."""
    if problem.excess(x) <= 0:
        return
    q, dq, ddq = (basis @ x for basis in problem.fine)
    share = np.abs(problem.arm_torque(q, dq, ddq)).max(axis=0) / problem.room.torque
    lines = [
        f"joint {problem.joints[k] + 1}: even the most careful motion found takes "
        f"{share[k] * problem.room.torque[k]:.3g} N·m, allowed are {problem.room.torque[k]:.3g}; "
        "expected a stronger joint, a slower fundamental or a narrower range"
        for k in np.flatnonzero(share > 1)
    ]
    gaps = problem.capsules.clearance(problem.whole(q))
    lines += [
        f"{problem.capsules.name(int(c))} come as near as {gaps[:, c].min():.3f} m in the most "
        f"careful motion found, expected {CLEAR:g} m: another pose of the joints that stand, or "
        "narrower position limits"
        for c in np.flatnonzero((gaps < CLEAR).any(axis=0))
    ]
    raise UserError("\n".join(lines))


def refuse_unexcited(problem: ExcitationProblem, x: Array) -> None:
    """After the search: raise UserError where a parameter is as good as invisible, and say which
    joint's limits are to blame."""
    matrix = problem.observation(x)
    values, vectors = np.linalg.svd(matrix, full_matrices=False)[1:]
    if values[0] < HOPELESS * values[-1]:
        return
    share = vectors[-1] ** 2
    names = problem.columns.names()
    hidden = [names[k] for k in np.argsort(-share)[:3] if share[k] > 0.05]
    joint = int(problem.columns.joint_of()[int(np.argmax(share))])
    raise UserError(
        f"{', '.join(hidden)} can hardly be seen (condition number "
        f"{values[0] / max(values[-1], 1e-300):.2g}): joint {problem.joints[joint] + 1} is held "
        f"back by its {_tightest(problem, x, joint)} limit; expected a wider one, a slower "
        "fundamental for more travel, or leave this joint out"
    )


def advice(problem: ExcitationProblem, x: Array, figures: ExcitationFigures) -> list[str]:
    """What is not forbidden but should be known: joints that are excited far less than others."""
    errors = np.array(figures.standard_error)
    usual = float(np.median(errors))
    found = []
    if figures.condition_number > LARGE:
        vectors = np.linalg.svd(problem.observation(x), full_matrices=False)[2]
        worst = int(np.argmax(np.abs(vectors[-1])))
        joint = int(problem.columns.joint_of()[worst])
        found.append(
            f"condition number {figures.condition_number:.0f}: {problem.columns.names()[worst]} "
            f"is seen least; joint {problem.joints[joint] + 1} is held back by its "
            f"{_tightest(problem, x, joint)} limit"
        )
    return found + [
        f"joint {problem.joints[k] + 1}: its parameters will be {errors[k] / usual:.0f} times "
        "less certain than the usual joint's; it is held back by its "
        f"{_tightest(problem, x, int(k))} limit"
        for k in np.flatnonzero(errors > UNEVEN * usual)
    ]


def _tightest(problem: ExcitationProblem, x: Array, joint: int) -> str:
    """The limit that a joint uses up most: of position, the whole range."""
    q, dq, ddq = (basis @ x for basis in problem.fine)
    use = {
        "position": np.ptp(q[:, joint]) / (2 * problem.room.half[joint]),
        "velocity": np.abs(dq[:, joint]).max() / problem.room.velocity[joint],
        "acceleration": np.abs(ddq[:, joint]).max() / problem.room.acceleration[joint],
    }
    return max(use, key=lambda name: float(use[name]))
