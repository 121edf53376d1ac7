"""Recordings of a plant that somebody else wrote, by nothing but INTERFACES' plant protocol."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from backends.virtual.datasets.robot import reach_of
from backends.virtual.datasets.runs import LEAD_IN, gathering, motion_of
from backends.virtual.load_plant import load_plant
from backends.virtual.plant.records import Array
from backends.virtual.plant.run import Servo
from backends.virtual.plant.servo import feed_forward, nominal, servo_for
from pa10d.common.errors import UserError
from pa10d.measurement.recording import Recording
from pa10d.profile import Profile


def foreign_runs(
    seed: int, kinds: Sequence[str], profile: Profile, *, seconds: float, rate: float = 500.0
) -> dict[str, Recording]:
    """Runs of the plant that the profile names, with the motions and the servo of our own.

    Torque is the mean of the readings before and after its stamp, so it belongs to the stamp.
    """
    arm, book = nominal(profile)
    n = len(book.effort)
    plant, reach = load_plant(profile, n), reach_of(profile)
    dt = 1.0 / rate
    steps, lead = round(seconds * rate), round(LEAD_IN * rate)
    out: dict[str, Recording] = {}
    for kind in kinds:
        motion = motion_of(kind, np.random.default_rng([seed, sum(kind.encode())]), reach, seconds)
        t = np.arange(-lead - 1.0, float(steps)) * dt
        q, dq, _ = gathering(motion, t)
        forward = feed_forward(arm, book, *gathering(motion, t + 0.5 * dt))
        plant.reset(q[0])
        servo = servo_for(arm, book, plant.measure()[0], dt, np.zeros(n, dtype=bool))
        angle, torque = _follow(plant, servo, q, dq, forward, dt)
        if not (np.isfinite(angle).all() and np.isfinite(torque).all()):
            raise UserError(
                f"{profile.path}: simulation.plant: in motion {kind} it measured what is no "
                "finite number, expected rad and N·m"
            )
        centred = 0.5 * (torque[lead:-1] + torque[lead + 1 :])
        out[kind] = Recording(kind, np.arange(float(steps)) * dt, angle[lead:-1], centred)
    return out


def _follow(
    plant: Any, servo: Servo, q: Array, dq: Array, forward: Array, dt: float
) -> tuple[Array, Array]:
    """Readings (steps, n) at the end of each sample, as the compiled servo takes them."""
    angle, torque = np.empty_like(q), np.empty_like(q)
    last, speed = servo.last.copy(), servo.speed.copy()
    here = np.asarray(plant.measure()[0], float)
    for k in range(len(q)):
        speed += servo.smoothing * ((here - last) / dt - speed)
        last = here
        wanted = forward[k] + servo.kp * (q[k] - here) + servo.kd * (dq[k] - speed)
        plant.step(np.clip(wanted, -servo.limit, servo.limit), dt)
        angle[k], torque[k] = plant.measure()
        here = angle[k]
    return angle, torque
