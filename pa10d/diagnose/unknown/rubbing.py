"""A joint's friction that is other in the runs held out than in those fitted, and no effect of it.

Grease warms up over the fitted run, and the run held out goes on where that ended: no warm-up from
cold foretells it, and the error was told as slow noise that motion does not predict, while the
speed alone explained most of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.diagnose.constants import BROKEN_SHARE, CLUSTERS, FRICTION_LEVEL, SEARCH_LEVEL
from pa10d.diagnose.evidence.errors_of import doubt_of, honest_covariance
from pa10d.diagnose.evidence.held_out import fit_side_power, judge
from pa10d.diagnose.regression.side import Side
from pa10d.diagnose.regression.state import SearchState
from pa10d.diagnose.unknown.own_part import own_part
from pa10d.regression.per_joint import PerJoint

Array = NDArray[np.float64]


@dataclass(frozen=True)
class OtherFriction:
    """Of a joint (0-based): share of its squared error that is gone where the held-out runs have
    Coulomb and viscous friction of their own; rms: N·m of that; lower, or higher, than fitted;
    goes_on: in the course of the fitted runs it changes that way, too; left_open: these leave as
    much of it open, by what the model lacks as well as by noise."""

    joint: int
    share: float
    rms: float
    p_value: float
    lower: bool
    goes_on: bool
    left_open: bool = False
    variables: tuple[str, ...] = ()

    @property
    def words(self) -> str:
        """``gone if its friction is lower in the runs held out than in those fitted``."""
        than = "lower" if self.lower else "higher"
        text = f"gone if its friction is {than} in the runs held out than in those fitted"
        if self.left_open and not self.goes_on:
            return f"{text}, which leave as much of it open: fit to motion like the held-out, too"
        if not self.goes_on:
            return f"{text}, as of a joint that was warmer or colder, or has worn"
        falls = "falls" if self.lower else "rises"
        return (
            f"{text}, and it {falls} in the course of these, too: a joint that warms up, or a "
            "lubricant that spreads, goes on from one run to the next, while a model takes every "
            "run to begin alike"
        )


def other_friction(state: SearchState, joints: Sequence[int]) -> list[OtherFriction]:
    """Those of these joints of which the held-out side alone says so, beyond its noise and what is
    unsure of the model, from one stretch of time to the next."""
    if state.frozen or {r.name for r in state.train.runs} & {r.name for r in state.held.runs}:
        return []
    found = (_of(state, j) for j in joints)
    return [one for one in found if one is not None]


def _of(state: SearchState, joint: int) -> OtherFriction | None:
    side, error = state.held, state.held_residual()
    _, rubs = _motion(side, joint)
    had = float(error[joint] @ error[joint])
    if not had:
        return None
    own = np.asarray(np.linalg.lstsq(rubs, error[joint], rcond=None)[0], dtype=np.float64)
    places = _of_textbook(state, joint)
    if len(places) == len(own) and _power(rubs, state.fit.beta[places] + own) < 0.0:
        return None  # that would be no friction: it would drive its joint
    change: PerJoint = {joint: rubs @ own}
    left = error[joint] - change[joint]
    share = 1.0 - float(left @ left) / had
    seen = judge(side, error, change, doubt_of(state))
    p_value = float(scipy.stats.chi2.sf(max(seen.z, 0.0) ** 2, len(own))) * side.n
    if p_value > FRICTION_LEVEL or share < BROKEN_SHARE or seen.cluster_t < CLUSTERS:
        return None
    typical = np.sqrt(np.mean(rubs**2, axis=0)) * own
    along = _along_the_runs(state, joint)
    rms = float(np.sqrt(share * had / len(left)))
    lower = bool(np.sum(typical) < 0.0)
    goes_on = along is not None and along == lower
    left_open = _within_doubt(state, places, own)
    return OtherFriction(joint, share, rms, p_value, lower, goes_on, left_open)


def _power(rubs: Array, friction: Array) -> float:
    """W, summed over the samples, that friction of these coefficients takes."""
    return float((rubs @ friction) @ rubs[:, 1])


def _of_textbook(state: SearchState, joint: int) -> list[int]:
    """Which coefficients are what dry friction and friction by speed have there, as far as the
    model has them, in this order."""
    kinds = [t.effect for t in state.terms]
    own = [
        (not kind.smoothed_over, state.place(index).start)
        for index, kind in enumerate(kinds)
        if kind.question == "textbook" and kind.rubs and state.terms[index].joints == (joint,)
    ]
    return [place for _, place in sorted(own)]


def _within_doubt(state: SearchState, places: list[int], own: Array) -> bool:
    """May the coefficients as well be that far from where they are? Asked of the errors that a
    model states, which know of what it lacks: a joint that was warmer is said of the arm."""
    if len(places) != len(own):
        return False
    covariance = honest_covariance(state)[np.ix_(places, places)]
    away = float(own @ np.linalg.pinv(covariance, hermitian=True) @ own)
    return float(scipy.stats.chi2.sf(away, len(own))) * state.held.n > FRICTION_LEVEL


def _along_the_runs(state: SearchState, joint: int) -> bool | None:
    """Does its friction fall in the course of the fitted runs (coefficients that move with time,
    Farley & Hinich 1970), or rise? None: neither is more than noise."""
    fit = state.fit
    t, rubs = _motion(state.train, joint)
    part = own_part(fit, {joint: t[:, None] * rubs / fit.sigma[joint]})
    if part is None:
        return None
    power = fit_side_power(state.train, fit.residual, part.change)
    if float(scipy.stats.chi2.sf(power, part.size)) * state.train.n > SEARCH_LEVEL:
        return None
    return bool(np.sqrt(np.mean(rubs**2, axis=0)) @ part.theta < 0.0)


def _motion(side: Side, joint: int) -> tuple[Array, Array]:
    """(m_j,) s from the middle of its run, and (m_j, 2): which way and how fast it goes."""
    rows = []
    for run, context in zip(side.runs, side.contexts, strict=True):
        t = context.t[:: run.lowpass.factor]
        speed = context.dq[:: run.lowpass.factor, joint]
        rows.append(np.column_stack([t - t.mean(), np.sign(speed), speed]))
    found = side.gathered(rows, joint)
    return found[:, 0], found[:, 1:]
