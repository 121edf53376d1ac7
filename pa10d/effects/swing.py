"""How far a link swings behind its motor on a spring, however far that is.

M·δ̈ + ∂τ/∂q̇·δ̇ + ∂τ/∂q·δ + K·δ + C·δ̇ = τ_link at q - δ, linear about the swing that the last pass has
found (Newton's method on the whole motion): the first pass is first order about the motor's angle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numba
import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics import sensitivities
from pa10d.effects.context import Context
from pa10d.effects.rotor import LIGHTEST, link_load

Array = NDArray[np.float64]
Three = tuple[Array, Array, Array]

SOFTEST = 0.02  # of a spring that gravity helps to bend: beyond, the link would fall over
DAMPED = 0.005, 0.7  # damping ratios that a gear may have
SUBSTEPS = 6.0  # per radian of the spring's own oscillation
PASSES = 6  # at most
SWUNG = 0.01  # of the farthest lag: a pass that moves no link by more was the last, for what is
#   left then is the square of that
MOST_STEPS = 1000  # of a sample: bodies that no arm has may have any mode
RUNS_AWAY = 1e100
FURTHEST = 1.0  # rad: no gear twists further


@dataclass(frozen=True)
class Spring:
    """K N·m/rad, C N·m·s/rad and the inertia in kg·m² that stays on the motor's side."""

    joint: int
    stiffness: float
    damping: float
    rotor: float


@dataclass(frozen=True)
class Swing:
    """What links behind E springs do together. lag (3, N, E): δ, δ̇, δ̈; motion: q, q̇, q̈ with the
    links' in the motors' place, (N, n) each; slopes: of all joints' torque by these, (E, N, n)
    each; equation: mass, drag, stiffness (N, E, E); grip (E, E) N·m/rad: what holds the links where
    they begin, ``still_grip``."""

    lag: Array
    motion: Three
    slopes: Three
    equation: Three
    grip: Array

    @classmethod
    def once(cls, context: Context, springs: Sequence[Spring]) -> Swing | None:
        """``of`` these springs, in the order of their joints: worked out once for a context,
        while these are asked for."""
        there = tuple(sorted(springs, key=lambda s: s.joint))
        if there not in context.swings:
            context.swings.clear()  # of other springs nobody asks any more
            context.swings[there] = cls.of(context, there)
        found = context.swings[there]
        return found if isinstance(found, cls) else None

    @classmethod
    def of(cls, context: Context, springs: Sequence[Spring], passes: int = PASSES) -> Swing | None:
        """With the context's rigid bodies. None: farther than any gear twists."""
        joints = [s.joint for s in springs]
        held, damped, rotors = np.array([(s.stiffness, s.damping, s.rotor) for s in springs]).T
        own = np.arange(len(joints))
        started = np.array([context.wound.get(j, (0.0, 0.0)) for j in joints])
        behind, lag = context, np.zeros((3, len(context.q), len(joints)))
        for _ in range(passes):
            load = np.column_stack([link_load(behind, s.joint, s.rotor) for s in springs])
            by = [behind.sensitivity(j) for j in joints]
            slopes = tuple(np.stack([one[order] for one in by]) for order in range(3))
            soft, drag, mass = (x[:, :, joints].transpose(1, 2, 0).copy() for x in slopes)
            seen = mass[:, own, own]
            lightest = np.maximum(LIGHTEST * np.abs(seen).max(axis=0), 1e-6)
            mass[:, own, own] = np.maximum(seen - rotors, lightest)
            push = load + sum(
                np.einsum("tke,te->tk", x, y) for x, y in zip((soft, drag, mass), lag, strict=True)
            )
            grip = still_grip(behind, joints, held)
            rest = still_load(behind)[joints] + (grip - np.diag(held)) @ lag[0, 0] + started[:, 0]
            stiff = soft
            stiff[:, own, own] = np.maximum(soft[:, own, own] + held, SOFTEST * held)
            drag[:, own, own] += damped
            equation = mass, drag, stiff
            if not all(np.isfinite(x).all() for x in (push, rest, grip, *equation)):
                return None
            before, where = lag[0], np.linalg.solve(grip, rest)
            fast = started[:, 1] / held
            lag = driven(push[:, :, None], where[:, None], fast[:, None], equation, context.dt)
            lag = lag[:, :, :, 0]
            farthest = np.abs(lag[0]).max()
            if not farthest < FURTHEST:
                return None
            behind = _behind(context, joints, lag)
            if np.abs(lag[0] - before).max() < SWUNG * farthest:
                break
        motion = behind.q, behind.dq, behind.ddq
        return cls(lag, motion, (slopes[0], slopes[1], slopes[2]), equation, grip)


def swung_freely(context: Context, springs: Sequence[Spring], shares: Sequence[float]) -> Array:
    """(N, n, E, 2) by which the torque of all joints changes with how each of E springs' links
    begins: per N·m that more is wound up in it, and per N·m/s that this grows by.

    shares: of each spring's torque that the joints show. To first order about the swing where that
    is known, else about the motors' motion.
    """
    there = tuple(sorted(springs, key=lambda s: s.joint))
    swing = context.swings.get(there) or Swing.of(context, there, passes=1)
    count, samples = len(there), len(context.q)
    out = np.zeros((samples, context.robot.n, count, 2))
    if not isinstance(swing, Swing):
        return out
    where, fast = np.zeros((2, count, 2 * count))
    where[:, 0::2] = np.linalg.solve(swing.grip, np.eye(count))
    fast[range(count), range(1, 2 * count, 2)] = [1.0 / spring.stiffness for spring in there]
    still = np.zeros((samples, count, 2 * count))
    moved = driven(still, where, fast, swing.equation, context.dt)
    of = dict(zip((s.joint for s in springs), shares, strict=True))
    flat = out.reshape(samples, context.robot.n, -1)
    for e, spring in enumerate(there):
        for by, change in zip(swing.slopes, moved, strict=True):
            flat -= of[spring.joint] * by[e][:, :, None] * change[:, e][:, None, :]
        flat[:, spring.joint] += of[spring.joint] * spring.rotor * moved[2][:, e]
    order = [there.index(spring) for spring in springs]
    return out[:, :, order]


def still_load(context: Context) -> Array:
    """(n,) N·m that the joints bear where the arm hangs in its first pose."""
    rest = np.zeros_like(context.q[:1])
    return np.asarray(context.rigid_torque(context.q[:1], rest, rest)[0])


def still_grip(context: Context, joints: Sequence[int], stiffness: Array) -> Array:
    """(E, E) N·m/rad that hold links behind springs of these stiffnesses (E,) where they hang in
    the first pose: the springs', and what gravity adds."""
    rest, own = np.zeros_like(context.q[:1]), np.arange(len(joints))
    soft = sensitivities(context.robot, context.rigid, context.q[:1], rest, rest)[0]
    grip = soft[joints, 0][:, joints].T.copy()
    grip[own, own] = np.maximum(grip[own, own] + stiffness, SOFTEST * stiffness)
    return grip


def _behind(context: Context, joints: Sequence[int], lag: Array) -> Context:
    """The same with the links' motion in the motors' place."""
    moved = context.q.copy(), context.dq.copy(), context.ddq.copy()
    for x, behind in zip(moved, lag, strict=True):
        x[:, joints] -= behind
    q, dq, ddq = moved
    return replace(context, q=q, dq=dq, ddq=ddq)


def driven(load: Array, where: Array, fast: Array, equation: Three, dt: float) -> Array:
    """δ, δ̇, δ̈ (3, N, E, S) of mass·δ̈ + drag·δ̇ + stiff·δ = load (N, E, S), from ``where`` the links
    are in the first sample and how ``fast`` (E, S); equation (N, E, E) each."""
    if load.shape[1] > 1:
        begins = np.ascontiguousarray(where), np.ascontiguousarray(fast)
        return np.asarray(driven_lags(load, *begins, *equation, dt))
    alone = (np.ascontiguousarray(x[:, 0, 0]) for x in equation)
    load = np.ascontiguousarray(load[:, 0])
    return np.asarray(driven_lag(load, where[0], fast[0], *alone, dt)[:, :, None])


@numba.njit(cache=True, nogil=True)
def driven_lags(load, where, fast, mass, drag, stiff, dt):
    """``driven`` of several springs, by the rule of ``driven_lag``."""
    n, springs, lanes = load.shape
    out = np.zeros((3, n, springs, lanes))
    x, v = where.copy(), fast.copy()
    for k in range(n):
        b = max(k - 1, 0)
        heaviest = np.ascontiguousarray(mass[k])
        highest = np.trace(np.linalg.solve(heaviest, np.ascontiguousarray(stiff[k])))
        steps = max(1, int(np.ceil(np.sqrt(max(highest, 0.0)) * dt * SUBSTEPS)))
        steps = min(steps, MOST_STEPS)
        h = dt / steps if k else 0.0
        for s in range(steps if k else 0):
            w = (s + 0.5) / steps
            m, c = mass[b] + (mass[k] - mass[b]) * w, drag[b] + (drag[k] - drag[b]) * w
            slope = stiff[b] + (stiff[k] - stiff[b]) * w
            heavy = m + 0.5 * h * c + 0.25 * h * h * slope
            push = load[b] + (load[k] - load[b]) * w
            a = np.linalg.solve(heavy, push - slope @ x - (c + 0.5 * h * slope) @ v)
            x = x + h * v + 0.5 * h * h * a
            v = v + h * a
            if not np.all(np.abs(x) + np.abs(v) < RUNS_AWAY):
                out[:] = np.inf
                return out
        out[0, k], out[1, k] = x, v
        left = load[k] - np.ascontiguousarray(stiff[k]) @ x - np.ascontiguousarray(drag[k]) @ v
        out[2, k] = np.linalg.solve(heaviest, left)
    return out


@numba.njit(cache=True, nogil=True, error_model="numpy", fastmath={"nsz", "contract", "arcp"})
def driven_lag(load, where, fast, mass, drag, stiff, dt):
    """δ, δ̇, δ̈ (3, N, S) of mass·δ̈ + drag·δ̇ + stiff·δ = load (N, S), from ``where`` the link is in
    the first sample and how ``fast`` (S,); all others (N,). Implicit midpoint rule, as
    ``mean_lag``."""
    n, lanes = load.shape
    out = np.zeros((3, n, lanes))
    x, v = where.copy(), fast.copy()
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
