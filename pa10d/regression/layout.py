"""Which unknowns there are, and in which joint's equation each of them stands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.common.words import from_one
from pa10d.dynamics import Robot, base_parameters
from pa10d.dynamics.rotors import rotors_within
from pa10d.effects import Effect, all_effects, effect
from pa10d.effects.smooth_map import SmoothMap
from pa10d.model import Term, Unknowns

Array = NDArray[np.float64]

START_V0 = 0.01  # rad/s


@dataclass(frozen=True)
class Layout(Unknowns):
    """The unknowns of a robot's equations, and in which joint's equation each stands.

    seen (n, b): True where a base parameter enters a joint's equation at all
    """

    robot: Robot
    seen: NDArray[np.bool_]

    @cached_property
    def of_joint(self) -> tuple[NDArray[np.int64], ...]:
        """Per joint: which unknowns stand in its equation, rigid ones first."""
        out = []
        for j in range(self.robot.n):
            own = [
                np.arange(place.start, place.stop)
                for term, place in zip(self.terms, self.places, strict=True)
                if term.touches(j)
            ]
            out.append(np.concatenate([np.flatnonzero(self.seen[j]), *own]).astype(np.int64))
        return tuple(out)

    @property
    def follows_model(self) -> bool:
        """Whether columns of some term change with the model's loads and torques."""
        return any(term.effect.uses_model for term in self.terms)

    @property
    def has_springs(self) -> bool:
        """Whether links of some joint swing behind its gear."""
        return any(term.effect.series_spring for term in self.terms)

    def with_shapes(self, shapes: dict[int, dict[str, float]]) -> Layout:
        """The same unknowns with other shapes for some terms (by index)."""
        terms = [replace(t, shape=shapes.get(i, t.shape)) for i, t in enumerate(self.terms)]
        return replace(self, terms=tuple(terms))


def textbook(robot: Robot, extra: Sequence[str] = ()) -> Layout:
    """Rigid bodies, rotor inertia where it is not one of theirs, Coulomb and viscous friction,
    then ``extra`` effects: ``stribeck`` on every joint, ``stribeck:2`` on the second one."""
    base = base_parameters(robot)
    rotors = rotors_within(robot, base)
    kinds = [kind for kind in all_effects().values() if kind.question == "textbook"]
    terms = [
        Term.of(kind.id, (j,))
        for kind in kinds
        if kind.is_rotor
        for j in range(robot.n)
        if j not in rotors.joints
    ]
    for j in range(robot.n):
        terms += [begun(kind, j) for kind in kinds if not kind.is_rotor]
    for asked in extra:
        name, joint = told_place(asked, robot.n)
        if name in {kind.id for kind in kinds}:
            continue
        kind = effect(name)
        if kind.question == "chosen":
            raise UserError(
                f"--with {name}: explains nothing; expected an effect (pa10d add … {SmoothMap.id} "
                "--over takes quantities that a diagnosis names)"
            )
        if kind.scope == "pair":
            raise UserError(
                f"--with {name}: acts on a pair of joints; expected an effect of one joint or the "
                f"whole robot (pa10d add … {name} --joint 6 7 takes pairs)"
            )
        if joint is not None and kind.scope == "robot":
            raise UserError(f"--with {asked}: acts on the whole robot, expected {name} alone")
        joints = range(robot.n) if joint is None else (joint,)
        told = (
            [Term.of(name, (j,)) for j in joints] if kind.scope == "joint" else [Term.of(name, ())]
        )
        there = {(t.effect_id, t.joints) for t in terms}
        terms += [t for t in told if (t.effect_id, t.joints) not in there]
    return Layout(base, tuple(terms), robot, rotors.seen)


def told_place(asked: str, n: int | None = None) -> tuple[str, int | None]:
    """Id and joint (from 0; None: every one) of an effect that is told, of ``n`` joints."""
    name, colon, number = asked.partition(":")
    if not colon:
        return name, None
    known = "1 to the last" if n is None else from_one(n)
    if not (number.isdecimal() and number.isascii()) or not 1 <= int(number) <= (n or int(number)):
        raise UserError(f"--with {asked}: found joint {number!r}, expected {known}")
    return name, int(number) - 1


def begun(kind: Effect, joint: int) -> Term:
    """A textbook effect of one joint with the shape that is usual before the data are asked."""
    return Term.of(kind.id, (joint,), {kind.smoothed_over: START_V0} if kind.smoothed_over else {})


def has_sign(term: Term, joint: int) -> bool:
    """Whether this is the joint's dry friction, how sharp whose sign is the data are asked."""
    return bool(term.effect.smoothed_over) and term.joints == (joint,)
