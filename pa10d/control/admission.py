"""May this model command this arm, now? One line says why not."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from pa10d.control.limits import ArmLimits
from pa10d.control.live_model import LiveModel, kinematics_of
from pa10d.dynamics import Robot
from pa10d.effects import effect

Array = NDArray[np.float64]

SAME_PLACE = 1e-6  # m, rad and parts of unit vectors: of the same joint in two descriptions
BESIDE = 0.1  # of the torque limit, that a model may lie beside the torque that holds the arm …
DRY = 0.25  # … and at most this much more where dry friction of its own can hold the arm as well
CREEP = 0.05  # of the speed limit: dry friction is there, most of the viscous one is not
DRIVES = 0.01  # of the torque limit, by which friction, or inertia at the acceleration limit, may
# push: what noise makes of none
LOOKED_AT = 500  # poses of a motion: its torque is smooth, and the arm waits meanwhile


@runtime_checkable
class HasModel(Protocol):
    """What a controller with a model offers to be looked at."""

    def model_torque(self, q: Array, dq: Array, ddq: Array) -> Array:
        """N·m (N, n) at q, dq, ddq (N, n), as the loop would command it."""
        ...


def wrong_with_model(live: LiveModel, robot: Robot, limits: ArmLimits) -> str | None:
    """Whether it is of this robot, finite, its formulas can be evaluated, its friction brakes."""
    return (
        _of_another(live, robot)
        or _not_a_number(live, robot)
        or _no_torque(live, robot, limits.velocity)
        or _driving(live, limits)
    )


def wrong_with_torque(controller: HasModel, q: Array, held: Array, limits: ArmLimits) -> str | None:
    """Whether it would hold the arm at q (n,) with about the torque that does now (n,) N·m, and
    resists there as each joint begins to move."""
    still, creep = np.zeros((1, len(q))), CREEP * limits.velocity[None]
    said = controller.model_torque(q[None], still, still)[0]
    for j in np.flatnonzero(~(np.abs(said) <= limits.torque)):
        return (
            f"joint {j + 1}: the model wants {said[j]:.3g} N·m to hold the arm where it is, its "
            f"limit is {limits.torque[j]:.3g} N·m"
        )
    forth = controller.model_torque(q[None], creep, still)[0]
    back = controller.model_torque(q[None], -creep, still)[0]
    dry = np.minimum(0.5 * np.abs(forth - back), DRY * limits.torque)
    allowed = BESIDE * limits.torque + dry
    for j in np.flatnonzero(~(np.abs(said - held) <= allowed)):
        return (
            f"joint {j + 1}: the model wants {said[j]:.3g} N·m to hold the arm where it is, "
            f"{held[j]:.3g} N·m do hold it; allowed are {allowed[j]:.3g} N·m beside that"
        )
    return _driven_by_inertia(controller, q, said, limits)


def _driven_by_inertia(
    controller: HasModel, q: Array, said: Array, limits: ArmLimits
) -> str | None:
    """Each joint by itself, at its acceleration limit: what is less than nothing would be sent
    against the motion that it is for. said: N·m (n,) at rest."""
    n = len(q)
    still, each = np.zeros((n, n)), np.diag(limits.acceleration)
    asked = np.diag(controller.model_torque(np.tile(q, (n, 1)), still, each)) - said
    for j in np.flatnonzero(~(asked >= -DRIVES * limits.torque)):
        return (
            f"joint {j + 1}: the model's inertia drives: it wants {asked[j]:.3g} N·m to accelerate "
            f"by {limits.acceleration[j]:.3g} rad/s², expected some that resists"
        )
    return None


def wrong_along(controller: HasModel, rows: Array, limits: ArmLimits, period: float) -> str | None:
    """Whether a motion (N, 4n) asks for more torque than a joint has."""
    n = len(limits.torque)
    seen = np.unique(np.linspace(0, len(rows) - 1, LOOKED_AT).astype(int))
    q, dq, ddq, extra = np.split(np.asarray(rows[seen]), 4, axis=1)
    share = np.abs(controller.model_torque(q, dq, ddq) + extra) / limits.torque
    row, worst = divmod(int(np.argmax(np.nan_to_num(share, nan=np.inf))), n)
    if share[row, worst] <= 1.0:
        return None
    wants = share[row, worst] * limits.torque[worst]
    return (
        f"joint {worst + 1} at {seen[row] * period:.3f} s: the model wants {wants:.3g} N·m, "
        f"its limit is {limits.torque[worst]:.3g} N·m"
    )


def _of_another(live: LiveModel, robot: Robot) -> str | None:
    if live.kinematics is None:
        return "the model does not say which arm it is of"
    ours = kinematics_of(robot)
    if live.kinematics.shape != ours.shape:
        return f"the model is of an arm with {len(live.kinematics)} joints, this has {robot.n}"
    for j in np.flatnonzero(~(np.abs(live.kinematics - ours) <= SAME_PLACE).all(axis=1)):
        name = robot.joint_names[j]
        return f"the model is of another arm: its joint {j + 1} sits elsewhere than '{name}' here"
    return None


def _not_a_number(live: LiveModel, robot: Robot) -> str | None:
    if live.rigid.shape != (robot.n, 10):
        return f"the model has bodies {live.rigid.shape}, expected {(robot.n, 10)}"
    for j in np.flatnonzero(~np.isfinite(live.rigid).all(axis=1)):
        return f"joint {j + 1}: a body's parameter is not a number"
    for part in live.parts:
        known = {shape.name: shape for shape in effect(part.effect_id).shapes}
        for place, joint in enumerate(part.joints):
            if not 0 <= joint < robot.n:
                return f"{part.effect_id}: there is no joint {joint + 1}"
            if not np.isfinite(part.coefficients[place]).all():
                return f"joint {joint + 1}: {part.effect_id} is not a number"
            for name, values in part.shape.items():
                least = known[name].lower if name in known else -np.inf
                if not np.isfinite(values[place]) or (least > 0 and values[place] <= 0):
                    found = f"found {values[place]:.3g}, expected a number above 0"
                    return f"joint {joint + 1}: {name} of {part.effect_id}: {found}"
    return None


def _no_torque(live: LiveModel, robot: Robot, velocity: Array) -> str | None:
    still, creep = np.zeros((1, robot.n)), CREEP * velocity[None]
    said = live.torque(robot, still, creep, creep, still)[0]
    for j in np.flatnonzero(~np.isfinite(said)):
        return f"joint {j + 1}: the model's torque is {said[j]}"
    return None


def _driving(live: LiveModel, limits: ArmLimits) -> str | None:
    """All friction of a joint together, at a creep and at full speed in both directions: what does
    not brake would be taken away from the torque that the motion needs."""
    speeds = np.outer([CREEP, -CREEP, 1.0, -1.0], limits.velocity)
    rubbing, still = np.zeros_like(speeds), np.zeros_like(speeds)
    for part in live.parts:
        if effect(part.effect_id).rubs:
            part.add(rubbing, speeds, still)
    along = rubbing * np.sign(speeds)
    for j in np.flatnonzero(along.min(axis=0) < -DRIVES * limits.torque):
        row = int(np.argmin(along[:, j]))
        return (
            f"joint {j + 1}: the model's friction drives: it is {along[row, j]:.3g} N·m against a "
            f"motion at {speeds[row, j]:.3g} rad/s, expected one that brakes"
        )
    return None
