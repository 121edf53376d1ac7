"""What every motion is: a duration, and position, velocity and acceleration at any time."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject

Array = NDArray[np.float64]
MotionState = tuple[Array, Array, Array]


class MotionSamples(NamedTuple):
    """t (N,) s; q, dq, ddq (N, n) rad, rad/s, rad/s²."""

    t: Array
    q: Array
    dq: Array
    ddq: Array


@dataclass(frozen=True)
class Motion(ABC):
    """Begins and ends at rest. Sub-classes are dataclasses of numbers and arrays, so that a motion
    goes into a YAML file and back without loss."""

    name: ClassVar[str]
    known: ClassVar[dict[str, type[Motion]]] = {}

    def __init_subclass__(cls, **options: object) -> None:
        super().__init_subclass__(**options)
        if "name" in cls.__dict__:
            Motion.known[cls.name] = cls

    @property
    @abstractmethod
    def n(self) -> int:
        """Number of joints."""

    @property
    @abstractmethod
    def duration(self) -> float:
        """s."""

    @abstractmethod
    def at(self, t: Array) -> MotionState:
        """q, dq, ddq (N, n) at times t (N,) s, 0 … duration."""

    @property
    def steady(self) -> tuple[float, float]:
        """Begin and end, s, of the part that an analysis uses: without run-up and run-out."""
        return 0.0, self.duration

    @property
    def start(self) -> Array:
        """(n,) pose at the beginning."""
        return self.at(np.zeros(1))[0][0]

    @property
    def end(self) -> Array:
        """(n,) pose at the end."""
        return self.at(np.array([self.duration]))[0][0]

    def sample(self, rate: float) -> MotionSamples:
        """From the beginning to the last tick before or at the end, ``rate`` times a second."""
        t = np.arange(int(np.floor(self.duration * rate + 1e-9)) + 1) / rate
        return MotionSamples(t, *self.at(t))

    def to_dict(self) -> JsonObject:
        """Plain numbers and lists."""
        out: JsonObject = {"motion": self.name}
        for field in fields(self):
            value = getattr(self, field.name)
            out[field.name] = value.tolist() if isinstance(value, np.ndarray) else value
        return out

    @classmethod
    def _from_fields(cls, data: Mapping[str, Any]) -> Self:
        names = {field.name for field in fields(cls)}
        wrong = sorted(set(data) - names - {"motion"}) + sorted(names - set(data))
        if wrong:
            raise UserError(
                f"motion {cls.name!r}: {', '.join(wrong)}; expected exactly "
                f"{', '.join(sorted(names))}"
            )
        given = {k: data[k] for k in names}
        return cls(**{k: _array(cls.name, k, v) for k, v in given.items()})


def motion_from_dict(data: Mapping[str, Any]) -> Motion:
    """The reverse of ``to_dict``."""
    name = data.get("motion")
    if name not in Motion.known:
        raise UserError(
            f"motion: found {name!r}, expected one of {', '.join(sorted(Motion.known))}"
        )
    return Motion.known[name]._from_fields(data)


def _array(motion: str, key: str, value: Any) -> Any:
    if not isinstance(value, list):
        return value
    try:
        array = np.array(value, dtype=float)
    except (TypeError, ValueError) as error:
        raise UserError(
            f"motion {motion!r}: {key}: expected rows of numbers, all as long"
        ) from error
    if not np.isfinite(array).all():
        raise UserError(f"motion {motion!r}: {key}: expected finite numbers")
    return array
