"""The quantities that an error may depend on, sample by sample."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pa10d.compare.reversals import since_reversal
from pa10d.dynamics import Robot
from pa10d.judgement.residuals import RunResidual
from pa10d.measurement.standstill import since_rest

Array = NDArray[np.float64]
Kind = Literal[
    "q", "dq", "|dq|", "ddq", "load", "time", "temperature", "reversal_time", "reversal_travel",
    "moving",
]  # fmt: skip


@dataclass(frozen=True)
class Quantity:
    """One thing to look at: ``joint`` (0-based) is the one it is measured on.

    own: measured on the joint whose error is judged, not on a neighbour
    """

    kind: Kind
    joint: int
    unit: str
    own: bool = True

    @property
    def name(self) -> str:
        """``dq4``, ``|dq4|``, ``time``: joints numbered from 1."""
        number = self.joint + 1
        return {"|dq|": f"|dq{number}|", "time": "time"}.get(self.kind, f"{self.kind}{number}")

    @property
    def label(self) -> str:
        """For an axis: ``speed of joint 4, rad/s``."""
        words = {
            "q": "position",
            "dq": "velocity",
            "|dq|": "speed",
            "ddq": "acceleration",
            "load": "modelled load",
            "temperature": "temperature",
            "reversal_time": "time since the last reversal",
            "reversal_travel": "travel since the last reversal",
            "moving": "time since the last rest",
        }
        if self.kind == "time":
            return f"time in the run, {self.unit}"
        return f"{words[self.kind]} of joint {self.joint + 1}, {self.unit}"


def quantities(robot: Robot, joint: int, with_temperature: bool) -> list[Quantity]:
    """What joint's error is looked at against: its own motion and load, time, and the motion of
    the joints next to it in the tree."""
    length = robot.angle_unit(joint)
    own = [
        Quantity("q", joint, length),
        Quantity("dq", joint, f"{length}/s"),
        Quantity("|dq|", joint, f"{length}/s"),
        Quantity("ddq", joint, f"{length}/s²"),
        Quantity("load", joint, robot.torque_unit(joint)),
        Quantity("time", joint, "s"),
        Quantity("reversal_time", joint, "s"),
        Quantity("reversal_travel", joint, length),
        Quantity("moving", joint, "s"),
    ]
    if with_temperature:
        own.append(Quantity("temperature", joint, "°C"))
    for other in _neighbours(robot, joint):
        unit = robot.angle_unit(other)
        own += [
            Quantity("q", other, unit, own=False),
            Quantity("dq", other, f"{unit}/s", own=False),
            Quantity("|dq|", other, f"{unit}/s", own=False),
        ]
    return own


class Values:
    """Values of any quantity over one run's filtered samples, each computed once."""

    def __init__(self, run: RunResidual) -> None:
        self._run = run
        self._known: dict[str, Array] = {}

    def __call__(self, quantity: Quantity) -> Array:
        """(M,); nan where it has no value."""
        if quantity.name not in self._known:
            self._known.update(self._compute(quantity))
        return self._known[quantity.name]

    def _compute(self, wanted: Quantity) -> Iterator[tuple[str, Array]]:
        run, j, context = self._run, wanted.joint, self._run.seen
        if wanted.kind in ("reversal_time", "reversal_travel"):
            pair = since_reversal(context.q[:, j], context.dq[:, j], context.dt)
            for kind, values in zip(("reversal_time", "reversal_travel"), pair, strict=True):
                yield f"{kind}{j + 1}", run.decimated(values)
            return
        plain: dict[str, Callable[[], Array]] = {
            "q": lambda: run.decimated(context.q[:, j]),
            "dq": lambda: run.decimated(context.dq[:, j]),
            "|dq|": lambda: np.abs(run.decimated(context.dq[:, j])),
            "ddq": lambda: run.equation.lowpass(context.ddq[:, j]),
            "load": lambda: run.equation.lowpass(context.load[:, j]),
            "time": lambda: run.decimated(context.t),
            "temperature": lambda: self._temperature(j),
            "moving": lambda: self._moving(j),
        }
        yield wanted.name, plain[wanted.kind]()

    def _moving(self, joint: int) -> Array:
        context = self._run.seen
        gone = self._run.decimated(since_rest(context.dq[:, joint], 1.0 / context.dt))
        return np.where(np.isfinite(gone), gone, np.nan)

    def _temperature(self, joint: int) -> Array:
        measured = self._run.seen.temperature
        if measured is None:
            return np.full(len(self._run.measured), np.nan)
        return self._run.decimated(measured[:, joint])


def _neighbours(robot: Robot, joint: int) -> list[int]:
    above = int(robot.parent[joint])
    below = [int(k) for k in np.flatnonzero(robot.parent == joint)]
    return ([above] if above >= 0 else []) + below
