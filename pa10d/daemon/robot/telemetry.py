"""Live values for everybody who looks: the ring, thinned out, with the last minutes kept."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import AsyncIterator

import numpy as np
from numpy.typing import NDArray

from pa10d.common.jsonable import JsonObject
from pa10d.control.ring import Ring
from pa10d.control.states import ArmState
from pa10d.dynamics.robot import Robot

Rows = NDArray[np.float32]

RATE = 50.0  # rows per second of the loop's time
PERIOD = 0.05  # s between packets
KEPT = 600.0  # s of history
QUEUE = 64  # packets that wait for a slow listener; later ones are dropped
SCALARS = ("state", "fault", "motion", "late", "missed")
VECTORS = ("q", "dq", "tau", "q_ref", "torque", "temperature")


class Telemetry:
    """Packets: float64 start (s on the loop's clock), then float32 rows, time from there first.

    All little-endian. Columns as ``header`` names them; joints numbered from 1.
    """

    def __init__(self, ring: Ring, robot: Robot) -> None:
        self._ring, self.robot = ring, robot
        self._step = max(1, round(1.0 / (ring.period * RATE)))
        self._next = 0
        self._history: deque[tuple[float, Rows]] = deque()
        self._listeners: set[asyncio.Queue[bytes]] = set()
        layout = ring.layout
        places = [layout.scalars[s] for s in SCALARS]
        for v in VECTORS:
            places += range(layout.vectors[v].start, layout.vectors[v].stop)
        self._places = np.array(places)

    @property
    def listeners(self) -> int:
        """How many look."""
        return len(self._listeners)

    def header(self) -> JsonObject:
        """What the columns of every packet are; limits: [lower, upper] per joint, null for none;
        states: what the numbers in ``state`` mean."""
        robot, joints = self.robot, range(1, self.robot.n + 1)
        columns = ["time", *SCALARS, *(f"{v}{j}" for v in VECTORS for j in joints)]
        units = {"time": "s", "late": "s", "q": "rad", "dq": "rad/s", "tau": "N·m"}
        units |= {"q_ref": "rad", "torque": "N·m", "temperature": "°C"}
        rate = 1.0 / (self._ring.period * self._step)
        either_way = {"dq": robot.velocity, "tau": robot.effort}
        limits = {"q": _pairs(robot.lower, robot.upper)}
        limits |= {name: _pairs(-most, most) for name, most in either_way.items()}
        return {
            "columns": columns,
            "joints": list(robot.joint_names),
            "prismatic": robot.prismatic.tolist(),
            "rate": rate,
            "units": units,
            "limits": limits,
            "states": {state.value: state.label for state in ArmState},
        }

    async def run(self) -> None:
        """Follow the ring for ever."""
        while True:
            await asyncio.sleep(PERIOD)
            self.step()

    def step(self) -> None:
        """Take what is new, pass it on."""
        rows, lost = self._ring.read(self._next)
        first = self._next + lost
        self._next = first + len(rows)
        chosen = rows[(-first) % self._step :: self._step]
        if not len(chosen):
            return
        t = chosen[:, self._ring.layout.scalars["time"]]
        if self._history and t[0] <= self._history[-1][0]:
            self._history.clear()  # a new connection: its clock has nothing to do with the past
        start = float(t[0])
        thin = np.empty((len(chosen), 1 + len(self._places)), dtype="<f4")
        thin[:, 0] = t - start
        thin[:, 1:] = chosen[:, self._places]
        self._history.append((start, thin))
        while self._history[0][0] < start - KEPT:
            self._history.popleft()
        packet = _packet(start, thin)
        for queue in self._listeners:
            if not queue.full():
                queue.put_nowait(packet)

    async def listen(self, history: float) -> AsyncIterator[bytes]:
        """Packets from now on, the last ``history`` seconds first (as one packet).

        Ten minutes are put together beside the event loop, which has other things to hear.
        """
        queue: asyncio.Queue[bytes] = asyncio.Queue(QUEUE)
        before = list(self._history)
        self._listeners.add(queue)
        try:
            if before:
                yield await asyncio.to_thread(_together, before, history)
            while True:
                yield await queue.get()
        finally:
            self._listeners.discard(queue)


def _together(parts: list[tuple[float, Rows]], seconds: float) -> bytes:
    since = parts[-1][0] - seconds
    chosen = [(t, rows) for t, rows in parts if t >= since]
    start = chosen[0][0]
    shifted = []
    for t, rows in chosen:
        moved = rows.copy()
        moved[:, 0] += t - start
        shifted.append(moved)
    return _packet(start, np.concatenate(shifted))


def _pairs(lower: NDArray[np.float64], upper: NDArray[np.float64]) -> list[list[float | None]]:
    edges = np.column_stack([lower, upper])
    return [[float(v) if np.isfinite(v) else None for v in pair] for pair in edges]


def _packet(start: float, rows: Rows) -> bytes:
    return np.array([start], dtype="<f8").tobytes() + np.ascontiguousarray(rows).tobytes()
