"""How far a link swings behind its motor on a spring, however far that is.

M·δ̈ + ∂τ/∂q̇·δ̇ + ∂τ/∂q·δ + K·δ + C·δ̇ = τ_link at q - δ, linear about the swing that the last pass has
found (Newton's method on the whole motion): the first pass is first order about the motor's angle.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numba
import numpy as np
from numpy.typing import NDArray

from pa10d.effects.context import Context
from pa10d.effects.rotor import LIGHTEST, link_load

Array = NDArray[np.float64]
Three = tuple[Array, Array, Array]

SOFTEST = 0.02  # of a spring that gravity helps to bend: beyond, the link would fall over
SUBSTEPS = 6.0  # per radian of the spring's own oscillation
PASSES = 2  # what is left is the square of the square of a lag
FURTHEST = 1.0  # rad: no gear twists further


@dataclass(frozen=True)
class Swing:
    """lag (3, N): δ, δ̇, δ̈; motion: q, q̇, q̈ with the link's in the motor's place, (N, n) each;
    slopes: of all joints' torque by these, (N, n) each; equation: mass, drag, stiffness (N,)."""

    lag: Array
    motion: Three
    slopes: Three
    equation: Three

    @classmethod
    def of(
        cls,
        context: Context,
        joint: int,
        stiffness: float,
        damping: float,
        rotor: float,
    ) -> Swing | None:
        """None: farther than any gear twists.

        The context's rigid bodies; N·m/rad, N·m·s/rad and kg·m² on the motor's side.
        """
        behind, lag = context, np.zeros((3, len(context.q)))
        for done in range(PASSES):
            if done:
                behind = _behind(context, joint, lag)
            load = link_load(behind, joint, rotor)
            by_q, by_dq, by_ddq = behind.sensitivity(joint)
            soft, drag, seen = (np.ascontiguousarray(by[:, joint]) for by in (by_q, by_dq, by_ddq))
            mass = np.maximum(seen - rotor, max(LIGHTEST * float(np.abs(seen).max()), 1e-6))
            push = load + soft * lag[0] + drag * lag[1] + mass * lag[2]
            equation = mass, drag + damping, np.maximum(soft + stiffness, SOFTEST * stiffness)
            more, rate = context.wound.get(joint, (0.0, 0.0))
            rest = still_load(behind, joint) + soft[0] * lag[0, 0] + more
            rates = np.array([rate])
            lag = driven_lag(push[:, None], rest, rates, *equation, context.dt)[:, :, 0]
            if not np.all(np.abs(lag[0]) < FURTHEST):
                return None
        there = _behind(context, joint, lag)
        return cls(lag, (there.q, there.dq, there.ddq), (by_q, by_dq, by_ddq), equation)


def still_load(context: Context, joint: int) -> Array:
    """(1,) N·m that the joint bears where it hangs in its first pose."""
    rest = np.zeros_like(context.q[:1])
    return np.asarray(context.rigid_torque(context.q[:1], rest, rest)[:, joint])


def _behind(context: Context, joint: int, lag: Array) -> Context:
    """The same with the link's motion in the motor's place."""
    moved = context.q.copy(), context.dq.copy(), context.ddq.copy()
    for x, behind in zip(moved, lag, strict=True):
        x[:, joint] -= behind
    q, dq, ddq = moved
    return replace(context, q=q, dq=dq, ddq=ddq)


@numba.njit(cache=True, nogil=True, error_model="numpy", fastmath={"nsz", "contract", "arcp"})
def driven_lag(load, rest, rates, mass, drag, stiff, dt):
    """δ, δ̇, δ̈ (3, N, S) of mass·δ̈ + drag·δ̇ + stiff·δ = load (N, S), from where the loads rest (S,)
    wind it and from what rates (S,) they grow by; all others (N,). Implicit midpoint rule, as
    ``mean_lag``: a measured acceleration is too noisy to say where a soft spring begins."""
    n, lanes = load.shape
    out = np.zeros((3, n, lanes))
    x, v = rest / stiff[0], rates / stiff[0]
    for k in range(n):
        b = max(k - 1, 0)
        steps = max(1, int(np.ceil(np.sqrt(stiff[k] / mass[k]) * dt * SUBSTEPS)))
        h = dt / steps if k else 0.0
        for s in range(steps):
            w = (s + 0.5) / steps
            m, c = mass[b] + (mass[k] - mass[b]) * w, drag[b] + (drag[k] - drag[b]) * w
            slope = stiff[b] + (stiff[k] - stiff[b]) * w
            heavy = m + 0.5 * h * c + 0.25 * h * h * slope
            for i in range(lanes):
                push = load[b, i] + (load[k, i] - load[b, i]) * w
                a = (push - slope * x[i] - (c + 0.5 * h * slope) * v[i]) / heavy
                x[i] += h * v[i] + 0.5 * h * h * a
                v[i] += h * a
        for i in range(lanes):
            out[0, k, i], out[1, k, i] = x[i], v[i]
            out[2, k, i] = (load[k, i] - stiff[k] * x[i] - drag[k] * v[i]) / mass[k]
    return out
