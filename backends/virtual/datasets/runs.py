"""One run: a motion of a kind, followed by the simulated arm under its servo."""

from __future__ import annotations

import numpy as np

from backends.virtual.datasets.motions import Course, Reach, random_fourier, random_sines
from backends.virtual.datasets.stretches import random_points, random_sweeps
from backends.virtual.plant.plant import Plant
from backends.virtual.plant.records import Array
from backends.virtual.plant.servo import feed_forward, nominal, servo_for
from backends.virtual.plant.warmth import celsius
from pa10d.measurement.recording import Recording
from pa10d.profile import Profile

KINDS = ("train_a", "train_b", "valid_a", "valid_b")
LEAD_IN = 1.0  # s in which the motion gathers speed, before the recording begins


def motion_of(kind: str, rng: np.random.Generator, reach: Reach, seconds: float) -> Course:
    """train_a, ref_a: Fourier of 10 s; valid_a: of 8 s; train_b, ref_b: slow sines; valid_b: point
    to point; sweep: constant speeds."""
    if kind in ("train_a", "ref_a"):
        return random_fourier(rng, reach, 10.0)
    if kind == "valid_a":
        return random_fourier(rng, reach, 8.0)
    if kind in ("train_b", "ref_b"):
        return random_sines(rng, reach)
    if kind == "valid_b":
        return random_points(rng, reach, seconds)
    if kind == "sweep":
        return random_sweeps(rng, reach, seconds)
    raise ValueError(f"kind {kind!r}: expected {', '.join(KINDS)}, ref_a, ref_b or sweep")


def run_motion(
    plant: Plant,
    profile: Profile,
    motion: Course,
    seconds: float,
    rate: float = 500.0,
    centred: bool = False,
) -> tuple[Recording, Array]:
    """Let the plant follow a motion → the recording ("run") and the true rotor angles (N, n).

    The arm starts at rest; the motion gathers speed along its own path before t = 0. A torque is
    the reading at its stamp, of what was held in the sample before; centred: the mean of the
    readings before and after the stamp, which belongs to the stamp itself.
    """
    dt = 1.0 / rate
    arm, book = nominal(profile)
    steps, lead = round(seconds * rate), round(LEAD_IN * rate)
    t = np.arange(-lead - 1.0, float(steps)) * dt
    q, dq, _ = gathering(motion, t)
    forward = feed_forward(arm, book, *gathering(motion, t + 0.5 * dt))
    plant.reset(q[0] - plant.sensing.encoder_offset)
    rotor = plant.physics.transmission.rotor
    servo = servo_for(arm, book, plant.measure()[0], dt, rotor >= plant.n)
    plant.follow(servo, q[:lead], dq[:lead], forward[:lead], dt)
    plant.state.warm[:] = plant.physics.warmth.start
    log = plant.follow(servo, q[lead:], dq[lead:], forward[lead:], dt)
    warms = np.any(plant.physics.warmth.loss > 0)
    temperature = celsius(plant.physics.warmth, log.warm[:steps]) if warms else None
    torque = 0.5 * (log.torque[:-1] + log.torque[1:]) if centred else log.torque[:-1]
    time = np.arange(float(steps)) * dt
    run = Recording("run", time, log.q[:steps], torque, temperature=temperature)
    return run, log.true_q[:steps]


def gathering(motion: Course, t: Array) -> tuple[Array, Array, Array]:
    """The motion, entered from rest at its own t = -LEAD_IN/2 by a smooth clock."""
    x = np.clip(1.0 + t / LEAD_IN, 0.0, 1.0)
    clock = np.where(t < 0, LEAD_IN * (x**3 - 0.5 * x**4 - 0.5), t)
    pace = np.where(t < 0, 3 * x**2 - 2 * x**3, 1.0)
    change = np.where(t < 0, 6 * (x - x**2) / LEAD_IN, 0.0)
    q, dq, ddq = motion.sample(clock)
    return q, dq * pace[:, None], ddq * pace[:, None] ** 2 + dq * change[:, None]
