"""What stands around an arm, in the frame of its base: the plane it is mounted on, and boxes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Box:
    """A solid that does not move. size (3,) m, whole lengths; position (3,) m of its centre and
    rotation (3, 3) of its axes in the base frame."""

    name: str
    size: Array
    position: Array
    rotation: Array


@dataclass(frozen=True)
class Environment:
    """floor: m along the base's z axis, None for none."""

    floor: float | None = 0.0
    boxes: tuple[Box, ...] = ()

    def parts(self) -> list[str]:
        """What an arm keeps clear of."""
        floor = [] if self.floor is None else [f"the floor at {self.floor:g} m"]
        return [*floor, *(f"'{box.name}'" for box in self.boxes)]

    def __str__(self) -> str:
        *most, last = self.parts() or ["no floor"]
        return f"{', '.join(most)} and {last}" if most else last


EMPTY = Environment()  # nothing but the plane that the arm is mounted on
