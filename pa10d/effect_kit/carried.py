"""What an export carries of an effect is what the model predicts."""

from __future__ import annotations

from typing import Any

import numpy as np

from pa10d.dynamics import Robot
from pa10d.effect_kit import draws
from pa10d.effect_kit.numbers import bare
from pa10d.effects import Effect
from pa10d.export.python_module import python_module

SAME = 1e-9


def carried(kind: Effect, robot: Robot, rng: np.random.Generator, count: int) -> str | None:
    """The exported Python module against ``model.torque``, along motions and apart."""
    space: dict[str, Any] = {}
    for _ in range(count):
        path = draws.path(rng, robot, int(rng.integers(2, 24)))
        model = bare(robot, draws.term(rng, kind, draws.context(robot, path)))
        if not space:
            text, lost = python_module(model, "conformance")
            if lost:
                return lost[0]
            exec(compile(text, f"<{kind.id}, exported>", "exec"), space)
            made = type(space["TERMS"][-1].effect)
        space["TERMS"][:] = [
            space["Term"](type(old.effect)(), new.joints, new.coefficients, new.shape)
            for old, new in zip(_as_many(space["TERMS"], model, made), model.terms, strict=True)
        ]
        for time in (path.t, None):
            expected = model.torque(path.q, path.dq, path.ddq, time)
            found = space["torque"](path.q, path.dq, path.ddq, time)
            worst = float(np.max(np.abs(found - expected)))
            if not worst <= SAME * max(1.0, float(np.max(np.abs(expected)))):
                return f"the exported module is off by {worst:.2g} N·m at {model.terms[-1].shape}"
    return None


def _as_many(terms: list[Any], model: Any, made: type) -> list[Any]:
    """Coulomb and viscous friction of each joint, then the effect: as in the model."""
    half = (len(model.terms) - 1) // 2
    return [*[terms[0]] * half, *[terms[(len(terms) - 1) // 2]] * half, terms[-1]]
