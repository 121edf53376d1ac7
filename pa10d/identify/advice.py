"""What a control engineer should know about a fit, and which motion would mend it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from pa10d.common.words import rounded
from pa10d.dynamics.robot import PARAMETER_NAMES, Robot
from pa10d.identify.channel import FoundChannel
from pa10d.identify.excitation import MotionExtent
from pa10d.identify.feasibility import FeasibleModel
from pa10d.identify.fit import Fit
from pa10d.identify.smoothing import Smoothing
from pa10d.identify.timing import Shift
from pa10d.regression.layout import Layout

Array = NDArray[np.float64]

EARLY_SURE = 3.0  # standard errors, from which on torque that looks early is worth a word
LATER = 3.0  # standard errors of both, beyond which a filter's own delay is more than torque's
SMALL_RANGE = 0.05  # rad (m): a joint that moves less tells nothing of gravity or inertia
FEW_REVERSALS = 2
UNCERTAIN = 0.3  # standard error over value
COSTLY = 0.02  # share of RMS that feasibility may add unmentioned
NEGLIGIBLE = 1e-4  # of the torque: an error that nobody minds
DRIVEN_SURE = (
    4.0  # standard errors of friction that drives its joint, beyond which its sign is doubted
)
TURNED = (
    "friction would drive this joint: does its torque, or its angle, count the other way than the "
    "URDF has it (a check of the run tells)"
)
ASK = "whether an effect is missing, a diagnosis says"  # on motion that no fit has seen
NAMED = 6  # parameters named in one sentence


def warnings_of(
    layout: Layout,
    fit: Fit,
    feasible: FeasibleModel,
    smoothing: Smoothing,
    shift: Shift,
    channel: FoundChannel | None,
    seen: MotionExtent,
) -> list[str]:
    """Sentences, the gravest first."""
    return [
        *_hidden(seen),
        *_unmoved(layout.robot, seen),
        *_lost(layout, fit, seen),
        *_bounds(layout, fit, feasible),
        *_uncertain(layout, fit, seen),
        *_friction_sign(layout.robot, smoothing, seen),
        *_timing(shift, channel),
    ]


def _hidden(seen: MotionExtent) -> Iterator[str]:
    joints = np.flatnonzero(seen.hidden).tolist()
    if joints:
        own, its = ("its", "its") if len(joints) == 1 else ("their", "each")
        yield (
            f"{_joints(joints)}: {own} torque is known nowhere in these runs, {its} channel mostly "
            "shows one value or a limit: it is not fitted, and nothing of friction and rotor there "
            "is known; record it finer, in a wider range and with power"
        )


def _unmoved(robot: Robot, seen: MotionExtent) -> Iterator[str]:
    for j in range(robot.n):
        if seen.range[j] < SMALL_RANGE:
            yield (
                f"{_joint(robot, j)} hardly moves ({seen.range[j]:.2g} {robot.angle_unit(j)}): its "
                f"friction and inertia are not excited, nor is its own torque fitted, of which "
                f"friction or a brake holds any part at rest; move it over its range, both ways"
            )
        elif seen.reversals[j] < FEW_REVERSALS:
            yield (
                f"{_joint(robot, j)} turns round {seen.reversals[j]} times: friction and gravity "
                f"look alike; repeat the motion in the other direction"
            )


def _lost(layout: Layout, fit: Fit, seen: MotionExtent) -> Iterator[str]:
    names, owners = layout.names(), layout.owners()
    for direction in fit.solution.lost.T:
        order = np.argsort(-np.abs(direction))
        main = [k for k in order[:NAMED] if abs(direction[k]) > 0.3 * abs(direction[order[0]])]
        if all(k >= len(layout.base) and seen.hidden[list(owners[k])].all() for k in main):
            continue  # no motion would show it
        terms = " ".join(f"{direction[k]:+.2f}·{names[k]}" for k in main)
        yield (
            f"rank lost: the motion does not show {terms} (columns scaled to equal size); "
            f"{_motion_for([names[k] for k in main], [owners[k] for k in main], layout, seen)}"
        )


def _bounds(layout: Layout, fit: Fit, feasible: FeasibleModel) -> Iterator[str]:
    robot, beta, start = layout.robot, fit.solution.beta, len(layout.base)
    if not feasible.found:
        yield "no feasible standard parameters were found: the search for them did not converge"
        return
    sizes = np.sqrt(np.maximum(np.diag(fit.uncertainty.covariance), 0.0))
    dry = {
        k
        for term, place in zip(layout.terms, layout.places, strict=True)
        if term.effect.tells_sign
        for k in range(place.start, place.stop)
    }
    for k, name in enumerate(layout.names()[start:], start=start):
        bound = feasible.coefficients[k - start]
        if beta[k] < 0 <= bound and abs(bound) < 1e-6 * (abs(beta[k]) + sizes[k]):
            drives = k in dry and -beta[k] > DRIVEN_SURE * sizes[k]
            yield (
                f"{name} is {beta[k]:.3g} in the free fit and 0, its bound, in the feasible one: "
                f"as it is, {TURNED if drives else 'nothing can have it'}; {ASK}"
            )
    cost = feasible.rms / np.maximum(fit.rms, 1e-300) - 1.0
    costly = np.flatnonzero((cost > COSTLY) & (feasible.rms > NEGLIGIBLE * fit.torque))
    edge = np.flatnonzero(feasible.edge)
    if len(edge) and len(costly):  # else the data are content with bodies that lie well inside
        links = ", ".join(str(j + 1) for j in edge)
        yield (
            f"link {links}: the feasible mass distribution is at the edge of what a body can have; "
            "its inertia is not to be read as a measurement"
        )
    if len(costly):
        yield f"{_cost(robot, costly, feasible.rms, fit.rms)}: {_why(layout, beta, feasible)}"


def _cost(robot: Robot, costly: NDArray[np.intp], bounded: Array, free: Array) -> str:
    """What possible bodies cost, and where most: one cause, however many joints show it."""
    more = 100 * (bounded / np.maximum(free, 1e-300) - 1.0)[costly]
    worst = int(costly[np.argmax(more)])
    sizes = (
        f"{rounded(bounded[worst], 3)} instead of {rounded(free[worst], 3)} "
        f"{robot.torque_unit(worst)}"
    )
    if len(costly) == 1:
        where, size, most = _joint(robot, worst), f"{more[0]:.0f}", ""
    else:
        where = _joints([int(j) for j in costly])
        size, most = f"{more.min():.0f} to {more.max():.0f}", f"most on {_joint(robot, worst)}: "
    return f"{where}: feasible parameters leave {size} % more error ({most}{sizes})"


def _why(layout: Layout, beta: Array, feasible: FeasibleModel) -> str:
    held = _told_beyond_bounds(layout, beta)
    if not feasible.converged:
        return "the search for better ones did not converge"
    if held:
        return f"what was told does not fit ({', '.join(held)} out of bounds); {ASK}"
    return f"nothing that can exist explains all of it; {ASK}"


def _told_beyond_bounds(layout: Layout, beta: Array) -> list[str]:
    """Coefficients of effects that were asked for, where the free fit leaves what they can be:
    a law that does not fit costs bodies their share of the error."""
    names, out = layout.names(), []
    for term, place in zip(layout.terms, layout.places, strict=True):
        if term.effect.question == "textbook":
            continue
        for k, c in zip(range(place.start, place.stop), term.effect.coefficients, strict=True):
            if not c.lower <= beta[k] <= c.upper:
                out.append(names[k])
    return out


def _uncertain(layout: Layout, fit: Fit, seen: MotionExtent) -> Iterator[str]:
    beta = fit.solution.beta
    error = np.sqrt(np.maximum(np.diag(fit.uncertainty.covariance), 0.0))
    names, owners = layout.names(), layout.owners()
    poor = np.flatnonzero(error > UNCERTAIN * np.abs(beta))
    if not len(poor):
        return
    # those that leave the most torque in doubt first
    order = poor[np.argsort(-(error * fit.solution.scale)[poor])][:NAMED]
    left = fit.open
    shown = ", ".join(
        f"{names[k]} not determined"
        if left[k]
        else f"{names[k]} {rounded(beta[k], 2)} ± {rounded(error[k], 1)}"
        for k in order
    )
    more = f" and {len(poor) - len(order)} more" if len(poor) > len(order) else ""
    yield (
        f"{len(poor)} of {len(beta)} parameters have a standard error above 30 %: {shown}{more}; "
        f"{_motion_for([names[k] for k in order], [owners[k] for k in order], layout, seen)}"
    )


def _friction_sign(robot: Robot, smoothing: Smoothing, seen: MotionExtent) -> Iterator[str]:
    asked = ~smoothing.found & ~seen.hidden
    vague = [int(j) for j in np.flatnonzero(asked) if seen.range[j] >= SMALL_RANGE]
    if vague:
        yield (
            f"how sharply friction reverses on {_joints(vague)} is not visible "
            f"({smoothing.v0[vague[0]]:g} {robot.angle_unit(vague[0])}/s assumed); slow reversals "
            "would show it"
        )


def _timing(shift: Shift, channel: FoundChannel | None) -> Iterator[str]:
    if shift.seconds:
        word = "late" if shift.seconds > 0 else "early"
        yield (
            f"torque is {abs(shift.seconds) * 1e3:.2f} ± {shift.std_error * 1e3:.2f} ms {word} "
            "against position on the whole robot; the fit and the model account for it"
        )
    elif shift.estimate < 0.0 and -shift.estimate > EARLY_SURE * shift.std_error:
        yield (
            f"torque looks {-shift.estimate * 1e3:.3g} ± {shift.std_error * 1e3:.2g} ms early "
            "against position, as channels hardly are, but a spring or a gap between motor and "
            "link looks so; it was not taken for a shift in time"
        )
    if channel is not None:
        yield (
            f"the torque channel smooths: the recorded torque has passed {channel.words}, or "
            "something like it; the fit and the model account for it" + _too_slow(channel, shift)
        )
    if np.isfinite(shift.slow):
        yield (
            f"slow parts of the motion ask for another shift in time ({shift.slow * 1e3:.2f} ms) "
            f"than fast ones ({shift.estimate * 1e3:.2f} ms): the torque is low-passed, or the "
            "model lacks something that poses as a delay"
        )


def _too_slow(channel: FoundChannel, shift: Shift) -> str:
    """Where the filter alone would make torque later than it is, that is no plain reading of it."""
    later = channel.passed.delay - shift.seconds
    unsure = channel.std_error if np.isfinite(channel.std_error) else 0.0
    if later <= LATER * np.hypot(shift.std_error, unsure):
        return ""
    return (
        f". That filter alone would be {channel.passed.delay * 1e3:.3g} ms late, more than torque "
        "is: angles are late as well, or it is their noise, which makes accelerations too large "
        "where they are fast, or an effect that the textbook lacks, that looks like it"
    )


def _motion_for(
    names: Sequence[str], owners: Sequence[tuple[int, ...]], layout: Layout, seen: MotionExtent
) -> str:
    """Which motion shows these parameters."""
    robot = layout.robot
    carried = robot.carries()
    inertial, gravity, friction = set(), set(), set()
    for name, own in zip(names, owners, strict=True):
        joints = {int(i) for j in own for i in np.flatnonzero(carried[:, j])} or set(own)
        if ": F" in name:
            friction |= set(own)
        elif name.startswith(PARAMETER_NAMES[4:]) or name.endswith("Ia"):
            inertial |= set(own) | ({max(joints)} if joints else set())
        else:
            gravity |= joints
    advice = []
    if inertial:
        hard = ", ".join(
            f"{seen.acceleration[j]:.2g} {robot.angle_unit(j)}/s²" for j in sorted(inertial)
        )
        advice.append(
            f"accelerate {_joints(sorted(inertial))} harder, in several poses (seen {hard})"
        )
    if gravity:
        advice.append(f"visit more poses of {_joints(sorted(gravity))}")
    if friction:
        advice.append(f"move {_joints(sorted(friction))} at several constant speeds, both ways")
    return "; ".join(advice)


def _joint(robot: Robot, j: int) -> str:
    return f"joint {j + 1} ({robot.joint_names[j]})"


def _joints(indices: Sequence[int]) -> str:
    word = "joint" if len(indices) == 1 else "joints"
    return f"{word} {', '.join(str(j + 1) for j in indices)}"
