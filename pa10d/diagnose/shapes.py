"""The nonlinear parameters of a candidate: a bounded search on the projected residual.

Variable projection: for every trial shape the linear coefficients (its own and the model's) are
solved in closed form, so only the shape itself is searched.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy

from pa10d.effects import Effect, Shape

Gain = Callable[[dict[str, float]], float]


def refine(effect: Effect, start: Shape, gain: Gain, evaluations: int = 15) -> dict[str, float]:
    """The shape near ``start`` with the largest gain, after so many evaluations for each of its
    parameters; choices (sides, signs) stay as they are."""
    free = [s for s in effect.shapes if s.scale != "choice" and s.name in start]
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

    steps = np.array([_step(effect, s.name, s.scale, start) for s in free])
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


def _step(effect: Effect, name: str, scale: str, start: Shape) -> float:
    """How far the starting grid leaves its neighbours apart, in the search's own scale."""
    if name == "rotor":
        return 0.25 * start["rotor"]
    by_effect = {
        ("position_friction", "qc"): 0.6 * start.get("w", 0.2),
        ("position_friction", "w"): 0.2 if start.get("wave") else 0.7,
        ("torque_ripple", "N"): 0.15,
        ("contact", "qs"): 0.08,
        ("stribeck", "delta"): 0.5,
        ("nonlinear_viscous", "p"): 0.5,
        ("backlash", "b"): 0.12,
    }
    return by_effect.get((effect.id, name), 0.7 if scale == "log" else 0.2)
