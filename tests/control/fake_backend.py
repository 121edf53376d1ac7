"""Drives in this process, without a bus: what the loop sees of a backend, and faults on request."""

from __future__ import annotations

from typing import Any

import numpy as np

from backends.protocol import BackendFault, Feedback

SWITCH = 4  # cycles in which brakes open or close
PATIENCE = 0.3  # s for drives that never say that they are enabled


class FakeBackend:
    """Any plant of INTERFACES behind ideal drives; brakes hold the arm while it is unpowered."""

    realtime = False

    def __init__(self, plant: Any, period: float = 0.002) -> None:
        self.plant, self.period, self.n = plant, period, plant.n
        self.warnings: list[str] = []
        self.powered = self.opened = False
        self.quick, self.braked = False, True
        self.time = 0.0
        self.torque = np.zeros(self.n)
        self.written: list[np.ndarray] = []  # every torque since the last clear
        self.calls: list[str] = []
        self.fail: dict[str, list[BackendFault]] = {}
        self.unplugged = False  # every call fails
        self.frozen = np.zeros(self.n, dtype=bool)  # axes that do not answer
        self.stuck = np.zeros(self.n, dtype=bool)  # axes that never say that they are enabled
        self.inverted = np.zeros(self.n, dtype=bool)  # axes whose torque has the wrong sign
        self._doing, self._left = "", 0  # what was begun, and cycles to go
        self._age = np.zeros(self.n, dtype=np.int64)
        self._q = plant.measure()[0]

    def open(self) -> None:
        self._enter("open")
        self.opened = True

    def close(self) -> None:
        self.calls.append("close")
        self.opened = self.powered = False
        self.braked, self._left = True, 0

    @property
    def switching(self) -> bool:
        return self._left > 0

    def begin_enable(self) -> None:
        self._enter("enable")
        self._doing, self._left = "enable", SWITCH
        self._until = self.time + PATIENCE

    def read(self) -> Feedback:
        self._enter("read")
        feedback = self._cycle()
        if self._left > 0:
            self._switch()
        return feedback

    def write(self, torque: np.ndarray) -> None:
        self._enter("write")
        assert self.powered or not np.any(torque), "torque written to unpowered drives"
        self.torque = np.array(torque)
        self.written.append(self.torque)

    def quick_stop(self) -> None:
        self._enter("quick_stop")
        self.quick, self._left = True, 0

    def begin_disable(self) -> None:
        self._enter("disable")
        self._doing, self._left = "disable", SWITCH

    def begin_reset(self) -> None:
        self._enter("reset")
        self.powered = self.quick = False
        self.braked = True
        self.frozen[:] = False
        self._doing, self._left = "reset", SWITCH

    def _switch(self) -> None:
        """One step on with what was begun; enabling powers first and opens the brakes then."""
        if self._doing == "enable":
            self.powered = True
            self.braked = self._left > 1
            if self.stuck.any() and self._left == 1:
                axis = int(np.argmax(self.stuck))
                if self.time > self._until:
                    self._left = 0
                    raise BackendFault("never says that it is enabled", axis, kind="timeout")
                return
        else:
            self.braked = True
        self._left -= 1
        if self._left == 0 and self._doing == "disable":
            self.powered = self.quick = False

    def _enter(self, call: str) -> None:
        self.calls.append(call)
        if self.unplugged:
            self.quick = True  # the drives notice that nobody speaks to them
            raise BackendFault("the interface is gone", kind="interface_down")
        if self.fail.get(call):
            raise self.fail[call].pop(0)

    def _cycle(self) -> Feedback:
        self.time += self.period
        if self.powered and not self.quick and not self.braked:
            at = self.plant.measure()[0]
            self.plant.step(np.where(self.inverted, -self.torque, self.torque), self.period)
            if self.stuck.any():  # flywheels alone have a speed that can be taken away
                self.plant.q[self.stuck], self.plant.dq[self.stuck] = at[self.stuck], 0.0
        else:
            self.plant.reset(self.plant.measure()[0])  # brakes, or the drives' own stop
        q, tau = self.plant.measure()
        self._age = np.where(self.frozen, self._age + 1, 0)
        self._q = np.where(self.frozen, self._q, q)
        return Feedback(self.time, self._q.copy(), tau, np.full(self.n, 0x27), self._age)


class RelievingBackend(FakeBackend):
    """Whose drives leave the arm to its brakes with power at hand; ``weak`` ones let it sink."""

    SINKS = 0.4  # rad/s

    def __init__(self, plant: Any, period: float = 0.002) -> None:
        super().__init__(plant, period)
        self.weak = np.zeros(self.n, dtype=bool)
        self.relieved = False

    @property
    def in_brakes(self) -> np.ndarray:
        return np.full(self.n, self.braked and (self.relieved or not self.powered))

    def begin_relieve(self) -> None:
        self._enter("relieve")
        self._doing, self._left = "relieve", SWITCH

    def _switch(self) -> None:
        super()._switch()
        if self._left == 0:
            self.relieved = self._doing == "relieve"

    def _cycle(self) -> Feedback:
        if self.relieved and self.powered:
            sinks = np.where(self.weak, self.SINKS * self.period, 0.0)
            self.plant.reset(self.plant.measure()[0] + sinks)
        return super()._cycle()


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
