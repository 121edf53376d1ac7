"""A weight whose mass is known, and how well that and its place are known."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.dynamics import Robot
from pa10d.dynamics.robot import rigid_body

Array = NDArray[np.float64]

MASS_SHARE = 0.002  # of a mass: a kitchen scale, where nobody says how it was weighed
PLACE = 0.002  # m: a ruler, where nobody says how the centre was found
HEAVIEST, FURTHEST = 1e4, 10.0  # kg, m: beyond, somebody gave grams or millimetres
FORM = "MASS,X,Y,Z in kg and m (each also as VALUE+-ERROR), such as 3+-0.005,0,0,0.1+-0.002"
_NUMBER = re.compile(r"(?P<value>[^±]+?)(?:(?:±|\+-|\+/-)(?P<error>[^±]+))?")


@dataclass(frozen=True)
class Body:
    """mass: kg; com (3,): m, its centre in the last joint's frame; both with standard errors."""

    mass: float
    com: tuple[float, float, float]
    mass_error: float
    com_error: tuple[float, float, float]

    @classmethod
    def of(cls, text: str) -> Body:
        """``3,0,0,0.1`` or ``3+-0.005,0,0,0.1+-0.002``; what is not stated is taken as weighed on
        a kitchen scale and measured with a ruler. UserError for anything else."""
        try:
            pairs = [_pair(part) for part in text.split(",")]
            (mass, mass_error), *centre = pairs
            x, y, z = (value for value, _ in centre)
        except ValueError:
            raise UserError(f"weight {text!r}: expected {FORM}") from None
        body = cls(
            mass, (x, y, z),
            MASS_SHARE * mass if mass_error is None else mass_error,
            tuple(PLACE if error is None else error for _, error in centre),  # type: ignore[arg-type]
        )  # fmt: skip
        body.check(text)
        return body

    def check(self, said: str) -> None:
        """UserError where it cannot be a weight. said: what it was called."""
        errors = (self.mass_error, *self.com_error)
        wrong = (
            "a mass above 0 kg" if not 0 < self.mass < HEAVIEST
            else f"a centre within {FURTHEST:g} m" if not all(abs(c) < FURTHEST for c in self.com)
            else "errors of 0 or more" if not all(0 <= e < HEAVIEST for e in errors)
            else ""
        )  # fmt: skip
        if wrong:
            raise UserError(f"weight {said!r}: expected {FORM}; with {wrong}")

    @property
    def text(self) -> str:
        """As ``of`` reads it."""
        both = zip((self.mass, *self.com), self.errors, strict=True)
        return ",".join(f"{value:g}+-{error:.3g}" for value, error in both)

    @property
    def words(self) -> str:
        """For a sentence."""
        x, y, z = self.com
        return f"{self.mass:g} kg at ({x:g}, {y:g}, {z:g}) m"

    def beside(self, x: float, y: float) -> Body:
        """The same weight hung x, y m further to the side."""
        return replace(self, com=(self.com[0] + x, self.com[1] + y, self.com[2]))

    def parameters(self, robot: Robot) -> Array:
        """(n, 10) standard parameters, all of them of the last link; a point, as the inertia of a
        weight about its own centre counts for nothing in slow motion."""
        table = np.zeros((robot.n, 10))
        table[-1] = rigid_body(self.mass, self.com)
        return table

    def slopes(self, robot: Robot) -> Array:
        """(4, n, 10) change of the parameters per kg of mass and per m of centre (x, y, z)."""
        out = np.zeros((4, robot.n, 10))
        out[0] = self.parameters(robot) / self.mass
        for k, step in enumerate(np.eye(3)):  # quadratic in the centre: exact
            ahead, behind = (rigid_body(self.mass, self.com + side * step) for side in (0.5, -0.5))
            out[1 + k, -1] = ahead - behind
        return out

    @property
    def errors(self) -> Array:
        """(4,) standard errors in the order of ``slopes``."""
        return np.array([self.mass_error, *self.com_error])


def _pair(text: str) -> tuple[float, float | None]:
    found = _NUMBER.fullmatch(text.strip())
    if found is None or not text.replace("±", "").isascii() or "_" in text:
        raise ValueError
    error = found["error"]
    return float(found["value"]), None if error is None else float(error)
