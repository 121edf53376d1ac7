"""One effect on its joints: a term of a linear model, fitted or yet to be fitted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics import Robot
from pa10d.effects import Context, Effect, Value, all_effects, effect
from pa10d.effects.together import torque_of

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Term:
    """One effect at work in a model, with its fitted values.

    joints: 0-based; empty for a robot-wide effect
    coefficients (k,), shape: name -> value, shape_errors: name -> standard error
    over: quantities of a map
    """

    effect_id: str
    joints: tuple[int, ...]
    coefficients: Array
    shape: dict[str, float] = field(default_factory=dict)
    shape_errors: dict[str, float] = field(default_factory=dict)
    over: tuple[str, ...] = ()

    @property
    def effect(self) -> Effect:
        """The effect's class instance."""
        return effect(self.effect_id, self.over)

    @property
    def label(self) -> str:
        """``stribeck J4`` (joints numbered from 1)."""
        return label(self.effect_id, [j + 1 for j in self.joints], self.over)

    def named(self, value: str) -> str:
        """``stribeck J4: Fs``: one of its coefficients or shapes, as a whole model lists it."""
        return f"{self.label}: {value}"

    @classmethod
    def of(
        cls, effect_id: str, joints: tuple[int, ...], shape: Mapping[str, float] | None = None
    ) -> Term:
        """Not fitted yet: coefficients zero."""
        width = len(effect(effect_id).coefficients)
        return cls(effect_id, joints, np.zeros(width), dict(shape or {}))

    @property
    def width(self) -> int:
        """Number of linear coefficients k."""
        return len(self.effect.coefficients)

    def touches(self, joint: int) -> bool:
        """Whether it has columns in this joint's equation."""
        return self.effect.reaches_other_joints or joint in self.joints[:1]

    def rows(self, context: Context, joint: int) -> Array:
        """(N, k) raw columns in one joint's equation."""
        columns = self.effect.columns(context, self.joints, self.shape)
        return columns[:, joint] if self.effect.reaches_other_joints else columns

    def full_columns(self, context: Context) -> Array:
        """(N, n, k) torque per unit coefficient at the raw rate."""
        columns = self.effect.columns(context, self.joints, self.shape)
        return spread(self.effect, self.joints, columns, context.robot.n)

    def torque(self, context: Context) -> Array:
        """(N, n) N·m at the raw rate."""
        return torque_of(self, context)


def rotors_beside(inertias: Array) -> tuple[Term, ...]:
    """Rotors of joints that have one, kg·m² (kg) per joint."""
    kind = next(kind for kind in all_effects().values() if kind.is_rotor)
    return tuple(Term(kind.id, (j,), inertias[[j]]) for j in map(int, np.flatnonzero(inertias)))


def as_told(robot: Robot, term: Term, values: dict[str, Value]) -> dict[str, Value]:
    """An effect's values in the units of its joints, with what their torque constants may be off
    by in the standard errors."""
    share = robot.gain_share(term.joints)
    whole = {name: value.with_gain_error(share) for name, value in values.items()}
    return in_units_of(robot, term, whole)


def in_units_of(robot: Robot, term: Term, values: dict[str, Value]) -> dict[str, Value]:
    """An effect's values in the units of its joints."""
    if not term.joints or not all(robot.prismatic[j] for j in term.joints):
        return values
    return {name: value.of_a_slide() for name, value in values.items()}


def label(effect_id: str, joints: Sequence[int], over: Sequence[str] = ()) -> str:
    """What a term is called; joints numbered from 1."""
    where = f" J{','.join(map(str, joints))}" if joints else ""
    return f"{effect_id}{where}{' over ' + ', '.join(over) if over else ''}"


def spread(kind: Effect, joints: Sequence[int], columns: Array, n: int) -> Array:
    """Columns of any effect as (N, n, k): those of one equation get zeros elsewhere."""
    if kind.reaches_other_joints:
        return columns
    out = np.zeros((len(columns), n, columns.shape[-1]))
    out[:, joints[0]] = columns
    return out
