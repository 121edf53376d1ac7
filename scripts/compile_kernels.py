"""Compile at once what is compiled when it is first used: ``python scripts/compile_kernels.py``.

Of processes that begin together each would do it for itself. What is there already is read.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pa10d.dynamics import inverse_dynamics, regressor, robot_from_profile, sensitivities
from pa10d.dynamics.adjoint import regressor_gradient
from pa10d.effects import Context, all_effects
from pa10d.effects.swing import Spring, Swing
from pa10d.profile import load_profile

SAMPLES, DT = 200, 0.004


def compile_kernels() -> None:
    """Of rigid bodies, their derivatives, and all effects, on a short motion of the arm."""
    robot = robot_from_profile(load_profile("pa10-sim"))
    t = np.arange(SAMPLES) * DT
    angle = np.add.outer(4.0 * t, np.arange(robot.n))
    q, dq, ddq = 0.3 * np.sin(angle), 1.2 * np.cos(angle), -4.8 * np.sin(angle)
    columns = regressor(robot, q, dq, ddq)
    regressor_gradient(robot, q, dq, ddq, np.ones_like(columns))
    inverse_dynamics(robot, robot.parameters, q, dq, ddq)
    sensitivities(robot, robot.parameters, q, dq, ddq)
    bare = Context(robot, t, q, dq, ddq, robot.parameters, np.zeros_like(q))
    context = replace(bare, total=bare.load, rubbing=np.tanh(dq))
    for effect in all_effects().values():
        joints = {"joint": (1,), "pair": (1, 2), "robot": ()}[effect.scope]
        shape = effect.starts(context, joints)[0]
        effect.columns(context, joints, shape)
        effect.columns_of(context, joints, [shape, shape])
    Swing.of(context, [Spring(j, 1e5, 50.0, 0.1) for j in (1, 3)])


if __name__ == "__main__":
    compile_kernels()
