"""What an effect must not do: blow up, look ahead, keep things, use what it does not say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pa10d.dynamics import Robot
from pa10d.effect_kit import draws
from pa10d.effects import Context, Effect
from pa10d.effects.check import fault

SAMPLES = 120
SAME = 1e-9


def as_said(kind: Effect, robot: Robot, rng: np.random.Generator, count: int) -> str | None:
    """Texts, choices and parameters are there."""
    if (wrong := fault(kind)) is not None:
        return wrong
    if kind.example is None:
        return "'example' is missing, expected a typical case: its page shows it"
    if len(kind.example.coefficients) != len(kind.coefficients):
        return "'example' has another number of coefficients than the class"
    return None


def finite_columns(kind: Effect, robot: Robot, rng: np.random.Generator, count: int) -> str | None:
    """(N, k) or (N, n, k), finite, the same twice, and the run as it was."""
    k = len(kind.coefficients)
    for _ in range(count):
        seen = _run(rng, robot)
        at = draws.joints(rng, kind, robot)
        shape = draws.shape(rng, kind, seen, at)
        before = {name: getattr(seen, name).copy() for name in ("t", "q", "dq", "ddq", "total")}
        once = kind.columns(seen, at, shape)
        expected = (SAMPLES, robot.n, k) if kind.reaches_other_joints else (SAMPLES, k)
        if once.shape != expected:
            return f"columns have shape {once.shape}, expected {expected}"
        if not np.isfinite(once).all():
            return f"columns are not finite at {shape}"
        if any(not np.array_equal(getattr(seen, name), x) for name, x in before.items()):
            return "columns change the run that they are given"
        kind.columns(_run(rng, robot), at, shape)
        if not np.array_equal(once, kind.columns(seen, at, shape)):
            return "a second call gives other columns: it keeps something of the first"
    return None


def looks_back(kind: Effect, robot: Robot, rng: np.random.Generator, count: int) -> str | None:
    """What comes later changes nothing: one sample ahead may be looked at, for averages."""
    cut = SAMPLES // 2
    assert kind.example is not None
    for _ in range(count):
        one, other = _run(rng, robot), _run(rng, robot)
        at, shape = draws.joints(rng, kind, robot), dict(kind.example.shape)
        assert one.rubbing is not None
        assert other.rubbing is not None
        mixed = replace(
            one,
            q=np.concatenate([one.q[:cut], other.q[cut:]]),
            dq=np.concatenate([one.dq[:cut], other.dq[cut:]]),
            ddq=np.concatenate([one.ddq[:cut], other.ddq[cut:]]),
            total=np.concatenate([one.total[:cut], other.total[cut:]]),
            rubbing=np.concatenate([one.rubbing[:cut], other.rubbing[cut:]]),
        )
        whole, changed = kind.columns(one, at, shape), kind.columns(mixed, at, shape)
        size = max(1.0, float(np.max(np.abs(whole))))
        if np.max(np.abs(whole[: cut - 1] - changed[: cut - 1])) > SAME * size:
            return "samples depend on later ones: a controller does not know those"
    return None


def bounded_starts(kind: Effect, robot: Robot, rng: np.random.Generator, count: int) -> str | None:
    """A search begins within the bounds, with a value for every shape parameter."""
    for _ in range(count):
        at = draws.joints(rng, kind, robot)
        starts = kind.starts(_run(rng, robot), at)
        if not starts:
            return "'starts' gives no shape, expected at least one"
        for shape in starts:
            known = {s.name for s in kind.shapes_in(shape)}
            if set(shape) != known:
                return f"'starts' gives {sorted(shape)}, expected values for {sorted(known)}"
            for s in kind.shapes_in(shape):
                if not s.lower <= shape[s.name] <= s.upper:
                    return f"'starts' gives {s.name} = {shape[s.name]:g}, outside its bounds"
                if s.scale != "choice" and not s.step_at(shape) > 0.0:
                    return f"{s.name}: a search step of {s.step_at(shape):g}, expected more than 0"
    return None


def says_what_it_uses(
    kind: Effect, robot: Robot, rng: np.random.Generator, count: int
) -> str | None:
    """Columns that change with the model's loads or torques say so."""
    for _ in range(count):
        seen = _run(rng, robot)
        at = draws.joints(rng, kind, robot)
        shape = draws.shape(rng, kind, seen, at)
        other = replace(
            seen,
            rigid=1.3 * seen.rigid,
            total=1.7 * seen.total + 1.0,
            rubbing=None if seen.rubbing is None else 2.0 * seen.rubbing,
            ways=(0.004,) * robot.n,
            levels=np.full_like(seen.q, 1.3),
        )
        found = kind.columns(seen, at, shape), kind.columns(other, at, shape)
        if not kind.uses_model and not np.allclose(*found, rtol=1e-6):
            return "columns change with the rest of the model: expected uses_model = True"
    return None


def _run(rng: np.random.Generator, robot: Robot) -> Context:
    return draws.context(robot, draws.path(rng, robot, SAMPLES))
