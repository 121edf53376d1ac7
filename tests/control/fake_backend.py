"""Drives in this process, without a bus: what the loop sees of a backend, and faults on request."""

from __future__ import annotations

from typing import Any

import numpy as np

from backends.protocol import BackendFault, Feedback, Hold


class FakeBackend:
    """Any plant of INTERFACES behind ideal drives; brakes hold the arm while it is unpowered."""

    realtime = False

    def __init__(self, plant: Any, period: float = 0.002) -> None:
        self.plant, self.period, self.n = plant, period, plant.n
        self.warnings: list[str] = []
        self.powered = self.opened = False
        self.quick = False
        self.time = 0.0
        self.torque = np.zeros(self.n)
        self.written: list[np.ndarray] = []  # every torque since the last clear
        self.calls: list[str] = []
        self.fail: dict[str, list[BackendFault]] = {}
        self.unplugged = False  # every call fails
        self.frozen = np.zeros(self.n, dtype=bool)  # axes that do not answer
        self._age = np.zeros(self.n, dtype=np.int64)
        self._q = plant.measure()[0]

    def open(self) -> None:
        self._enter("open")
        self.opened = True

    def close(self) -> None:
        self.calls.append("close")
        self.opened = self.powered = False

    def enable(self, hold: Hold | None = None) -> None:
        self._enter("enable")
        self.powered = True
        for _ in range(3):
            feedback = self._cycle()
            self.torque = np.zeros(self.n) if hold is None else np.array(hold(feedback))
            self.written.append(self.torque)

    def read(self) -> Feedback:
        self._enter("read")
        return self._cycle()

    def write(self, torque: np.ndarray) -> None:
        self._enter("write")
        assert self.powered, "torque written to unpowered drives"
        self.torque = np.array(torque)
        self.written.append(self.torque)

    def quick_stop(self) -> None:
        self._enter("quick_stop")
        self.quick = True

    def disable(self) -> None:
        self._enter("disable")
        self.powered = self.quick = False
        self._cycle()

    def reset(self) -> None:
        self._enter("reset")
        self.powered = self.quick = False
        self.frozen[:] = False

    def _enter(self, call: str) -> None:
        self.calls.append(call)
        if self.unplugged:
            self.quick = True  # the drives notice that nobody speaks to them
            raise BackendFault("the interface is gone", kind="interface_down")
        if self.fail.get(call):
            raise self.fail[call].pop(0)

    def _cycle(self) -> Feedback:
        self.time += self.period
        if self.powered and not self.quick:
            self.plant.step(self.torque, self.period)
        else:
            self.plant.reset(self.plant.measure()[0])  # brakes, or the drives' own stop
        q, tau = self.plant.measure()
        self._age = np.where(self.frozen, self._age + 1, 0)
        self._q = np.where(self.frozen, self._q, q)
        return Feedback(self.time, self._q.copy(), tau, np.full(self.n, 0x27), self._age)


class Flywheels:
    """n rotors with viscous friction that know nothing of each other."""

    def __init__(self, n: int = 2, inertia: float = 1.0, viscous: float = 0.5) -> None:
        self.n, self._inertia, self._viscous = n, inertia, viscous
        self._torque = np.zeros(n)
        self.reset(np.zeros(n))

    def reset(self, q0: np.ndarray) -> None:
        self.q, self.dq = np.array(q0, float), np.zeros(self.n)

    def step(self, torque: np.ndarray, dt: float) -> None:
        self._torque = torque
        for _ in range(4):
            self.dq += dt / 4 * (torque - self._viscous * self.dq) / self._inertia
            self.q += dt / 4 * self.dq

    def measure(self) -> tuple[np.ndarray, np.ndarray]:
        return self.q.copy(), self._torque.copy()
