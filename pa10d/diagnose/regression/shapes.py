"""The nonlinear parameters of a candidate: a bounded search on the projected residual.

Variable projection: for every trial shape the linear coefficients (its own and the model's) are
solved in closed form, so only the shape itself is searched.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.diagnose.constants import STEP_SHARES, WORTH_A_STEP
from pa10d.effects import Effect, Shape
from pa10d.effects.base import ShapeParameter

Gain = Callable[[dict[str, float]], float]
Move = Callable[[dict[str, float]], NDArray[np.float64]]


def free_shapes(effect: Effect, shape: Shape) -> list[ShapeParameter]:
    """What may vary: all but choices (sides, signs)."""
    return [s for s in effect.shapes if s.scale != "choice" and s.name in shape]


def around(effect: Effect, shape: Shape, part: float = 1.0) -> list[dict[str, float]]:
    """Shapes up to such a part of a step of the search away in every parameter that is free, five
    of each."""
    free = free_shapes(effect, shape)
    out = []
    for shares in product((-1.0, -0.5, 0.0, 0.5, 1.0), repeat=len(free)):
        trial = dict(shape)
        for s, share in zip(free, shares, strict=True):
            far = share * part * s.step_at(shape)
            value = shape[s.name] * np.exp(far) if s.scale == "log" else shape[s.name] + far
            trial[s.name] = float(np.clip(value, s.lower, s.upper))
        out.append(trial)
    return out


def refine(effect: Effect, start: Shape, gain: Gain, evaluations: int = 15) -> dict[str, float]:
    """The shape near ``start`` with the largest gain, after so many evaluations for each of its
    parameters; choices (sides, signs) stay as they are."""
    free = free_shapes(effect, start)
    if not free:
        return dict(start)

    def inside(x: np.ndarray) -> dict[str, float]:
        trial = dict(start)
        for s, value in zip(free, x, strict=True):
            actual = np.exp(value) if s.scale == "log" else value
            trial[s.name] = float(np.clip(actual, s.lower, s.upper))
        return trial

    def cost(x: np.ndarray) -> float:
        return -gain(inside(np.atleast_1d(x)))

    steps = np.array([s.step_at(start) for s in free])
    origin = np.array([np.log(start[s.name]) if s.scale == "log" else start[s.name] for s in free])
    if len(free) == 1:
        found = scipy.optimize.minimize_scalar(
            lambda x: cost(np.array([x])),
            bounds=(origin[0] - 1.2 * steps[0], origin[0] + 1.2 * steps[0]),
            method="bounded",
            options={"maxiter": evaluations, "xatol": 0.02 * steps[0]},
        )
        best = np.array([found.x])
    else:
        simplex = np.vstack([origin, origin + np.diag(0.6 * steps)])
        found = scipy.optimize.minimize(
            cost,
            origin,
            method="Nelder-Mead",
            options={
                "initial_simplex": simplex,
                "maxfev": evaluations * len(free),
                "xatol": 0,
                "fatol": 0,
            },
        )
        best = found.x
    return inside(best) if -cost(best) >= gain(dict(start)) else dict(start)


def approach(
    effect: Effect, start: Shape, gain: Gain, move: Move, steps: int = 4
) -> dict[str, float]:
    """A shape with a larger gain than ``start``, along Gauss-Newton's directions, each halved until
    it brings something.

    Where the torque is smooth in its shape this ends at the best shape nearby, to a fraction of
    its standard error, which a search without derivatives does not within as many evaluations.
    """
    free = free_shapes(effect, start)
    best, most = dict(start), gain(dict(start))
    for _ in range(steps if free else 0):
        wanted, before = move(best), most
        for share in STEP_SHARES:
            trial = dict(best)
            for s, change in zip(free, wanted, strict=True):
                trial[s.name] = _moved(s, best, share * change)
            reached = gain(trial)
            if reached > most:
                best, most = trial, reached
                break
        if most < before + WORTH_A_STEP:
            break
    return best


def _moved(s: ShapeParameter, shape: Shape, change: float) -> float:
    """The parameter after a change, which on its own scale goes no further than the neighbours of
    a starting grid stand apart."""
    value, far = shape[s.name], s.step_at(shape)
    if s.scale == "log":
        value = float(value * np.exp(np.clip(change / value, -far, far)))
    else:
        value = float(value + np.clip(change, -far, far))
    return float(np.clip(value, s.lower, s.upper))
