"""One substep of the whole arm: Moreau's midpoint scheme.

Positions move half a step, forces are taken there, velocities change (velocity-proportional parts
at their mean, dry friction set-valued at the end), positions move the other half. Second order
and time-symmetric where the motion is smooth, stable and dissipative where it sticks and slips.
"""

from __future__ import annotations

from backends.virtual.plant.bristles import bend, resistance
from backends.virtual.plant.compiled import inner
from backends.virtual.plant.extras import CREEP, bent_by_others, on_links, on_rotors, relax
from backends.virtual.plant.friction import level, viscous
from backends.virtual.plant.inertia import mass_matrix
from backends.virtual.plant.linear import invert
from backends.virtual.plant.records import Array
from backends.virtual.plant.rigid import bias, place
from backends.virtual.plant.state import Figures, PlantState, Scratch
from backends.virtual.plant.stiction import rub, transmitted_load
from backends.virtual.plant.transmission import transmitted
from backends.virtual.plant.warmth import remaining, warm_up


@inner
def substep(arm: Figures, state: PlantState, work: Scratch, motor: Array, h: float) -> None:
    """Advance by h seconds under the motor torques (n,), N·m at the joint side."""
    n, size = arm.joints.shape[0], state.q.shape[0]
    for i in range(size):
        work.q[i] = state.q[i] + 0.5 * h * state.v[i]
        work.v[i] = state.v[i] + 0.5 * h * state.acc[i]
        work.force[i] = 0.0
        for k in range(size):
            work.mass[i, k] = work.damping[i, k] = 0.0
    place(arm.bodies, work.q[:n], work.frames)
    bias(arm.bodies, arm.gravity, work.v[:n], work.frames, work.bias)
    mass_matrix(arm.bodies, work.frames, work.mass)
    _rotors(arm, state, work, motor, h)
    _links(arm, state, work)
    for i in range(size):
        for k in range(size):
            work.force[i] -= work.damping[i, k] * state.v[k]
            work.mass[i, k] += 0.5 * h * work.damping[i, k]
    invert(work.mass, work.inverse)
    for i in range(size):
        work.after[i] = state.v[i]
        for k in range(size):
            work.after[i] += h * work.inverse[i, k] * work.force[k]
    rub(
        arm.joints, arm.extras, work.joints,
        work.inverse, state.impulse, state.v, work.after, h,
    )  # fmt: skip
    _inner_states(arm, state, work, h)
    for i in range(size):
        state.acc[i] = (work.after[i] - state.v[i]) / h
        state.v[i] = work.after[i]
        state.q[i] = work.q[i] + 0.5 * h * work.after[i]


@inner
def _rotors(arm: Figures, state: PlantState, work: Scratch, motor: Array, h: float) -> None:
    """Motor torque, ripple and friction of the rotors; bounds of their dry friction."""
    n = arm.joints.shape[0]
    for j in range(n):
        d = arm.joints[j].rotor
        work.force[d] += motor[j]
        work.mass[d, d] += arm.joints[j].inertia
    on_rotors(arm.extras, arm.joints, work.q, work.mass, work.damping, work.force)
    for j in range(n):
        joint, own = arm.joints[j], work.joints[j]
        d = joint.rotor
        speed, q = work.v[d], work.q[j]
        added = bent_by_others(arm.extras, j, work.q)
        thinned, cooled = remaining(joint, state.warm[j])
        own.drag = viscous(joint, speed, thinned)
        own.constant = 0.0
        own.forward = level(joint, q, added, speed, cooled, 1.0)
        own.backward = level(joint, q, added, speed, cooled, -1.0)
        if joint.bristles:
            own.top = own.forward if speed >= 0.0 else own.backward
            own.top += joint.mu * abs(state.load[j])
            own.top += joint.dmu * state.load[j] * (1.0 if speed >= 0.0 else -1.0)
            own.forward = own.backward = 0.0
            constant, slope = resistance(joint, state.bent[j], speed, own.top, h)
            own.constant = constant
            own.drag += slope
        work.force[d] -= own.constant
        work.damping[d, d] += own.drag
        own.entering = work.force[d]


@inner
def _links(arm: Figures, state: PlantState, work: Scratch) -> None:
    """Transmissions, gravity and velocity torques, and what acts on the links."""
    for j in range(arm.joints.shape[0]):
        work.force[j] -= work.bias[j] + state.outside[j]
        d = arm.joints[j].rotor
        if d != j:
            rate = work.v[d] - work.v[j]
            torque, damping = transmitted(arm.joints[j], work.q[d] - work.q[j], rate)
            work.force[d] -= torque
            work.force[j] += torque
            work.damping[d, d] += damping
            work.damping[j, j] += damping
            work.damping[d, j] -= damping
            work.damping[j, d] -= damping
    on_links(arm.extras, work.q, work.v, state.stretch, work.damping, work.force)


@inner
def _inner_states(arm: Figures, state: PlantState, work: Scratch, h: float) -> None:
    """Load, friction, warmth, bristles and creep over the substep just solved."""
    for j in range(arm.joints.shape[0]):
        joint, own = arm.joints[j], work.joints[j]
        d = joint.rotor
        mean = 0.5 * (state.v[d] + work.after[d])
        state.load[j] = transmitted_load(
            arm.joints, arm.extras, work.joints, state.impulse, j, state.v, work.after, h
        )
        state.rubbing[j] = own.constant + own.drag * mean - state.impulse[j] / h
        power = abs(state.rubbing[j] * mean)
        state.warm[j] = warm_up(joint, state.warm[j], power, h)
        if joint.bristles:
            bend(joint, state.bent[j], mean, own.top, h)
    for r in range(arm.extras.shape[0]):
        if arm.extras[r].kind == CREEP:
            j = arm.extras[r].i
            mean = 0.5 * (state.v[j] + work.after[j])
            state.stretch[r] = relax(arm.extras[r], state.stretch[r], mean, h)
