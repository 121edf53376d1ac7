"""The link's lag behind the encoder through a spring with an optional gap.

Between rotor (where the encoder sits, angle q) and link (angle q - δ) the transmission passes
the torque p(δ) + C·δ̇, where p is a spring with a dead zone of ±gap; across a gap, teeth push and
never pull. With τ_load the torque that a rigid joint would need, the link obeys, to first order
in δ, M_jj·δ̈ + ∂τ/∂q̇·δ̇ + ∂τ/∂q·δ + p(δ) + C·δ̇ = τ_load. Integrated causally at the raw rate with
sub-steps; the torque of all joints then follows, to first order in δ (exact in δ̈), from the rigid
bodies moving with the link instead of the encoder.

Spong, Modeling and control of elastic joint robots (1987).
"""

from __future__ import annotations

from collections.abc import Sequence

import numba
import numpy as np
from numpy.typing import NDArray

from pa10d.effects.context import Context

Array = NDArray[np.float64]

SUBSTEPS = 6.0  # per radian of the spring's own oscillation


def twisted_torque(
    context: Context, joint: int, stiffness: float, zeta: float, gaps: Sequence[float] = (0.0,)
) -> Array:
    """Δτ (N, n) N·m that a compliant joint adds to the rigid model.

    stiffness N·m/rad, zeta: damping ratio on that stiffness at the joint's typical inertia, gaps:
    half widths in rad, over which the motion of the link is averaged.
    """
    inertia = context.inertia_seen(joint)
    damping = 2.0 * zeta * float(np.sqrt(stiffness * context.typical_inertia[joint]))
    by_q, by_dq, by_ddq = context.sensitivity(joint)
    link = [np.ascontiguousarray(a[:, joint]) for a in (context.load, by_q, by_dq)]
    return _twisted(
        *link, by_q, by_dq, by_ddq, inertia, stiffness, damping, np.array(gaps), context.dt
    )


@numba.njit(cache=True, nogil=True)
def _twisted(load, own_q, own_dq, by_q, by_dq, by_ddq, inertia, stiffness, damping, gaps, dt):
    """-(∂τ/∂q·δ + ∂τ/∂q̇·δ̇ + ∂τ/∂q̈·δ̈) with the mean δ over the gaps, (N, n) N·m."""
    n, joints = by_q.shape
    delta, rate, acceleration = np.zeros(n), np.zeros(n), np.zeros(n)
    for gap in gaps:
        x, v, a = lag(load, own_q, own_dq, inertia, stiffness, damping, gap, dt)
        delta += x
        rate += v
        acceleration += a
    out, share = np.zeros((n, joints)), 1.0 / len(gaps)
    # far from the model's validity the integration may run away: no torque is better than inf
    for k in range(n):
        if not abs(share * delta[k]) <= 1.0:
            return out
    for k in range(n):
        x, v, a = share * delta[k], share * rate[k], share * acceleration[k]
        for j in range(joints):
            out[k, j] = -(by_q[k, j] * x + by_dq[k, j] * v + by_ddq[k, j] * a)
    return out


@numba.njit(cache=True, nogil=True)
def lag(load, by_q, by_dq, inertia, stiffness, damping, gap, dt):
    """δ, δ̇, δ̈ (N,) of the driven oscillator, from its static equilibrium at the first sample.

    load N·m, by_q N·m/rad, by_dq N·m·s/rad, inertia kg·m², (N,): the link's equation
    """
    n = len(load)
    delta, rate, acceleration = np.empty(n), np.empty(n), np.empty(n)
    side = 1.0 if load[0] >= 0 else -1.0
    x, v = load[0] / stiffness + side * gap, 0.0
    for k in range(n):
        steps = max(1, int(np.ceil(np.sqrt(stiffness / inertia[k]) * dt * SUBSTEPS)))
        h = dt / steps
        b = max(k - 1, 0)
        for s in range(steps):
            w = (s + 0.5) / steps  # everything known is taken at the sub-step's middle
            m = inertia[b] + (inertia[k] - inertia[b]) * w
            spring, c, slope = _grip(x, v, stiffness, damping, gap)
            soft, drag = by_q[b] + (by_q[k] - by_q[b]) * w, by_dq[b] + (by_dq[k] - by_dq[b]) * w
            slope, c = slope + soft, c + drag
            force = load[b] + (load[k] - load[b]) * w - spring - soft * x
            # linearly implicit midpoint: stable for any stiffness, second order
            a = (force - c * v - 0.5 * h * slope * v) / (m + 0.5 * h * c + 0.25 * h * h * slope)
            x += h * v + 0.5 * h * h * a
            v += h * a
        spring, c, slope = _grip(x, v, stiffness, damping, gap)
        delta[k], rate[k] = x, v
        acceleration[k] = (load[k] - spring - c * v - by_q[k] * x - by_dq[k] * v) / inertia[k]
    return delta, rate, acceleration


@numba.njit(cache=True, nogil=True)
def _grip(x, v, stiffness, damping, gap):
    """(spring torque, damping, stiffness) of the transmission at twist x and its rate v."""
    if abs(x) <= gap:
        return 0.0, 0.0, 0.0
    side = 1.0 if x > 0.0 else -1.0
    spring = stiffness * (x - side * gap)
    if gap > 0.0 and (spring + damping * v) * side < 0.0:
        return 0.0, 0.0, 0.0
    return spring, damping, stiffness
