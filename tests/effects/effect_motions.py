"""Motions given by formulas, contexts made of them, and Pinocchio as the independent judge."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pinocchio as pin

from pa10d.dynamics import Robot, robot_from_profile, robot_from_urdf
from pa10d.effects import Context, effect
from pa10d.profile import load_profile

DT = 0.002
Motion = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray, np.ndarray]]


@cache
def pa10() -> Robot:
    """The arm of the default profile."""
    return robot_from_profile(load_profile("pa10-sim"))


@cache
def flywheel(inertia: float = 1.2) -> Robot:
    """One joint about a vertical axis: no gravity, constant inertia."""
    return robot_from_urdf(
        f"""<robot name="flywheel"><link name="base"/><link name="disc"><inertial><mass value="1"/>
        <inertia ixx="1" iyy="1" izz="{inertia}" ixy="0" ixz="0" iyz="0"/></inertial></link>
        <joint name="spin" type="continuous"><parent link="base"/><child link="disc"/>
        <axis xyz="0 0 1"/></joint></robot>"""
    )


def wandering(n: int, seed: int = 0, size: float = 1.0, pace: float = 1.0) -> Motion:
    """Sums of four sines per joint around a drawn pose, as a function of time."""
    rng = np.random.default_rng(seed)
    omega = pace * 2 * np.pi * np.array([0.13, 0.31, 0.62, 1.1]) * rng.uniform(0.9, 1.1, (n, 4))
    amplitude = size * rng.uniform(-0.25, 0.25, (n, 4)) / np.array([1.0, 1.5, 2.5, 5.0])
    phase, middle = rng.uniform(0, 2 * np.pi, (n, 4)), rng.uniform(-0.8, 0.8, n)

    def at(t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        angle = omega * np.atleast_1d(t)[:, None, None] + phase
        q = middle + np.sum(amplitude * np.sin(angle), axis=2)
        dq = np.sum(amplitude * omega * np.cos(angle), axis=2)
        ddq = -np.sum(amplitude * omega**2 * np.sin(angle), axis=2)
        return q, dq, ddq

    return at


def context_of(robot: Robot, motion: Motion, seconds: float = 8.0, dt: float = DT) -> Context:
    """A run of the URDF's own rigid bodies, with some friction in the whole model's torque."""
    t = np.arange(0.0, seconds, dt)
    q, dq, ddq = motion(t)
    bare = Context(robot, t, q, dq, ddq, robot.parameters, np.zeros_like(q))
    friction = 2.0 * np.tanh(dq / 0.02) + 1.5 * dq
    return replace(bare, total=bare.load + friction, rubbing=friction)


def arm_context(seed: int = 0, seconds: float = 8.0, **motion: float) -> Context:
    """A run of the PA10."""
    return context_of(pa10(), wandering(pa10().n, seed, **motion), seconds)


def alone(joint: int, q: np.ndarray, dq: np.ndarray, ddq: np.ndarray, dt: float = DT) -> Context:
    """One joint (0-based) of the PA10 moves along (N,) arrays, the others rest where gravity
    loads it."""
    robot = pa10()
    pose = np.array([0.2, 0.5, 0.1, 0.7, 0.2, 0.6, 0.1])
    many = [np.tile(pose, (len(q), 1)), np.zeros((len(q), 7)), np.zeros((len(q), 7))]
    for array, values in zip(many, (q, dq, ddq), strict=True):
        array[:, joint] = values
    t = np.arange(len(q)) * dt
    bare = Context(robot, t, *many, robot.parameters, np.zeros((len(q), 7)))
    return replace(bare, total=bare.load, rubbing=np.zeros_like(bare.q))


def constant_speed(joint: int, speed: float, samples: int = 400) -> Context:
    """One joint turns evenly through zero."""
    t = np.arange(samples) * DT
    return alone(joint, speed * (t - t.mean()), np.full(samples, speed), np.zeros(samples))


def columns(name: str, context: Context, *joints: int, **shape: float) -> np.ndarray:
    """Columns of an effect by id; joints 0-based."""
    return effect(name).columns(context, joints, shape)


def pinocchio_torque(
    model: pin.Model, q: np.ndarray, dq: np.ndarray, ddq: np.ndarray
) -> np.ndarray:
    """(N, n) N·m by Pinocchio's recursive Newton-Euler."""
    data = model.createData()
    return np.array([pin.rnea(model, data, *row) for row in zip(q, dq, ddq, strict=True)])


def pinocchio_model(robot: Robot) -> pin.Model:
    """The same arm; its joints come in the same order."""
    model, order = robot.pinocchio()
    assert list(order) == list(range(robot.n))
    return model


def rms(x: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(x))))
