"""Friction of every joint by its speed, as a model has it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pa10d.effects.context import posed
from pa10d.figures.plotly import JOINTS, Figure, axis, layout, line, packed
from pa10d.model import Term, TorqueModel

POINTS = 201
USUAL = 1.0  # rad/s (m/s), where nobody has stated a limit


def friction_curves(model: TorqueModel) -> Figure:
    """Torque of all friction when one joint turns by itself at a steady speed, in the middle of the
    arm's ranges; N·m (N) over rad/s (m/s). Cold and slid in: nothing that remembers counts."""
    robot, rubbing = model.robot, replace(model, terms=_rubbing(model))
    bounded = np.isfinite(robot.lower) & np.isfinite(robot.upper)
    middle = np.where(bounded, 0.5 * (robot.lower + robot.upper), 0.0)
    fastest = np.where(np.isfinite(robot.velocity) & (robot.velocity > 0), robot.velocity, USUAL)
    data = []
    for j, name in enumerate(robot.joint_names):
        speed = np.linspace(-fastest[j], fastest[j], POINTS)
        dq = np.zeros((POINTS, robot.n))
        dq[:, j] = speed
        q, still = np.tile(middle, (POINTS, 1)), np.zeros_like(dq)
        seen = rubbing.contextualise(posed(robot, q, dq, still))
        torque = sum((term.torque(seen)[:, j] for term in rubbing.terms), np.zeros(POINTS))
        data.append(line(f"{j + 1} {name}", torque, JOINTS[j % len(JOINTS)], x=packed(speed)))
    return {
        "data": data,
        "layout": layout(
            330,
            xaxis=axis(f"speed, {'rad/s' if not robot.prismatic.any() else 'rad/s (m/s)'}"),
            yaxis=axis(f"friction, {robot.torque_units()}"),
        ),
    }


def _rubbing(model: TorqueModel) -> tuple[Term, ...]:
    return tuple(term for term in model.terms if term.effect.rubs and not term.over)
