"""Torque that is clipped or frozen, positions that jump, joints that never move."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pa10d.checks.finding import CheckFinding, Mend, joint_label, percent
from pa10d.checks.held import held_runs
from pa10d.dynamics import Robot
from pa10d.measurement.clipped import is_moving, limits
from pa10d.measurement.dull import Dull, dull
from pa10d.measurement.recording import Recording
from pa10d.measurement.spans import spans
from pa10d.measurement.standstill import NEVER_MOVES
from pa10d.regression.noisy_limits import noisy_limits

Array = NDArray[np.float64]

FROZEN = 0.25  # s
LITTLE = 0.1  # rad (m)
MATERIAL = 0.01  # of the samples: fewer wrong ones make a fit poorer, not wrong
MOSTLY = 0.9  # of the samples at a limit: what is left is no picture of the joint


def check_channels(
    recording: Recording, names: tuple[str, ...] | None, robot: Robot | None = None
) -> Iterator[CheckFinding]:
    """Findings per joint, from the arrays alone; robot: says which joints slide."""
    for j in range(recording.joints):
        q, tau = recording.q[:, j], recording.tau[:, j]
        label, moving = joint_label(j, names), is_moving(q)
        angle = "rad" if robot is None else robot.angle_unit(j)
        torque = "N·m" if robot is None else robot.torque_unit(j)
        motion = list(_motion(q, recording, label, j, angle))
        yield from motion
        if np.ptp(q) > NEVER_MOVES:
            yield from _clipped(q, tau, label, j, torque)
            shown = list(_dull(dull(tau, moving), label, j, torque))
            yield from shown or _frozen(tau, moving, recording, label, j)


def _motion(
    q: Array, recording: Recording, label: str, j: int, unit: str
) -> Iterator[CheckFinding]:
    reach = float(np.ptp(q))
    if reach <= NEVER_MOVES:
        yield CheckFinding(
            "warning",
            "never_moved",
            f"{label} never moves (range {reach:.2g} {unit}): nothing of its friction and little "
            "of its inertia can be learnt here",
            "add a run in which it moves, or leave it out under 'joints' in the profile",
            j + 1,
        )
    elif reach < LITTLE:
        yield CheckFinding(
            "info", "little_motion", f"{label} moves over {reach:.2g} {unit} only", "", j + 1
        )
    steps = np.abs(np.diff(q))
    usual = float(np.quantile(steps, 0.999))
    worst = int(steps.argmax())
    made_up = any(k + count == worst for k, count in held_runs(q))
    if not made_up and steps[worst] > max(0.05, 10 * usual):
        mend = Mend(f"q{j + 1}", "wrap2pi*rad")
        turn = unit == "rad" and abs(steps[worst] - 2 * np.pi) < 0.1
        yield CheckFinding(
            "error",
            "jump",
            f"{label}: q jumps by {steps[worst]:.3g} {unit} at {recording.t[worst]:.3f} s",
            f"it starts anew every turn: --map {mend.option}" if turn else "cut the file there",
            j + 1,
            (mend,) if turn else (),
        )


def check_limits(recording: Recording, robot: Robot) -> Iterator[CheckFinding]:
    """Limits that noise hides: by what the motion asks for."""
    for limit in noisy_limits(recording, robot):
        j, unit = limit.joint, robot.torque_unit(limit.joint)
        label, share = joint_label(j, robot.joint_names), float(limit.at.mean())
        bound = "no higher" if limit.largest else "no lower"
        yield _cut_off(
            f"{label}: the torque comes to {bound} than {limit.level:.4g} {unit}, where the motion "
            f"asks for more, in {percent(share)} of the samples: it is clipped",
            share,
            j,
        )


def _clipped(q: Array, tau: Array, label: str, j: int, unit: str) -> Iterator[CheckFinding]:
    for limit in limits(q, tau):
        share, end = float(limit.at.mean()), "largest" if limit.largest else "smallest"
        yield _cut_off(
            f"{label}: the torque stands at its {end} value {limit.level:.4g} {unit} in "
            f"{percent(share)} of the samples: it is clipped",
            share,
            j,
        )


def _cut_off(sentence: str, share: float, j: int) -> CheckFinding:
    return CheckFinding(
        "error" if share > MOSTLY else "warning",
        "clipped",
        sentence,
        "widen the sensor's range or move less hard; no fit and no judgement of this joint uses "
        "these samples",
        j + 1,
    )


def _dull(found: Dull | None, label: str, j: int, unit: str) -> Iterator[CheckFinding]:
    if found is not None:
        yield CheckFinding(
            "error",
            "dull",
            f"{label}: the torque is exactly {found.level:.4g} {unit} in {percent(found.share)} of "
            f"the samples in which the joint moves, and its steps are {found.step:.2g} {unit}: "
            "what moves it is below what this channel shows, or the motor was off",
            "record it finer, and with power. Forced, the other joints are fitted without it",
            j + 1,
        )


def _frozen(
    tau: Array, moving: NDArray[np.bool_], recording: Recording, label: str, j: int
) -> Iterator[CheckFinding]:
    least = max(10, int(FROZEN * recording.rate))
    same = np.concatenate([[False], np.diff(tau) == 0]) & moving
    extreme = (tau == tau.max()) | (tau == tau.min())
    step = _step(tau, same)
    runs = [
        (int(k), int(end - k))
        for k, end in spans(same & ~extreme)
        if end - k >= least and _jump(tau, k - 1, end) > 1.5 * step
    ]
    constant = np.ptp(tau) == 0
    if constant or runs:
        first, longest = (0, len(tau)) if constant else max(runs, key=lambda run: run[1])
        wrong = constant or sum(length for _, length in runs) > MATERIAL * len(tau)
        yield CheckFinding(
            "error" if wrong else "warning",
            "frozen",
            f"{label}: the torque holds one value for {longest / recording.rate:.2g} s at "
            f"{recording.t[first]:.3f} s while the joint moves",
            "look for a lost sensor or a logger that repeats old values",
            j + 1,
        )


def _step(tau: Array, same: NDArray[np.bool_]) -> float:
    """Between neighbouring ones of the values that the torque comes to stand at again and again:
    the steps of a coarse channel. 0 where it has none; what a logger repeats has no such values."""
    stood = tau[spans(same)[:, 0]]
    values, times = np.unique(stood, return_counts=True)
    levels = values[times > 1]
    return float(np.median(np.diff(levels))) if len(levels) > 2 else 0.0


def _jump(tau: Array, first: int, end: int) -> float:
    """By how much the torque moves where it leaves the value of samples first … end - 1, at the
    most: of a coarse channel that merely dwelt there no more than one step."""
    beside = tau[[max(first - 1, 0), min(end, len(tau) - 1)]]
    return float(np.abs(beside - tau[first]).max())
