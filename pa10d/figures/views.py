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

PASSED = 0.5  # of the cut-off: slower changes than that pass the filter whole
FEWEST = 200  # samples that must remain for a closer look


@dataclass(frozen=True)
class ViewAxis:
    """label: of the axis, with {own} and {other} joint numbers; x: (M,) of one run, for the effect
    and the joint (0-based) whose residual is shown; slow_enough: (M,) True where the equation's
    low-pass leaves the effect as it is."""

    label: str
    x: Look
    slow_enough: Callable[[RunResidual, Term, int], NDArray[np.bool_]] | None = None

    def shows(self, run: RunResidual, term: Term, joint: int) -> NDArray[np.bool_]:
        """(M,) True where the effect can be seen undistorted."""
        if self.slow_enough is None:
            return np.ones(len(run.measured), dtype=bool)
        return self.slow_enough(run, term, joint)


def quantity_of(term: Term) -> ViewAxis | None:
    """What its class wants it drawn against; None: no single quantity shows it."""
    return QUANTITIES.get(term.effect.drawn.against)


def direction(term: Term, run: RunResidual, joint: int) -> Array:
    """(M,) ±1: by which the residual is multiplied."""
    if not term.effect.drawn.along:
        return np.ones(len(run.measured))
    return np.sign(run.decimated(run.seen.dq[:, joint]))


def near(term: Term, x: Array) -> NDArray[np.bool_]:
    """(K,) samples worth showing: all, or those near zero where the effect acts only there."""
    if term.effect.drawn.near is None:
        return np.isfinite(x)
    name, times = term.effect.drawn.near
    close = np.abs(x) < times * term.shape[name]
    return close if close.sum() >= FEWEST else np.isfinite(x)


def _own(term: Term, joint: int) -> int:
    return term.joints[0] if term.joints else joint


def _other(term: Term, joint: int) -> int:
    return term.joints[-1] if term.joints else joint


def _phase(run: RunResidual, term: Term, joint: int) -> Array:
    turns = run.decimated(run.seen.q[:, _own(term, joint)]) / (2 * np.pi)
    return np.asarray(turns * term.shape[term.effect.line_order] % 1.0)


def _slow(run: RunResidual, term: Term, joint: int) -> NDArray[np.bool_]:
    speed = np.abs(run.decimated(run.seen.dq[:, _own(term, joint)]))
    hertz = speed * term.shape[term.effect.line_order] / (2 * np.pi)
    return np.asarray(hertz < PASSED * run.equation.lowpass.cutoff)


def _travel(run: RunResidual, term: Term, joint: int) -> Array:
    j = _own(term, joint)
    return run.decimated(since_reversal(run.seen.q[:, j], run.seen.dq[:, j], run.seen.dt)[1])


def _slip(run: RunResidual, term: Term, joint: int) -> Array:
    speed = term.effect.slips(run.seen, term.joints, term.shape)
    assert speed is not None, f"{term.effect_id} is drawn against a slip that it does not have"
    return run.decimated(speed)


def _rate(run: RunResidual, term: Term, joint: int) -> Array:
    total = run.seen.total[:, _own(term, joint)]
    return run.equation.lowpass(np.gradient(total, run.seen.dt))


def _load(run: RunResidual, term: Term, joint: int) -> Array:
    return run.equation.lowpass(run.seen.load[:, _own(term, joint)])


QUANTITIES: dict[str, ViewAxis] = {
    "q": ViewAxis("position of joint {own}, {angle}",
                  lambda r, t, j: r.decimated(r.seen.q[:, _own(t, j)])),
    "dq": ViewAxis("velocity of joint {own}, {angle}/s",
                   lambda r, t, j: r.decimated(r.seen.dq[:, _own(t, j)])),
    "ddq": ViewAxis("acceleration of joint {own}, {angle}/s²",
                    lambda r, t, j: r.equation.lowpass(r.seen.ddq[:, _own(t, j)])),
    "other_dq": ViewAxis("velocity of joint {other}, {angle}/s",
                         lambda r, t, j: r.decimated(r.seen.dq[:, _other(t, j)])),
    "other_ddq": ViewAxis("acceleration of joint {other}, {angle}/s²",
                          lambda r, t, j: r.equation.lowpass(r.seen.ddq[:, _other(t, j)])),
    "slip": ViewAxis("speed at which what joints {own} and {other} share slips, {angle}/s", _slip),
    "load": ViewAxis("torque that joint {own} passes to the links, {unit}", _load),
    "size of load": ViewAxis("size of the torque that joint {own} passes to the links, {unit}",
                             lambda r, t, j: np.abs(_load(r, t, j))),
    "total": ViewAxis("modelled torque of joint {own}, {unit}",
                      lambda r, t, j: r.equation.lowpass(r.seen.total[:, _own(t, j)])),
    "rate": ViewAxis("rate at which joint {own}'s torque changes, {unit}/s", _rate),
    "t": ViewAxis("time in the run, s", lambda r, t, j: r.decimated(r.seen.t)),
    "travel": ViewAxis("travel of joint {own} since it last turned round, {angle}", _travel),
    "turns of a line": ViewAxis("place of joint {own} within one ripple, turns of it", _phase,
                                slow_enough=_slow),
}  # fmt: skip
"""Against what an effect's class may ask to be drawn (``View.against``)."""
