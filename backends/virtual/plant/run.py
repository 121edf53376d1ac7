"""The two ways to run the arm from Python: one held torque at a time, or a whole servoed run."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from backends.virtual.plant.compiled import entry, inner
from backends.virtual.plant.records import Array
from backends.virtual.plant.sensing import Reading, deliver, sense
from backends.virtual.plant.state import Figures, PlantState, Scratch
from backends.virtual.plant.step import substep


class Servo(NamedTuple):
    """Gains and memory of the joint servo, per joint (n,).

    kp N·m/rad, kd N·m·s/rad, limit N·m; smoothing: weight of the newest velocity, 0..1;
    last rad and speed rad/s: the encoder difference so far.
    """

    kp: Array
    kd: Array
    limit: Array
    smoothing: float
    last: Array
    speed: Array


class Log(NamedTuple):
    """What a run leaves, (steps, n): readings, warmth, and the truth behind them."""

    q: Array
    torque: Array
    warm: Array
    true_q: Array
    true_dq: Array
    command: Array


def new_log(steps: int, n: int) -> Log:
    """Empty arrays for a run."""
    return Log(*(np.zeros((steps, n)) for _ in range(6)))


@inner
def _hold(
    arm: Figures,
    state: PlantState,
    work: Scratch,
    reading: Reading,
    command: Array,
    dt: float,
    substeps: int,
    noise: Array,
) -> None:
    deliver(arm.joints, reading, command, dt)
    for _ in range(substeps):
        substep(arm, state, work, reading.true, dt / substeps)
    sense(arm.joints, reading, state.q, noise)


@entry
def advance(
    arm: Figures,
    state: PlantState,
    work: Scratch,
    reading: Reading,
    command: Array,
    dt: float,
    substeps: int,
    noise: Array,
) -> None:
    """Hold ``command`` (n,) for dt seconds and latch a reading with ``noise`` (n,) on it."""
    _hold(arm, state, work, reading, command, dt, substeps, noise)


@entry
def look(arm: Figures, state: PlantState, reading: Reading, noise: Array) -> None:
    """Latch a reading without moving."""
    sense(arm.joints, reading, state.q, noise)


@entry
def follow(
    arm: Figures,
    state: PlantState,
    work: Scratch,
    reading: Reading,
    servo: Servo,
    q: Array,
    dq: Array,
    forward: Array,
    dt: float,
    substeps: int,
    noise: Array,
    log: Log,
) -> None:
    """Follow q, dq (steps, n) with feed-forward torque, one servo action per sample.

    Row k of the log is the reading at the end of the sample in which row k was commanded.
    """
    n = q.shape[1]
    command = np.empty(n)
    for k in range(q.shape[0]):
        for j in range(n):
            difference = (reading.q[j] - servo.last[j]) / dt
            servo.last[j] = reading.q[j]
            servo.speed[j] += servo.smoothing * (difference - servo.speed[j])
            torque = forward[k, j] + servo.kp[j] * (q[k, j] - reading.q[j])
            torque += servo.kd[j] * (dq[k, j] - servo.speed[j])
            command[j] = min(max(torque, -servo.limit[j]), servo.limit[j])
        _hold(arm, state, work, reading, command, dt, substeps, noise[k])
        for j in range(n):
            d = arm.joints[j].rotor
            log.q[k, j] = reading.q[j]
            log.torque[k, j] = reading.torque[j]
            log.warm[k, j] = state.warm[j]
            log.true_q[k, j] = state.q[d]
            log.true_dq[k, j] = state.v[d]
            log.command[k, j] = command[j]
