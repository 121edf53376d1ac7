"""What an effect's numbers have to do: keep their units, follow their shape, stand alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pa10d.dynamics import Robot, base_parameters
from pa10d.effect_kit import draws
from pa10d.effect_kit.dimension import power_of_second
from pa10d.effects import Effect, Shape, ShapeParameter
from pa10d.effects.motions import motion
from pa10d.model import Term, TorqueModel

SLOWER = 2.0  # time is counted in half seconds
ROOM = 0.15  # of a power: a width or a frequency built in does not follow the clock
STEP = 1e-3  # of a shape parameter's own search step, in which columns have to be straight
ROUNDING = 1e-7  # of the columns: less is no change that tells anything
TRIES = 10  # random cases for one that counts
STRAIGHT = 0.9  # least cosine between the changes of a step and of half of it


def units(kind: Effect, robot: Robot, rng: np.random.Generator, count: int) -> str | None:
    """The example's run told in half seconds: every number changes as its unit says."""
    example = kind.example
    assert example is not None
    at = [j - 1 for j in example.joints]
    path = motion(example.motion, robot, at[-1])
    seen = draws.context(robot, draws.Path(path.t, path.q, path.dq, path.ddq))
    told = replace(
        seen,
        robot=robot.with_gravity(robot.gravity / SLOWER**2),
        t=seen.t * SLOWER,
        dq=seen.dq / SLOWER,
        ddq=seen.ddq / SLOWER**2,
        total=seen.total / SLOWER**2,
        rubbing=None,  # watts are compared with one watt: the clock decides how warm that is
    )
    here = replace(seen, rubbing=None)
    shape = dict(example.shape)
    powers = {s.name: power_of_second(s.unit, shape) for s in kind.shapes_in(shape)}
    other = {name: value * SLOWER ** powers.get(name, 0.0) for name, value in shape.items()}
    joints = at if kind.scope != "robot" else []
    columns, again = kind.columns(here, joints, shape), kind.columns(told, joints, other)
    for i, c in enumerate(kind.coefficients):
        expected = -2.0 - power_of_second(c.unit, shape)
        sizes = [float(np.sqrt(np.mean(x[..., i] ** 2))) for x in (columns, again)]
        if min(sizes) == 0.0:
            continue
        found = np.log(sizes[1] / sizes[0]) / np.log(SLOWER)
        if abs(found - expected) > ROOM:
            return (
                f"{c.name} in {c.unit}: told in half seconds its column changes by 2^{found:.2f}, "
                f"expected 2^{expected:.2f}: unit and formula do not agree"
            )
    return None


def smooth(kind: Effect, robot: Robot, rng: np.random.Generator, count: int) -> str | None:
    """Columns follow each shape parameter: a search goes along their change."""
    for s in kind.shapes:
        if s.scale == "choice" or s.blur:
            continue
        moved: list[float] = []
        for _ in range(TRIES * count):  # some shapes act where this motion does not come
            if len(moved) == count:
                break
            seen = draws.context(robot, draws.path(rng, robot, 240))
            at = draws.joints(rng, kind, robot)
            shape = draws.shape(rng, kind, seen, at, whole=True)
            here, whole, half = (
                kind.columns(seen, at, shape | {s.name: _stepped(s, shape, share)}).ravel()
                for share in (0.0, STEP, 0.5 * STEP)
            )
            sizes = [float(np.linalg.norm(x - here)) for x in (whole, half)]
            if min(sizes) > ROUNDING * max(float(np.linalg.norm(here)), 1e-6):
                moved.append(float((whole - here) @ (half - here)) / (sizes[0] * sizes[1]))
        if not moved:
            return f"{s.name} changes nothing, in any of {TRIES * count} random cases"
        if np.median(moved) < STRAIGHT:
            return f"columns jump with {s.name}: half a step changes something else than a step"
    return None


def alone(kind: Effect, robot: Robot, rng: np.random.Generator, count: int) -> str | None:
    """It predicts where nothing is measured: along a wanted motion and of a sample by itself."""
    for _ in range(count):
        path = draws.path(rng, robot, 40)
        term = draws.term(rng, kind, draws.context(robot, path))
        model = bare(robot, term)
        for time in (path.t, None):
            if not np.isfinite(model.torque(path.q, path.dq, path.ddq, time)).all():
                return f"no torque {'along a motion' if time is not None else 'of single samples'}"
        one = model.torque(path.q[7], path.dq[7], path.ddq[7])
        many = model.torque(path.q, path.dq, path.ddq)
        if not np.allclose(one, many[7], rtol=1e-9, atol=1e-9):
            return "a sample by itself has another torque than among others: they stand apart"
    return None


def bare(robot: Robot, term: Term) -> TorqueModel:
    """The URDF's bodies, some friction to heat and to rub, and the effect."""
    base = base_parameters(robot)
    friction = tuple(
        Term(name, (j,), np.array([2.0]), {"v0": 0.02} if name == "coulomb" else {})
        for name in ("coulomb", "viscous")
        for j in term.joints or (0,)
    )
    terms = (*friction, term)
    size = len(base) + sum(len(t.coefficients) for t in terms)
    covariance, noise = np.zeros((size, size)), np.zeros(robot.n)
    return TorqueModel(
        "check", robot, base, base.of(robot.parameters), terms, covariance, noise, 10.0
    )


def _stepped(s: ShapeParameter, shape: Shape, share: float) -> float:
    step = share * s.step_at(shape)
    value = shape[s.name] * np.exp(step) if s.scale == "log" else shape[s.name] + step
    return float(value)
