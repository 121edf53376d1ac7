"""The link's lag behind the encoder through a spring with an optional gap.

Between rotor (where the encoder sits, angle q) and link (angle q - δ) the transmission passes
the torque p(δ) + C·δ̇, where p is a spring with a dead zone of ±gap; across a gap, teeth push and
never pull. With τ_load the torque that a rigid joint would need, the link obeys, to first order
in δ, M_jj·δ̈ + ∂τ/∂q̇·δ̇ + ∂τ/∂q·δ + p(δ) + C·δ̇ = τ_load. Integrated causally at the raw rate with
sub-steps; the torque of all joints then follows, to first order in δ (exact in δ̈), from the rigid
bodies moving with the link instead of the encoder. Of a spring that is wound farther, what it adds
is taken from the bodies as they move with the link (``closely``); trials of a search stay rough.

Spong, Modeling and control of elastic joint robots (1987).
"""

from __future__ import annotations

from collections.abc import Sequence

import numba
import numpy as np
from numpy.typing import NDArray

from pa10d.effects.context import Context
from pa10d.effects.rotor import link_inertia, link_load, typical_link
from pa10d.effects.swing import SOFTEST, SUBSTEPS, Spring, Swing, still_grip, still_load

Array = NDArray[np.float64]

SMALL = 0.02  # rad: below, the second order is a hundredth of the first


def twisted_torque(
    context: Context,
    joint: int,
    stiffness: float,
    zeta: float,
    gaps: Sequence[Sequence[float]] = ((0.0,),),
    rotor: float = 0.0,
    own: bool = False,
    closely: bool = False,
) -> Array:
    """Δτ (N, n, S) N·m that a compliant joint adds to the rigid model; own: (N, S), its own.

    stiffness N·m/rad, zeta: damping ratio on that stiffness at the link's typical inertia, gaps
    (S, E): half widths in rad, E of each case, over which the motion of its link is averaged;
    rotor: kg·m² of what the rigid bodies count to the link and sits on the motor's side; closely:
    beyond first order from the first sample on at which a spring without a gap is wound far.
    """
    by_q, by_dq, by_ddq = context.sensitivity(joint)
    load, wide = link_load(context, joint, rotor), np.array(gaps, float)
    reach = slice(joint, joint + 1) if own else slice(None)
    if context.apart:
        still = static_lag(load, by_q[:, joint], stiffness, wide)
        torque = -by_q[:, reach, None] * still[:, None, :]
        return torque[:, 0] if own else torque
    damping = _damping(context, joint, stiffness, zeta, rotor)
    others = springs_of(context)
    if len(others) > 1 and not wide.any() and any(s.joint == joint for s in others):
        alone = Spring(joint, stiffness, damping, rotor)
        torque = _among(context, (alone, *(s for s in others if s.joint != joint)))[:, reach]
        return torque[:, 0] if own else torque
    inertia = link_inertia(context, joint, rotor)
    soft, drag = (np.ascontiguousarray(a[:, joint]) for a in (by_q, by_dq))
    begins = load[0] / stiffness + np.where(load[0] >= 0.0, 1.0, -1.0) * wide, 0.0
    if joint in context.wound and not wide.any():
        more, rate = context.wound[joint]
        grip = float(still_grip(context, [joint], np.array([stiffness]))[0, 0])
        begins = (still_load(context)[joint] + more) / grip + wide, rate / stiffness
    twist = mean_lag(load, soft, drag, inertia, stiffness, damping, wide, *begins, context.dt)
    # far from the model's validity the integration may run away: no torque is better than inf
    twist[:, :, ~(np.abs(twist[:, 0]) <= 1.0).all(axis=0)] = 0.0
    torque = _torque(by_q[:, reach], by_dq[:, reach], by_ddq[:, reach], twist)
    torque[:, 0 if own else joint] += rotor * twist[:, 2]
    if closely and not wide.any() and np.abs(twist[:, 0]).max() > SMALL:
        far = np.maximum.accumulate(np.abs(twist[:, 0, 0])) > SMALL
        swing = Swing.once(context, (Spring(joint, stiffness, damping, rotor),))
        if swing is not None:  # what comes later must not change what was
            whole = context.rigid_torque(*swing.motion) - context.load
            whole[:, joint] += rotor * swing.lag[2][:, 0]
            torque[far, :, 0] = whole[far][:, reach]
    return torque[:, 0] if own else torque


def springs_of(context: Context) -> list[Spring]:
    """The model's gears that give."""
    return [Spring(j, k, _damping(context, j, k, z, r), r) for j, k, z, r in context.springs]


def _damping(context: Context, joint: int, stiffness: float, zeta: float, rotor: float) -> float:
    """N·m·s/rad."""
    return 2.0 * zeta * float(np.sqrt(stiffness * typical_link(context, joint, rotor)))


def _among(context: Context, springs: Sequence[Spring]) -> Array:
    """(N, n, 1) N·m of the first of several springs whose links swing together: what its own lag
    adds to first order, and its share of what all of them add beyond that."""
    swing = Swing.once(context, springs)
    if swing is None:
        return np.zeros((*context.q.shape, 1))
    parts = [
        -sum(by[e] * lag[:, e, None] for by, lag in zip(swing.slopes, swing.lag, strict=True))
        for e in range(len(springs))
    ]
    first = sum(s.joint < springs[0].joint for s in springs)
    whole = context.rigid_torque(*swing.motion) - context.load
    beyond = (whole - sum(parts)) / len(springs)
    torque = parts[first] + beyond
    torque[:, springs[0].joint] += springs[0].rotor * swing.lag[2][:, first]
    return np.asarray(torque[:, :, None])


def static_lag(load: Array, by_q: Array, stiffness: float, gaps: Array) -> Array:
    """δ (N, S) of a link that hangs still, its teeth on the side of its load."""
    side = np.where(load >= 0.0, 1.0, -1.0)
    grip = np.maximum(stiffness + by_q, SOFTEST * stiffness)
    still = (load / grip)[:, None] + (side * stiffness / grip)[:, None] * gaps.mean(axis=1)
    return np.asanyarray(np.clip(still, -1.0, 1.0))  # rad: no gear twists further


@numba.njit(cache=True, nogil=True)
def _torque(by_q, by_dq, by_ddq, twist):
    """-(∂τ/∂q·δ + ∂τ/∂q̇·δ̇ + ∂τ/∂q̈·δ̈), (N, joints, S) N·m."""
    (n, joints), cases = by_q.shape, twist.shape[2]
    out = np.zeros((n, joints, cases))
    for k in range(n):
        for j in range(joints):
            for i in range(cases):
                out[k, j, i] = -(
                    by_q[k, j] * twist[k, 0, i]
                    + by_dq[k, j] * twist[k, 1, i]
                    + by_ddq[k, j] * twist[k, 2, i]
                )
    return out


# Without Python's check for division by zero, and allowed to fuse products, the loop over gaps
# becomes vector instructions: three to four times as fast.
@numba.njit(cache=True, nogil=True, error_model="numpy", fastmath={"nsz", "contract", "arcp"})
def mean_lag(load, by_q, by_dq, inertia, stiffness, damping, gaps, begins, rate, dt):
    """δ, δ̇, δ̈ (N, 3, S) of the driven oscillator, the mean over each case's gaps (S, E).

    load N·m, by_q N·m/rad, by_dq N·m·s/rad, inertia kg·m², (N,): the link's equation; begins
    (S, E) rad and rate rad/s: δ and δ̇ at the first sample
    """
    n, (cases, each) = len(load), gaps.shape
    gap, lanes = gaps.ravel(), cases * each
    x, v, a = begins.copy().ravel(), np.full(lanes, rate), np.zeros(lanes)
    out = np.zeros((n, 3, cases))
    for k in range(n):
        steps = max(1, int(np.ceil(np.sqrt(stiffness / inertia[k]) * dt * SUBSTEPS)))
        h = dt / steps if k else 0.0
        b = max(k - 1, 0)
        gripped = 0.5 * h * damping + 0.25 * h * h * stiffness
        for s in range(steps):
            w = (s + 0.5) / steps  # everything known is taken at the sub-step's middle
            m = inertia[b] + (inertia[k] - inertia[b]) * w
            soft, drag = by_q[b] + (by_q[k] - by_q[b]) * w, by_dq[b] + (by_dq[k] - by_dq[b]) * w
            push = load[b] + (load[k] - load[b]) * w
            free = m + 0.5 * h * drag + 0.25 * h * h * soft
            for i in range(lanes):
                spring, grip = _grip(x[i], v[i], stiffness, damping, gap[i])
                slope, c = soft + grip * stiffness, drag + grip * damping
                # linearly implicit midpoint: stable for any stiffness, second order
                force = push - grip * spring - soft * x[i] - (c + 0.5 * h * slope) * v[i]
                a[i] = force / (free + grip * gripped)
                x[i] += h * v[i] + 0.5 * h * h * a[i]
                v[i] += h * a[i]
        for i in range(lanes):
            spring, grip = _grip(x[i], v[i], stiffness, damping, gap[i])
            slope, c = by_q[k], by_dq[k] + grip * damping
            a[i] = (load[k] - grip * spring - c * v[i] - slope * x[i]) / inertia[k]
        for i in range(cases):
            for e in range(i * each, (i + 1) * each):
                out[k, 0, i] += x[e] / each
                out[k, 1, i] += v[e] / each
                out[k, 2, i] += a[e] / each
    return out


@numba.njit(cache=True, nogil=True, inline="always")
def _grip(x, v, stiffness, damping, gap):
    """Spring torque of teeth that touch at twist x and its rate v, and 1.0 if they do or 0.0."""
    side = 1.0 if x > 0.0 else -1.0
    spring = stiffness * (x - side * gap)
    pushes = (gap == 0.0) | ((spring + damping * v) * side >= 0.0)
    return spring, 1.0 if (abs(x) > gap) & pushes else 0.0
