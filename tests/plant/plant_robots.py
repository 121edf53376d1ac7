"""Small robots for the plant's tests, and what an independent computation says about them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from backends.virtual.plant import Plant, build
from backends.virtual.plant.servo import servo_for
from pa10d.profile import Profile, load_profile

G = 9.81


def link(name: str, mass: float, com: str, inertia: tuple[float, float, float]) -> str:
    xx, yy, zz = inertia
    return (
        f'<link name="{name}"><inertial><mass value="{mass}"/><origin xyz="{com}"/>'
        f'<inertia ixx="{xx}" iyy="{yy}" izz="{zz}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    )


def joint(name: str, parent: str, child: str, axis: str, xyz: str = "0 0 0", **more: str) -> str:
    kind, rpy = more.get("kind", "revolute"), more.get("rpy", "0 0 0")
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/>'
        '<limit lower="-3" upper="3" velocity="2" effort="100"/></joint>'
    )


def profile_of(folder: Path, *parts: str) -> Profile:
    path = folder / "robot.urdf"
    path.write_text(f'<robot name="r"><link name="base"/>{"".join(parts)}</robot>')
    return Profile(path=path, name="r", urdf=path)


def turntable(folder: Path, joints: int = 1, inertia: float = 1.0) -> Profile:
    """Vertical coaxial axes: gravity does nothing, the inertias add up from the tip."""
    parts = []
    for k in range(joints):
        parent = "base" if k == 0 else f"l{k - 1}"
        parts.append(link(f"l{k}", 1.0, "0 0 0", (inertia, inertia, inertia)))
        parts.append(joint(f"j{k}", parent, f"l{k}", "0 0 1"))
    return profile_of(folder, *parts)


def pendulum(folder: Path, mass: float = 4.0, length: float = 0.5) -> Profile:
    """One horizontal axis; the mass hangs straight up at q = 0: gravity asks -m g l sin q."""
    return profile_of(
        folder,
        link("l0", mass, f"0 0 {length}", (0.01, 0.01, 0.01)),
        joint("j0", "base", "l0", "0 1 0"),
    )


def seven_axes() -> Profile:
    return load_profile("pa10-sim")


def bare(profile: Profile, effects: Any = (), **dynamics: Any) -> Plant:
    """An exact plant: no noise, no quantisation, no friction or rotor unless given."""
    given = {"rotor_inertia": 0.0, "coulomb": 0.0, "viscous": 0.0, **dynamics}
    substep = given.pop("substep", None)
    return build(
        profile, effects=effects, noise="none", resolution=0.0, dynamics=given, substep=substep
    )


def driven(
    plant: Plant, q: np.ndarray, dq: np.ndarray, dt: float, bandwidth: float = 1.0
) -> tuple[np.ndarray, np.ndarray]:
    """Servo the plant along q, dq (N, n) → true rotor angle and held torque, (N, n).

    Row k is the state at the end of sample k, in which reference k was commanded.
    """
    plant.reset(q[0] - plant.sensing.encoder_offset)
    soft = plant.physics.transmission.rotor >= plant.n
    servo = servo_for(plant.physics.arm, plant.textbook, q[0], dt, soft)
    servo.kp[:] *= bandwidth**2
    servo.kd[:] *= bandwidth
    log = plant.follow(servo, q, dq, np.zeros_like(q), dt)
    return log.true_q, log.command


def pinocchio_model(plant: Plant, urdf: Path) -> pin.Model:
    """Pinocchio's own reading of the URDF with the plant's masses: none of the plant's algebra."""
    model = pin.buildModelFromUrdf(str(urdf))
    arm = plant.physics.arm
    for i in range(model.nv):
        model.inertias[i + 1] = pin.Inertia(float(arm.mass[i]), arm.com[i], arm.inertia[i])
    model.gravity.linear = arm.gravity
    return model


def unexplained(
    plant: Plant, urdf: Path, q: np.ndarray, torque: np.ndarray, dt: float
) -> dict[str, np.ndarray]:
    """Torque left over by Newton-Euler, rotor, Coulomb and viscous friction along a motion.

    Torque k is held from q[k-1] to q[k], so at q[k] the mean of torques k and k+1 acted. Returns
    q, dq, ddq, load (rigid torque) and rest, each (N-2, n); rest is measured - textbook.
    """
    model = pinocchio_model(plant, urdf)
    data = model.createData()
    at, v = q[1:-1], (q[2:] - q[:-2]) / (2 * dt)
    a = (q[2:] - 2 * q[1:-1] + q[:-2]) / dt**2
    rigid = np.array([pin.rnea(model, data, *row) for row in zip(at, v, a, strict=True)])
    book = plant.textbook
    friction = book.coulomb * np.sign(v) + book.viscous * v
    acted = 0.5 * (torque[1:-1] + torque[2:])
    rest = acted - rigid - book.rotor_inertia * a - friction
    return {"q": at, "dq": v, "ddq": a, "load": rigid, "rest": rest, "torque": acted}


def sliding(v: np.ndarray, slowest: float = 0.01, around: int = 4) -> np.ndarray:
    """(N,) samples at which every joint has slid one way for a while, before and after."""
    slow = (np.abs(v) < slowest).any(axis=1)
    return np.convolve(slow, np.ones(2 * around + 1), "same") < 0.5
