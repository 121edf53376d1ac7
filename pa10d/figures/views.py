"""Against which quantity an effect is best looked at."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.compare import RunResidual
from pa10d.compare.reversals import since_reversal
from pa10d.model import Term

Array = NDArray[np.float64]
Look = Callable[[RunResidual, Term, int], Array]

REACH = {"stribeck": ("vs", 5.0), "presliding_hysteresis": ("zs", 12.0)}
"""Effects that live near zero: the shape parameter that says how near, and how many of it to
show."""
PASSED = 0.5  # of the cut-off: slower changes than that pass the filter whole
FEWEST = 200  # samples that must remain for a closer look


@dataclass(frozen=True)
class View:
    """label: of the axis, with {own} and {other} joint numbers; x: (M,) of one run, for the effect
    and the joint (0-based) whose residual is shown; along: torque is counted along the motion, so
    that friction of both directions falls on one curve; slow_enough: (M,) True where the equation's
    low-pass leaves the effect as it is."""

    label: str
    x: Look
    along: bool = False
    slow_enough: Look | None = None

    def shows(self, run: RunResidual, term: Term, joint: int) -> Array:
        """(M,) True where the effect can be seen undistorted."""
        if self.slow_enough is None:
            return np.ones(len(run.measured), dtype=bool)
        return self.slow_enough(run, term, joint)

    def direction(self, run: RunResidual, joint: int) -> Array:
        """(M,) ±1: by which the residual is multiplied."""
        if not self.along:
            return np.ones(len(run.measured))
        return np.sign(run.decimated(run.seen.dq[:, joint]))


def view_of(term: Term) -> View | None:
    """None: no single quantity shows it; look at it over time."""
    if term.effect_id in SPECIAL:
        return SPECIAL[term.effect_id]
    example = term.effect.example
    return GENERAL.get(example.against) if example is not None else GENERAL["dq"]


def near(term: Term, x: Array) -> NDArray[np.bool_]:
    """(K,) samples worth showing: all, or those near zero where the effect acts only there."""
    if term.effect_id not in REACH:
        return np.isfinite(x)
    name, times = REACH[term.effect_id]
    close = np.abs(x) < times * term.shape[name]
    return close if close.sum() >= FEWEST else np.isfinite(x)


def _own(term: Term, joint: int) -> int:
    return term.joints[0] if term.joints else joint


def _other(term: Term, joint: int) -> int:
    return term.joints[-1] if term.joints else joint


def _phase(run: RunResidual, term: Term, joint: int) -> Array:
    cycles = run.decimated(run.seen.q[:, _own(term, joint)]) * term.shape["N"] / (2 * np.pi)
    return np.asarray(cycles % 1.0)


def _slow(run: RunResidual, term: Term, joint: int) -> Array:
    speed = np.abs(run.decimated(run.seen.dq[:, _own(term, joint)]))
    return np.asarray(speed * term.shape["N"] / (2 * np.pi) < PASSED * run.equation.lowpass.cutoff)


def _travel(run: RunResidual, term: Term, joint: int) -> Array:
    j = _own(term, joint)
    return run.decimated(since_reversal(run.seen.q[:, j], run.seen.dq[:, j], run.seen.dt)[1])


def _rate(run: RunResidual, term: Term, joint: int) -> Array:
    total = run.seen.total[:, _own(term, joint)]
    return run.equation.lowpass(np.gradient(total, run.seen.dt))


def _load(run: RunResidual, term: Term, joint: int) -> Array:
    return run.equation.lowpass(run.seen.load[:, _own(term, joint)])


def _warmth(run: RunResidual, term: Term, joint: int) -> Array:
    return run.decimated(run.seen.t)


GENERAL: dict[str, View] = {
    "q": View("position of joint {own}, {angle}",
              lambda r, t, j: r.decimated(r.seen.q[:, _own(t, j)])),
    "dq": View("velocity of joint {own}, {angle}/s",
               lambda r, t, j: r.decimated(r.seen.dq[:, _own(t, j)])),
    "ddq": View("acceleration of joint {own}, {angle}/s²",
                lambda r, t, j: r.equation.lowpass(r.seen.ddq[:, _own(t, j)])),
    "other_dq": View("velocity of joint {other}, {angle}/s",
                     lambda r, t, j: r.decimated(r.seen.dq[:, _other(t, j)])),
    "other_ddq": View("acceleration of joint {other}, {angle}/s²",
                      lambda r, t, j: r.equation.lowpass(r.seen.ddq[:, _other(t, j)])),
    "load": View("torque that joint {own} passes to the links, {unit}", _load),
    "total": View("modelled torque of joint {own}, {unit}",
                  lambda r, t, j: r.equation.lowpass(r.seen.total[:, _own(t, j)])),
    "rate": View("rate at which joint {own}'s torque changes, {unit}/s", _rate),
    "t": View("time in the run, s", _warmth),
}  # fmt: skip

SPECIAL: dict[str, View | None] = {
    "payload": None,
    "base_tilt": None,
    "joint_elasticity": None,
    "load_friction": View(
        "size of the torque that joint {own} passes to the links, {unit}",
        lambda r, t, j: np.abs(_load(r, t, j)), along=True,
    ),
    "position_friction": View(GENERAL["q"].label, GENERAL["q"].x, along=True),
    "presliding_hysteresis": View(
        "travel of joint {own} since it last turned round, {angle}", _travel, along=True
    ),
    "thermal_friction": View(GENERAL["t"].label, _warmth, along=True),
    "torque_ripple": View("place of joint {own} within one ripple, turns of it", _phase,
                          slow_enough=_slow),
}  # fmt: skip
