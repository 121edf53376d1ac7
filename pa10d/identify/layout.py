"""Which unknowns there are, and in which joint's equation each of them stands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.dynamics import BaseParameters, Robot, base_parameters, regressor
from pa10d.dynamics.base import parameter_name, random_motion
from pa10d.effects import TEXTBOOK, Context, Effect, effect

Array = NDArray[np.float64]

SPANNED = 1e-5  # share of a rotor inertia's column outside the rigid base, below which it is in it
START_V0 = 0.01  # rad/s


@dataclass(frozen=True)
class Slot:
    """One effect that is fitted: on which joints (0-based), with which shape."""

    effect_id: str
    joints: tuple[int, ...]
    shape: dict[str, float]

    @property
    def effect(self) -> Effect:
        """The effect's class instance."""
        return effect(self.effect_id)

    @property
    def width(self) -> int:
        """Number of linear coefficients."""
        return len(self.effect.coefficients)

    @property
    def label(self) -> str:
        """``coulomb J2`` (joints numbered from 1)."""
        return f"{self.effect_id} J{','.join(str(j + 1) for j in self.joints)}".removesuffix(" J")

    def touches(self, joint: int) -> bool:
        """Whether the effect has a column in this joint's equation."""
        return self.effect.reaches_other_joints or joint in self.joints[:1]

    def rows(self, context: Context, joint: int) -> Array:
        """(N, k) raw columns in one joint's equation."""
        columns = self.effect.columns(context, self.joints, self.shape)
        return columns[:, joint] if self.effect.reaches_other_joints else columns


@dataclass(frozen=True)
class Layout:
    """The vector of unknowns: b base parameters, then every slot's coefficients.

    seen (n, b): True where a base parameter enters a joint's equation at all
    """

    robot: Robot
    base: BaseParameters
    slots: tuple[Slot, ...]
    seen: NDArray[np.bool_]

    @property
    def size(self) -> int:
        """Number of unknowns p."""
        return len(self.base) + sum(s.width for s in self.slots)

    def where(self, index: int) -> slice:
        """Unknowns of slots[index]."""
        start = len(self.base) + sum(s.width for s in self.slots[:index])
        return slice(start, start + self.slots[index].width)

    @cached_property
    def of_joint(self) -> tuple[NDArray[np.int64], ...]:
        """Per joint: which unknowns stand in its equation, rigid ones first."""
        out = []
        for j in range(self.robot.n):
            slots = [
                np.arange(self.size)[self.where(i)]
                for i, s in enumerate(self.slots)
                if s.touches(j)
            ]
            out.append(np.concatenate([np.flatnonzero(self.seen[j]), *slots]).astype(np.int64))
        return tuple(out)

    def names(self) -> list[str]:
        """``Izz4``, ``coulomb J2: Fc`` …"""
        names = [parameter_name(k) for k in self.base.kept]
        for slot in self.slots:
            names += [f"{slot.label}: {c.name}" for c in slot.effect.coefficients]
        return names

    def owners(self) -> list[tuple[int, ...]]:
        """0-based joint(s) that each unknown belongs to: the link's, or the effect's."""
        out: list[tuple[int, ...]] = [(int(k) // 10,) for k in self.base.kept]
        for slot in self.slots:
            out += [slot.joints] * slot.width
        return out

    def with_shapes(self, shapes: dict[int, dict[str, float]]) -> Layout:
        """The same unknowns with other shapes for some slots (by index)."""
        slots = [replace(s, shape=shapes.get(i, s.shape)) for i, s in enumerate(self.slots)]
        return replace(self, slots=tuple(slots))


def textbook(robot: Robot, extra: Sequence[str] = ()) -> Layout:
    """Rigid bodies, rotor inertia where it is not one of theirs, Coulomb and viscous friction,
    then ``extra`` effects on every joint."""
    base = base_parameters(robot)
    seen, redundant = structure(robot, base)
    slots = [Slot("rotor_inertia", (j,), {}) for j in range(robot.n) if not redundant[j]]
    for j in range(robot.n):
        slots += [Slot("coulomb", (j,), {"v0": START_V0}), Slot("viscous", (j,), {})]
    for name in extra:
        if name in TEXTBOOK:
            continue
        kind = effect(name)
        if kind.question == "chosen":
            raise UserError(
                f"--with {name}: explains nothing; expected an effect (pa10d add … {name} --over "
                "takes quantities that a diagnosis names)"
            )
        if kind.scope == "pair":
            raise UserError(
                f"--with {name}: acts on a pair of joints; expected an effect of one joint or the "
                f"whole robot (pa10d add … {name} --joint 6 7 takes pairs)"
            )
        joints = [(j,) for j in range(robot.n)] if kind.scope == "joint" else [()]
        slots += [Slot(name, on, {}) for on in joints]
    return Layout(robot, base, tuple(slots), seen)


def structure(robot: Robot, base: BaseParameters) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """(n, b): which base parameters load which joint; (n,): whose rotor inertia is one of them."""
    n, samples = robot.n, 200
    q, dq, ddq = random_motion(robot, samples, seed=2)
    columns = regressor(robot, q, dq, ddq, base.kept)
    size = np.abs(columns).max(axis=0)
    seen = size > 1e-12 * size.max(axis=0)
    basis, _ = np.linalg.qr(columns.reshape(samples * n, -1))
    redundant = np.zeros(n, dtype=bool)
    for j in range(n):
        rotor = np.zeros((samples, n))
        rotor[:, j] = ddq[:, j] / np.linalg.norm(ddq[:, j])
        rest = rotor.ravel() - basis @ (basis.T @ rotor.ravel())
        redundant[j] = np.linalg.norm(rest) < SPANNED
    return seen, redundant
