"""What tables of a model can hold of its torque, as numbers.

The numbers are those of the straight-line code that the C export consists of.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.export import trace
from pa10d.export.straight_line import TracedModule
from pa10d.export.trace import Traced, traced
from pa10d.model import TorqueModel

Array = NDArray[np.float64]


class Tabulated:
    """The model's straight-line code, one joint's torque at a time."""

    def __init__(self, model: TorqueModel) -> None:
        self.robot = model.robot
        self.lower, self.upper = _range(model)
        module, rest = TracedModule(model), traced(np.zeros((1, self.robot.n)))
        q = trace.inputs("q", self.robot.n)
        self._at_rest: Traced = module.torque(q, rest, rest)
        self._alone = [self._own(module, q, j) for j in range(self.robot.n)]

    def poses(self, count: int, seed: int) -> Array:
        """(count, n) within the limits."""
        rng = np.random.default_rng(seed)
        return rng.uniform(self.lower, self.upper, (count, self.robot.n))

    def holding(self, j: int, q: Array) -> Array:
        """(N,) torque of joint j that holds the arm in poses q (N, n)."""
        return trace.evaluated(self._at_rest[0, j], {"q": q})

    def friction(self, j: int, q: Array, speed: Array) -> Array:
        """(N,) torque of joint j at its own speed (N,), all others at rest, beyond ``holding``."""
        given = {"q": q, "dq": speed[:, None]}
        return trace.evaluated(self._alone[j], given) - self.holding(j, q)

    def torque(self, q: Array, dq: Array) -> Array:
        """(N, n) of exact tables over every joint; friction where a speed limit ends its table."""
        columns = []
        for j, limit in enumerate(self.robot.velocity):
            column = self.holding(j, q)
            columns.append(column + self.friction(j, q, dq[:, j]) if np.isfinite(limit) else column)
        return np.stack(columns, axis=1)

    def reached(self, j: int) -> list[int]:
        """Joints whose pose joint j's holding torque has in it."""
        return sorted(k for _, k in trace.inputs_of([self._at_rest[0, j]]))

    def _own(self, module: TracedModule, q: Traced, j: int) -> Any:
        n = self.robot.n
        dq, rest = np.zeros((1, n), dtype=object), traced(np.zeros((1, n)))
        dq[0, j] = trace.inputs("dq", 1)[0, 0]
        return module.torque(q, traced(dq), rest)[0, j]


def _range(model: TorqueModel) -> tuple[Array, Array]:
    """(n,) each; a joint that turns without limits is looked at over one turn."""
    robot = model.robot
    endless = ~(np.isfinite(robot.lower) & np.isfinite(robot.upper))
    for j in np.flatnonzero(endless & robot.prismatic):
        raise UserError(
            f"format tables: joint {j + 1} slides without limits; expected lower and upper in the "
            "URDF, between which a table can lie"
        )
    return np.where(endless, -np.pi, robot.lower), np.where(endless, np.pi, robot.upper)
