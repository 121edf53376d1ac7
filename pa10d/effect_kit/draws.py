"""Random cases of an effect: shapes, coefficients and motions of any kind that it may meet."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics import Robot
from pa10d.effects import Context, Effect
from pa10d.effects.context import posed
from pa10d.model import Term

Array = NDArray[np.float64]

RATE = 250.0  # Hz
PUSH = 20.0  # N·m, about what the drawn effect amounts to


@dataclass(frozen=True)
class Path:
    """t (N,) s; q, dq, ddq (N, n) of one motion."""

    t: Array
    q: Array
    dq: Array
    ddq: Array


def path(rng: np.random.Generator, robot: Robot, samples: int) -> Path:
    """Sums of sines, slow ones and fast ones, with reversals."""
    t = np.arange(samples) / RATE
    omega = np.exp(rng.uniform(np.log(0.5), np.log(20.0), (robot.n, 3)))
    angle = omega * t[:, None, None] + rng.uniform(0.0, 2 * np.pi, (robot.n, 3))
    size = rng.uniform(0.1, 0.6) / np.maximum(omega, 1.0)
    middle = rng.uniform(-1.0, 1.0, robot.n)
    q = middle + np.sum(size * np.sin(angle), axis=2)
    dq = np.sum(size * omega * np.cos(angle), axis=2)
    return Path(t, q, dq, np.sum(-size * omega**2 * np.sin(angle), axis=2))


def context(robot: Robot, path: Path, rigid: Array | None = None) -> Context:
    """The motion with the loads of these bodies, those of the URDF unless given."""
    seen = posed(robot, path.q, path.dq, path.ddq, path.t)
    known = replace(seen, rigid=robot.parameters if rigid is None else rigid)
    rubbing = 2.0 * np.tanh(path.dq / 0.05) + path.dq
    return replace(known, total=known.load + rubbing, rubbing=rubbing)


def shape(
    rng: np.random.Generator,
    kind: Effect,
    like: Context,
    at: tuple[int, ...],
    whole: bool = False,
) -> dict[str, float]:
    """Anywhere within the bounds; where an angle without a scale is meant, near the motion; at:
    joints, 0-based; whole: with all that only some joints have."""
    found = {}
    for s in kind.shapes:
        if s.optional and not whole and rng.random() < 0.5:
            continue
        low, high = s.lower, s.upper
        if s.scale == "choice":
            found[s.name] = float(rng.choice([low, high]))
        elif s.scale == "log":
            if s.unit == "N·m/rad":  # a gear gives way by less than a radian under the arm's loads
                low = max(low, float(np.abs(like.load).max()))
            found[s.name] = float(np.exp(rng.uniform(np.log(low), np.log(high))))
        elif s.unit == "rad" and high - low > 10.0:
            found[s.name] = float(rng.uniform(like.q.min(), like.q.max()))
        else:
            if s.unit == "kg·m²":  # a rotor is part of what its joint moves; else no link is left
                high = min(high, *(float(like.inertia_seen(j).min()) for j in at))
            found[s.name] = float(rng.uniform(low, high))
    return found


def joints(rng: np.random.Generator, kind: Effect, robot: Robot) -> tuple[int, ...]:
    """Where it sits, 0-based."""
    count = {"joint": 1, "pair": 2, "robot": 0}[kind.scope]
    return tuple(int(j) for j in rng.choice(robot.n, count, replace=False))


def term(rng: np.random.Generator, kind: Effect, seen: Context) -> Term:
    """The effect at work: anywhere, of any shape, with coefficients of a likely size."""
    at = joints(rng, kind, seen.robot)
    form = shape(rng, kind, seen, at)
    columns = kind.columns(seen, at, form).reshape(-1, len(kind.coefficients))
    size = PUSH / np.maximum(np.sqrt(np.mean(columns**2, axis=0)), 1e-2 * PUSH)
    low = np.array([c.lower for c in kind.coefficients])
    high = np.array([c.upper for c in kind.coefficients])
    theta = np.clip(size * rng.uniform(-1.0, 1.0, len(size)), low, high)
    if rng.random() < 0.5:  # as it stands in a model once it has been linearised about its answer
        form = kind.relinearised(theta, form)
    return Term(kind.id, at, theta, dict(form))
