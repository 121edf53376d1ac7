"""Every channel that a recording has, or that follows from it: measured, commanded, modelled."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.control.states import ArmState
from pa10d.dynamics import Robot
from pa10d.effects.together import torque_of
from pa10d.figures.pyramid import Pyramid
from pa10d.judgement import RunResidual
from pa10d.measurement.signals import Lowpass
from pa10d.services.fault_records import read_fault
from pa10d.services.viewed import Channel, Channels
from pa10d.store import StoredRun
from pa10d.store.run_reader import to_equal_steps

Array = NDArray[np.float64]
Made = Callable[[], Array]

VELOCITY_BAND = 40.0  # Hz of a velocity that is differentiated to be looked at
TURNS = ("rad", "rad/s")  # become m and m/s where a joint slides


class Source:
    """A recording with equal steps: its channels, each made when it is asked for.

    start: s on the recording's own clock of its first sample
    """

    def __init__(self, name: str, joints: tuple[str, ...], start: float, dt: float, count: int):
        self.name, self.joints = name, joints
        self.start, self.dt, self.count = start, dt, count
        self.channels: dict[str, Channel] = {}
        self._makers: dict[str, Made] = {}
        self._made: dict[str, Pyramid] = {}

    def add(self, id: str, group: str, unit: str, make: Made, joint: int | None = None) -> None:
        """One more channel; ``make`` gives (N,)."""
        self.channels[id] = Channel(id, group, unit, joint)
        self._makers[id] = make

    def add_joints(
        self, stem: str, group: str, units: Iterable[str], make: Callable[[], Array | None]
    ) -> None:
        """A channel per joint; ``make`` gives (N, n)."""
        for j, unit in enumerate(units):
            self.add(f"{stem}{j + 1}", group, unit, _column(make, j), j + 1)

    def get(self, channel: str) -> Pyramid:
        """One of them; UserError names those there are."""
        if channel not in self._makers:
            known = ", ".join(self._makers)
            raise UserError(f"channel {channel[:60]!r}: expected one of {known}")
        if channel not in self._made:
            self._made[channel] = Pyramid(self._makers[channel]())
        return self._made[channel]

    @property
    def listed(self) -> Channels:
        """What there is."""
        return Channels(
            name=self.name,
            joints=list(self.joints),
            start=self.start,
            seconds=(self.count - 1) * self.dt,
            rate=1.0 / self.dt,
            samples=self.count,
            channels=list(self.channels.values()),
        )


def source_of_run(name: str, run: StoredRun, robot: Robot) -> Source:
    """What was measured and commanded; robot: whose units the joints have."""
    timing, even = to_equal_steps(run.samples, run.time_zero_ns, name)
    grid = timing.grid
    dt = float(grid[-1] - grid[0]) / (len(grid) - 1)
    out = Source(name, run.joints, float(grid[0]), dt, len(grid))
    n = len(run.joints)
    sliding = robot.prismatic if robot.n == n else np.zeros(n, dtype=bool)
    angles = ["m" if s else "rad" for s in sliding]
    speeds = [f"{unit}/s" for unit in angles]
    torques = ["N" if s else "N·m" for s in sliding]
    sent = even.commands
    out.add_joints("q", "position", angles, lambda: even.q)
    if sent is not None:
        out.add_joints("q_ref", "target", angles, lambda: sent.q)
        out.add_joints("error", "tracking error", angles, lambda: sent.q - even.q)
    if even.dq is not None:
        out.add_joints("dq", "velocity", speeds, lambda: even.dq)
    else:
        out.add_joints("dq", "velocity, differentiated", speeds, lambda: _velocity(even.q, dt))
    if sent is not None:
        out.add_joints("dq_ref", "target velocity", speeds, lambda: sent.dq)
    out.add_joints("tau", "torque measured", torques, lambda: even.tau)
    if sent is not None:
        out.add_joints("torque", "torque commanded", torques, lambda: sent.tau)
    if even.temperature is not None:
        out.add_joints("temperature", "temperature", ["°C"] * n, lambda: even.temperature)
    if even.current is not None:
        out.add_joints("i", "current", ["A"] * n, lambda: even.current)
    for extra, values in even.extra.items():
        if extra not in out.channels:
            out.add(extra, "further channels", "", partial(np.asarray, values))
    return out


def add_model(out: Source, name: str, seen: RunResidual, terms: tuple[Any, ...]) -> None:
    """What a model says of the same run: its torque, what is left, and each effect's share.

    Ids begin with the model's name. ``left``, filtered: in the band in which errors are judged.
    """
    robot, equation = seen.seen.robot, seen.equation
    units = [robot.torque_unit(j) for j in range(robot.n)]
    group = f"model {name}"
    low = Lowpass(len(seen.raw_error), equation.lowpass.rate, equation.lowpass.cutoff)
    out.add_joints(
        f"{name}/torque", f"{group}: torque", units, lambda: equation.raw_tau - seen.raw_error
    )
    out.add_joints(f"{name}/residual", f"{group}: residual", units, lambda: seen.raw_error)
    out.add_joints(
        f"{name}/filtered", f"{group}: residual, filtered", units, lambda: low(seen.raw_error)
    )
    for term in terms:
        acting = term.joints or tuple(range(robot.n))
        for j in acting:
            out.add(
                f"{name}/{term.effect_id}/{j + 1}",
                f"{group}: torque of {term.effect_id.replace('_', ' ')}",
                units[j],
                _column(partial(torque_of, term, seen.seen), j),
                j + 1,
            )


def source_of_fault(path: Path) -> Source:
    """The last seconds before a fault; time 0 is when it was latched."""
    record = read_fault(path)
    fields, joints = record.fields, record.joints
    time = fields["time"]
    dt = float(time[-1] - time[0]) / max(1, len(time) - 1)
    out = Source(path.stem, joints, float(time[0] - time[-1]), dt, len(time))
    n = len(joints)

    def several(stem: str, group: str, unit: str, values: Array) -> None:
        out.add_joints(stem, group, [unit] * n, lambda: values)

    several("q", "position", "rad", fields["q"])
    several("q_ref", "target", "rad", fields["q_ref"])
    several("error", "tracking error", "rad", fields["q_ref"] - fields["q"])
    several("dq", "velocity", "rad/s", fields["dq"])
    several("dq_ref", "target velocity", "rad/s", fields["dq_ref"])
    several("tau", "torque measured", "N·m", fields["tau"])
    several("torque", "torque commanded", "N·m", fields["torque"])
    several("temperature", "temperature", "°C", fields["temperature"])
    several("age", "cycles since the axis answered", "", fields["age"])
    out.add("late", "the loop", "s", lambda: fields["late"])
    out.add("busy", "the loop", "s", lambda: fields["busy"])
    out.add("missed", "the loop", "cycles", lambda: fields["missed"])
    words = ", ".join(f"{state.value} {state.label}" for state in ArmState)
    out.add("state", f"the loop: state ({words})", "", lambda: fields["state"])
    return out


def _velocity(q: Array, dt: float) -> Array:
    band = min(VELOCITY_BAND, 0.2 / dt)
    return Lowpass(len(q), 1.0 / dt, band)(q, derivative=1)


def _column(make: Callable[[], Array | None], j: int) -> Made:
    def made() -> Array:
        whole = make()
        assert whole is not None
        return whole[:, j]

    return made
