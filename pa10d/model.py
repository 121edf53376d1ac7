"""A torque model: rigid bodies plus effects, with covariance and lineage.

τ = Y_b(q, q̇, q̈)·h_b + Σ effects. Adding an effect makes a new model with a parent; a model is
never changed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics import BaseParameters, Robot
from pa10d.dynamics.base import parameter_name
from pa10d.effects import Context, Effect, Value, effect
from pa10d.errors import UserError

Array = NDArray[np.float64]

RUBBING = ("coulomb", "viscous")  # friction that needs nothing but the motion
WARMING_ROUNDS = 4  # friction makes heat and heat takes friction: in these the two settle


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

    def full_columns(self, context: Context) -> Array:
        """(N, n, k) torque per unit coefficient at the raw rate."""
        columns = self.effect.columns(context, self.joints, self.shape)
        return spread(self.effect, self.joints, columns, context.robot.n)

    def torque(self, context: Context) -> Array:
        """(N, n) N·m at the raw rate."""
        columns = self.effect.columns(context, self.joints, self.shape)
        if self.effect.reaches_other_joints:
            return np.asarray(columns @ self.coefficients)
        out = np.zeros_like(context.q)
        out[:, self.joints[0]] = columns @ self.coefficients
        return out


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


@dataclass(frozen=True)
class TorqueModel:
    """robot       the tree it stands on (its URDF text travels with it)
    base        which base parameters, and h their values (b,)
    terms       effects in the order in which they were added; textbook ones first
    covariance  (p, p) of [h, all coefficients in order]; standard errors are its diagonal's roots
    noise       (n,) N·m, RMS of the filtered residual of the fit
    cutoff      Hz of the zero-phase low-pass on both sides of the fit
    loads       (b,) base parameters from which effects take their loads where these are not h: a
                model with knocks in it has the loads that most samples agree on
    shift       s, by which the torque channel was found late against position
    standard    (n, 10) feasible standard parameters, or None where none were sought
    runs        names or ids of the runs it was fitted to
    held_out    run or split name -> RMS per joint (n,), N·m
    """

    name: str
    robot: Robot
    base: BaseParameters
    h: Array
    terms: tuple[Term, ...]
    covariance: Array
    noise: Array
    cutoff: float
    shift: float = 0.0
    loads: Array | None = None
    standard: Array | None = None
    feasible: bool = False
    parent: str | None = None
    change: str = "textbook model"
    runs: tuple[str, ...] = ()
    held_out: dict[str, Array] = field(default_factory=dict)
    notes: dict[str, Any] = field(default_factory=dict)

    @property
    def rigid(self) -> Array:
        """(n, 10) standard parameters with the model's base parameters (zeros elsewhere)."""
        return self._standard_form(self.h)

    def _standard_form(self, base: Array) -> Array:
        out = np.zeros(10 * self.robot.n)
        out[self.base.kept] = base
        return out.reshape(self.robot.n, 10)

    @property
    def std_errors(self) -> Array:
        """(p,) standard errors of [h, coefficients]."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))

    def possible(self) -> TorqueModel:
        """The same effects on bodies that can exist: ``standard`` instead of ``h``, and with it
        the coefficients that the feasible fit found within their bounds."""
        if self.standard is None:
            raise UserError(f"model {self.name!r} has no feasible standard parameters")
        found = self.notes.get("feasible", {}).get("coefficients", {})
        own = iter(self.parameter_names()[len(self.h) :])
        terms = []
        for term in self.terms:
            values = [found.get(next(own), float(value)) for value in term.coefficients]
            terms.append(replace(term, coefficients=np.array(values)))
        return replace(self, h=self.base.of(self.standard), terms=tuple(terms))

    def parameter_names(self) -> list[str]:
        """Names of [h, coefficients], such as ``Izz4`` or ``coulomb J2: Fc``."""
        names = [parameter_name(k) for k in self.base.kept]
        for term in self.terms:
            names += [f"{term.label}: {c.name}" for c in term.effect.coefficients]
        return names

    def term_slice(self, index: int) -> slice:
        """Where the coefficients of terms[index] lie in the covariance."""
        start = len(self.h) + sum(len(t.coefficients) for t in self.terms[:index])
        return slice(start, start + len(self.terms[index].coefficients))

    def term_values(self, index: int) -> dict[str, Value]:
        """Parameters of one effect with standard errors and units."""
        term, where = self.terms[index], self.term_slice(index)
        found = term.effect.values(
            term.coefficients, self.covariance[where, where], term.shape, term.shape_errors
        )
        return in_units_of(self.robot, term, found)

    def contextualise(self, context: Context) -> Context:
        """The same motion with this model's loads and total torque.

        Load-dependent effects see the rigid bodies, warming ones the friction that heats them;
        sensing effects see the torque of all mechanical ones.
        """
        textbook, rubbing = self._friction(context)
        own_rotor = [t.joints[0] for t in self.terms if t.effect_id == "rotor_inertia"]
        loaded = replace(
            context,
            rigid=self.rigid if self.loads is None else self._standard_form(self.loads),
            total=np.zeros_like(context.q),
            rubbing=rubbing,
            rotor_in_load=tuple(sorted(set(range(self.robot.n)) - set(own_rotor))),
        )
        own = loaded if self.loads is None else replace(context, rigid=self.rigid)
        total = own.load + textbook
        for term in self.terms:
            if not term.effect.sensing and term.effect_id not in RUBBING:
                total += term.torque(loaded)
        return replace(loaded, total=total)

    def _friction(self, context: Context) -> tuple[Array, Array]:
        """(N, n) N·m each: Coulomb and viscous friction, and what warmth has left of it."""
        textbook = np.zeros_like(context.q)
        for term in self.terms:
            if term.effect_id in RUBBING:
                textbook += term.torque(context)
        left = textbook
        for _ in range(WARMING_ROUNDS):
            seen = replace(context, rubbing=left)
            warming = [t.torque(seen) for t in self.terms if t.effect.feels_own_heat]
            if not warming:
                break
            left = textbook + np.sum(warming, axis=0)
        return textbook, left

    def predict(self, context: Context) -> Array:
        """Torque (N, n) N·m at the raw rate, as the sensors would report it."""
        return self.sensed(self.contextualise(context))

    def sensed(self, seen: Context) -> Array:
        """The same of a motion that ``contextualise`` has seen."""
        out = seen.total.copy()
        for term in self.terms:
            if term.effect.sensing:
                out += term.torque(seen)
        return out
