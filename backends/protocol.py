"""The small protocol between the control loop and whatever moves the arm.

One cycle is ``read`` (starts the cycle: SYNC, then the measured state) and ``write`` (torques for
the next one). Everything is joint side, SI units, in the profile's joint order; what a device
calls counts or per mille stays behind this protocol.

No loop hides behind it. ``begin_enable``, ``begin_disable`` and ``begin_reset`` return at once; the
cycles that follow carry them out, one step in each, while their caller watches the arm and listens
to commands as in any other cycle. ``switching`` tells whether one is still under way.

A fault is raised once, by the call that noticed it. The calls after it go on with the axes that
still answer, so that the arm can be stopped in order; ``reset`` makes a clean start possible.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class BackendFault(Exception):
    """The device cannot go on. ``axis`` is 0-based, or None where the whole bus is concerned;
    ``axes``: those that the lines of a cause in several lines speak of, in their order.

    ``kind`` is a stable short name of the row in docs/faults.md, ``remedy`` what to check first.
    """

    def __init__(
        self, cause: str, axis: int | None = None, remedy: str = "", kind: str = "device"
    ) -> None:
        super().__init__(cause)
        self.cause, self.axis, self.remedy, self.kind = cause, axis, remedy, kind
        self.axes: tuple[int, ...] = () if axis is None else (axis,)


@dataclass
class Feedback:
    """What one cycle measured. The arrays are reused by the next ``read``: copy to keep."""

    time: float  # s on the backend's clock (simulated or monotonic)
    q: Array  # (n,) rad
    tau: Array  # (n,) N·m
    status: NDArray[np.int64]  # (n,) words of the device's own (0: none), see device.py
    age: NDArray[np.int64]  # (n,) cycles since the value was fresh; 0 = this cycle
    temperature: Array | None = None  # (n,) °C, NaN until first heard; None: not measured
    answers: NDArray[np.int64] | None = None
    """(n,) of a period each that an axis has given since its fresh value before; None: one."""


class Backend(Protocol):
    """Life: open → (begin_enable → cycles … → begin_disable → cycles)* → close.

    Any call may raise BackendFault. A later ``begin_…`` takes the place of one that is under way.
    """

    n: int
    period: float  # s
    realtime: bool  # False: a read advances simulated time, the loop need not wait

    @property
    def warnings(self) -> list[str]:
        """What the device lacks and what that means, known after ``open``."""
        ...

    def open(self) -> None:
        """Connect, configure and verify; the arm stays unpowered."""

    @property
    def switching(self) -> bool:
        """As of the last ``read``: whether what was begun last is not carried out yet.

        It ends by itself: a device that does not obey in time is a fault of kind ``timeout`` that
        ``read`` raises.
        """
        ...

    def begin_enable(self) -> None:
        """Power all axes in parallel, then release all brakes together, in the next cycles.

        The torques that are written meanwhile meet the load as the brakes open.
        """

    def read(self) -> Feedback:
        """Start a cycle and return its measurement; go one step on with what was begun."""
        ...

    def write(self, torque: Array) -> None:
        """Send joint-side torques, (n,) N·m, for the running cycle."""

    def quick_stop(self) -> None:
        """Ask every axis for its quick stop; the following reads carry it out."""

    def begin_disable(self) -> None:
        """Brakes on, then power off, in the next cycles; an axis that is silent is left aside.

        The torques that are written meanwhile hold the load until the brakes do.
        """

    def begin_reset(self) -> None:
        """Acknowledge faults on every axis; the arm is unpowered, now and afterwards.

        A device that has forgotten its configuration gets it here, as in ``open``: this one call
        may take seconds. Cycles, of which the torques are zero, do the rest.
        """

    def close(self) -> None:
        """Leave the bus as it was found."""


@runtime_checkable
class OpensOneByOne(Protocol):
    """A backend whose axes have brakes of their own, which need not open together."""

    def begin_enable_one_by_one(self) -> None:
        """As ``begin_enable``, but before the brakes open together each opens alone until its joint
        rests, so that one that falls is known; joints without a brake are held meanwhile."""

    @property
    def out_of_brakes(self) -> tuple[int, ...] | None:
        """Axes that are free while all others are in their brakes: those without one, and that
        which is tried. None: no brake opens alone now."""
        ...

    def try_again(self) -> None:
        """The joint that is tried falls: its brake closes at once, and opens alone once more."""


@runtime_checkable
class CoastsUntilTrusted(Protocol):
    """A backend whose axes, at a fault that their drives find by themselves, have no power at once
    until the sign of their torque is known: a ramp would drive a joint of the wrong one on."""

    def trust(self, axes: Collection[int]) -> None:
        """Those whose torque was seen to act the right way round, no others: their drives brake
        along their ramps. At any time, also before ``open``."""


@runtime_checkable
class ShowsRamps(Protocol):
    """A backend whose drives tell that they brake their axes by themselves."""

    @property
    def ramping(self) -> NDArray[np.bool_]:
        """(n,) as of the last ``read``: whether an axis is in its drive's own ramp."""
        ...


@runtime_checkable
class ShowsBrakes(Protocol):
    """A backend whose drives tell that a brake is not open yet, though it was told to."""

    @property
    def in_brakes(self) -> NDArray[np.bool_]:
        """(n,) as of the last ``read``: whether an axis is in its closed brake, also where its
        drive has power already. Not of an axis of which that is not sure."""
        ...


@runtime_checkable
class RelievesMotors(Protocol):
    """A backend that can leave the load to the brakes, and have power at hand meanwhile."""

    def begin_relieve(self) -> None:
        """As ``begin_disable``, but the axes stay as near to power as they can be without any
        torque: ``begin_enable`` gives it again at once, ``begin_disable`` takes what is left."""


@runtime_checkable
class CutsPower(Protocol):
    """A backend whose axes can each be left to their brakes alone."""

    def cut_power(self, axis: int) -> None:
        """As ``quick_stop``, but this axis, and those that were named before, have no power until
        they are enabled again, and their brakes close: what their drives do drives them on."""
