"""Compile at once what is compiled when it is first used: ``python scripts/compile_kernels.py``.

Of processes that begin together each would do it for itself. What is there already is read.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from multiprocessing import Process
from types import SimpleNamespace

import numpy as np

from backends.virtual.datasets import make_runs
from backends.virtual.plant import build
from pa10d.control.build import build_arm
from pa10d.control.ring import Ring
from pa10d.dynamics import inverse_dynamics, regressor, robot_from_profile, sensitivities
from pa10d.dynamics.adjoint import regressor_gradient
from pa10d.effects import Context, all_effects
from pa10d.effects.memory import fading
from pa10d.effects.swing import Spring, Swing
from pa10d.profile import load_profile
from pa10d.trajectory.capsules import capsules_of

PROFILE, SAMPLES, DT = "pa10-sim", 200, 0.004


def compile_science() -> None:
    """Of rigid bodies, their derivatives, and all effects, on a short motion of the arm."""
    robot = robot_from_profile(load_profile(PROFILE))
    t = np.arange(SAMPLES) * DT
    angle = np.add.outer(4.0 * t, np.arange(robot.n))
    q, dq, ddq = 0.3 * np.sin(angle), 1.2 * np.cos(angle), -4.8 * np.sin(angle)
    columns = regressor(robot, q, dq, ddq)
    by_joint = np.zeros((robot.n, columns.shape[2], SAMPLES))  # as an equation of torques asks
    regressor(robot, q, dq, ddq, out=by_joint.transpose(2, 0, 1))
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
    fading(t, 0.5)


def compile_virtual_arm() -> None:
    """Of the simulated plant: a sample by itself, and a run."""
    profile = load_profile(PROFILE)
    plant = build(profile)
    plant.step(np.zeros(plant.n), DT)
    make_runs(0, profile=profile, kinds=("train_a",), seconds=10 * DT)


def compile_control() -> None:
    """Of what is looked at in each cycle, and before a motion."""
    profile = load_profile(PROFILE)
    robot = robot_from_profile(profile)
    capsules_of(robot).clearance(np.zeros((1, robot.n)))
    backend = SimpleNamespace(n=robot.n, period=DT)
    build_arm(profile, robot, backend, Ring.create(robot.n, 16, DT))


PARTS: tuple[Callable[[], None], ...] = (compile_science, compile_virtual_arm, compile_control)

if __name__ == "__main__":
    working = [Process(target=part) for part in PARTS]
    for one in working:
        one.start()
    for one in working:
        one.join()
    raise SystemExit(any(one.exitcode for one in working))
