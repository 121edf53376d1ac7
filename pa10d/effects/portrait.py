"""The signature of an effect as curves: its typical case, on a motion that brings it out.

What a person sees in a residual is not the effect itself but what a fit of the textbook friction
leaves of it, so both are given.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics import Robot
from pa10d.effects.base import Effect, smooth_sign
from pa10d.effects.context import Context
from pa10d.effects.motions import ShownMotion, motion

Array = NDArray[np.float64]

VISIBLE = 0.1  # share of the drawn joint's torque from which another joint is shown, too
Quantity = Callable[[Context, ShownMotion, int, int], Array]


@dataclass(frozen=True)
class Portrait:
    """Curves of N samples.

    x: the quantity that brings the effect out, ``x_label`` with unit
    torque: of the effect on the drawn joint, N·m
    left: what remains of it where textbook friction is fitted anew; the same as ``torque`` where
        the question is what changed
    speed: rad/s of the joint that moves
    others: label -> torque on further joints, N·m
    """

    t: Array
    x: Array
    x_label: str
    torque: Array
    left: Array
    speed: Array
    others: dict[str, Array]
    text: str
    joint: str
    moving: str


def portrait(kind: Effect, robot: Robot) -> Portrait | None:
    """Curves of the effect's example on an arm; None where the class gives no example."""
    example = kind.example
    if example is None:
        return None
    at = [j - 1 for j in example.joints]
    drawn, moving = at[0], at[-1]
    path = motion(example.motion, robot, moving)
    context = _context(robot, path)
    joints = at if kind.scope != "robot" else []
    theta = np.array(example.coefficients)
    shape = kind.relinearised(theta, example.shape)
    torque = kind.columns(context, joints, shape) @ theta
    everywhere = np.zeros_like(path.q)
    if kind.reaches_other_joints:
        everywhere = torque
    else:
        everywhere[:, drawn] = torque
    own = everywhere[:, drawn]
    x_label, quantity = QUANTITIES[example.against]
    size = np.sqrt(np.mean(everywhere**2, axis=0))
    shown = [j for j in np.argsort(-size) if j != drawn and size[j] > VISIBLE * size[drawn]][:2]
    return Portrait(
        t=path.t,
        x=quantity(context, path, drawn, moving),
        x_label=x_label.format(drawn=drawn + 1, moving=moving + 1),
        torque=own,
        left=_refitted(own, context, drawn) if kind.question == "missing" else own,
        speed=path.dq[:, moving],
        others={f"joint {j + 1}": everywhere[:, j] for j in shown},
        text=path.text,
        joint=f"joint {drawn + 1}",
        moving=f"joint {moving + 1}",
    )


QUANTITIES: dict[str, tuple[str, Quantity]] = {
    "q": ("angle of joint {drawn} (rad)", lambda c, m, j, k: c.q[:, j]),
    "dq": ("speed of joint {drawn} (rad/s)", lambda c, m, j, k: c.dq[:, j]),
    "ddq": ("acceleration of joint {drawn} (rad/s²)", lambda c, m, j, k: c.ddq[:, j]),
    "other_dq": ("speed of joint {moving} (rad/s)", lambda c, m, j, k: c.dq[:, k]),
    "other_ddq": ("acceleration of joint {moving} (rad/s²)", lambda c, m, j, k: c.ddq[:, k]),
    "load": ("torque passed to the links (N·m)", lambda c, m, j, k: c.load[:, j]),
    "total": ("torque of joint {drawn} (N·m)", lambda c, m, j, k: c.total[:, j]),
    "rate": (
        "change of torque (N·m/s)",
        lambda c, m, j, k: np.gradient(c.total[:, j], c.dt),
    ),
    "frequency": ("frequency of the motion (Hz)", lambda c, m, j, k: _of(m)),
    "t": ("time (s)", lambda c, m, j, k: c.t),
}


def _of(path: ShownMotion) -> Array:
    if path.frequency is None:
        raise ValueError("this motion has no frequency; draw the effect on 'chirp'")
    return path.frequency


def _context(robot: Robot, path: ShownMotion) -> Context:
    """The motion with the URDF's rigid bodies and friction of a likely size."""
    bare = Context(robot, path.t, path.q, path.dq, path.ddq, robot.parameters, path.q * 0.0)
    level = 0.04 * np.where(np.isfinite(robot.effort), robot.effort, 100.0)
    friction = level * (np.tanh(path.dq / 0.05) + path.dq)
    return replace(bare, total=bare.load + friction, rubbing=friction)


def _refitted(torque: Array, context: Context, j: int) -> Array:
    v = context.dq[:, j]
    textbook = np.column_stack([smooth_sign(v, 0.01), v])
    return torque - textbook @ np.linalg.lstsq(textbook, torque, rcond=None)[0]
