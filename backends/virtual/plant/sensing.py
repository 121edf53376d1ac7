"""What encoders and current sensors make of the truth, and what the motors make of a command."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from backends.virtual.plant.compiled import inner
from backends.virtual.plant.gather import per_joint
from backends.virtual.plant.hidden import Hidden
from backends.virtual.plant.records import Array, Ints, Table

HISTORY = 512  # steps a delayed torque can reach back: 0.13 s of the finest inside a drive


class Sensing(NamedTuple):
    """Per joint (n,): resolution rad (0: exact), encoder offset rad, torque gain, offset, delay s.

    cubic, 1/(N·m)²: what the motor loses, true = command - cubic · command³; believed: N·m that
    command and current sensor stand for, per N·m that the motor makes (its torque constant is off).
    """

    resolution: Array
    encoder_offset: Array
    gain: Array
    offset: Array
    delay: Array
    cubic: Array
    believed: Array


class Reading(NamedTuple):
    """q, torque (n,): the latest reading; held (HISTORY, n), span (HISTORY,): a ring of commands
    and how long each was held, newest at head[0]; true (n,): torque the motors deliver."""

    q: Array
    torque: Array
    held: Array
    span: Array
    head: Ints
    true: Array


def sensing_of(effects: Sequence[Hidden], n: int, resolution: Array, believed: Array) -> Sensing:
    """Collect the errors of sensors and motors."""
    return Sensing(
        resolution=resolution,
        encoder_offset=per_joint(effects, "encoder_offset", "offset", n),
        gain=per_joint(effects, "torque_gain", "gain", n, 1.0),
        offset=per_joint(effects, "torque_offset", "offset", n),
        delay=per_joint(effects, "torque_delay", "Td", n),
        cubic=per_joint(effects, "torque_saturation", "cubic", n),
        believed=believed,
    )


def new_reading(n: int) -> Reading:
    """Before the first step: no torque has been held yet."""
    span = np.full(HISTORY, np.inf)
    return Reading(
        np.zeros(n), np.zeros(n), np.zeros((HISTORY, n)), span, np.zeros(1, np.int64), np.zeros(n)
    )


@inner
def deliver(joints: Table, reading: Reading, command: Array, dt: float) -> None:
    """Note the command held for dt and work out the torque that really acts."""
    head = (reading.head[0] + 1) % HISTORY
    reading.head[0] = head
    reading.span[head] = dt
    for j in range(command.shape[0]):
        reading.held[head, j] = command[j]
        cubic, x = joints[j].cubic, command[j] / joints[j].believed
        if cubic > 0.0:
            top = 1.0 / math.sqrt(3.0 * cubic)
            x = min(max(x, -top), top)
        reading.true[j] = x - cubic * x * x * x


@inner
def sense(joints: Table, reading: Reading, coordinates: Array, noise: Array) -> None:
    """Latch a reading: rotor angles as counted, torque averaged over the last step."""
    for j in range(noise.shape[0]):
        q = coordinates[joints[j].rotor] + joints[j].encoder_offset
        if joints[j].resolution > 0.0:
            q = math.floor(q / joints[j].resolution + 0.5) * joints[j].resolution
        reading.q[j] = q
        measured = _held_between(reading, j, joints[j].delay, reading.span[reading.head[0]])
        reading.torque[j] = joints[j].gain * measured + joints[j].offset + noise[j]


@inner
def _held_between(reading: Reading, j: int, age: float, width: float) -> float:
    """Mean command over the window that ended ``age`` seconds ago and is ``width`` long."""
    if not width < math.inf:
        return reading.held[reading.head[0], j]
    total, start = 0.0, 0.0
    for back in range(HISTORY):
        k = (reading.head[0] - back) % HISTORY
        end = start + reading.span[k]
        overlap = min(end, age + width) - max(start, age)
        if overlap > 0.0:
            total += overlap * reading.held[k, j]
        if end >= age + width:
            break
        start = end
    return total / width
