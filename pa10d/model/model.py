"""A torque model: rigid bodies plus effects, with covariance and lineage.

τ = Y_b(q, q̇, q̈)·h_b + Σ effects. Adding an effect makes a new model with a parent; a model is
never changed.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pa10d.common.errors import UserError
from pa10d.dynamics import BaseParameters, Robot
from pa10d.dynamics.base import parameter_name, parameter_unit
from pa10d.dynamics.rotors import rotors_within
from pa10d.dynamics.typical import typical_inertia
from pa10d.effects import Context, Value
from pa10d.effects.context import posed
from pa10d.effects.together import contextualised, sensed
from pa10d.measurement.torque_filter import TorqueFilter
from pa10d.model.estimates import as_estimates
from pa10d.model.names import AGAIN, told_apart
from pa10d.model.notes import ModelNotes
from pa10d.model.shared_friction import beside_bristles
from pa10d.model.term import Term, as_told, rotors_beside
from pa10d.model.unknowns import Unknowns

Array = NDArray[np.float64]

Parameters = Literal["free", "feasible"]


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
    channel     low-pass that the torque passed before it was recorded, None where none was found;
                torques here are those before it
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
    channel: TorqueFilter | None = None
    loads: Array | None = None
    standard: Array | None = None
    feasible: bool = False
    parent: str | None = None
    change: str = "textbook model"
    runs: tuple[str, ...] = ()
    held_out: dict[str, Array] = field(default_factory=dict)
    notes: ModelNotes = field(default_factory=ModelNotes)

    @cached_property
    def unknowns(self) -> Unknowns:
        """What stands where in [h, all coefficients in order]."""
        return Unknowns(self.base, self.terms)

    @property
    def rigid(self) -> Array:
        """(n, 10) standard parameters with the model's base parameters (zeros elsewhere)."""
        return self._standard_form(self.h)

    @property
    def load_bodies(self) -> Array:
        """(n, 10) the same of the base parameters from which effects take their loads."""
        return self.rigid if self.loads is None else self._standard_form(self.loads)

    def _standard_form(self, base: Array) -> Array:
        out = np.zeros(10 * self.robot.n)
        out[self.base.kept] = base
        return out.reshape(self.robot.n, 10)

    @property
    def std_errors(self) -> Array:
        """(p,) standard errors of [h, coefficients], torque constants taken as they are stated."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))

    @property
    def left_open(self) -> frozenset[str]:
        """Names of the unknowns that the data of the fit leave open."""
        return frozenset(self.notes.open)

    @property
    def base_values(self) -> list[Value]:
        """h with the whole of its doubt, the torque constants' included."""
        share = self.robot.gain_share(())
        names = [parameter_name(k) for k in self.base.kept]
        return [
            Value(
                float(v), float(e), parameter_unit(name), determined=name not in self.left_open
            ).with_gain_error(share)
            for v, e, name in zip(self.h, self.std_errors, names, strict=False)
        ]

    def possible(self) -> TorqueModel:
        """The same effects on bodies that can exist: ``standard`` instead of ``h``, and with it
        the coefficients that the feasible fit found within their bounds, and its rotors."""
        if self.standard is None:
            raise UserError(f"model {self.name!r} has no feasible standard parameters")
        noted = self.notes.feasible
        found = {} if noted is None else noted.coefficients
        own = iter(self.parameter_names()[len(self.h) :])
        terms = []
        for term in self.terms:
            values = [found.get(next(own), float(value)) for value in term.coefficients]
            terms.append(replace(term, coefficients=np.array(values)))
        changed = replace(self, h=self.base.of(self.standard), terms=tuple(terms))
        return changed if noted is None else changed._with_rotors(np.array(noted.rotors))

    def _with_rotors(self, rotors: Array) -> TorqueModel:
        """Beside bodies of their own. Torque shows the sum: how sure each is nobody knows. Effects
        go on to take their loads from the sum, as they did when they were fitted."""
        beside = rotors_beside(rotors)
        if not beside:
            return self
        size, names = len(self.covariance), self.parameter_names()
        changed = replace(self, terms=(*self.terms, *beside))
        covariance = np.diag(np.full(changed.unknowns.size, np.inf))
        covariance[:size, :size] = self.covariance
        notes = self.notes.with_open(told_apart(changed.parameter_names())[len(names) :])
        if notes.feasible is not None:
            notes = replace(notes, feasible=replace(notes.feasible, rotors=()))
        loads = self.loads
        if loads is None and any(term.effect.uses_model for term in self.terms):
            within = rotors_within(self.robot, self.base)
            loads = self.h + within.share @ rotors[list(within.joints)]
        return replace(changed, covariance=covariance, notes=notes, loads=loads)

    def of(self, parameters: Parameters) -> TorqueModel:
        """The model with these parameters: itself, or the ``possible`` one."""
        if parameters not in ("free", "feasible"):
            raise UserError(f"parameters {parameters!r}: expected 'free' or 'feasible'")
        return self if parameters == "free" else self.possible()

    def parameter_names(self) -> list[str]:
        """Names of [h, coefficients], such as ``Izz4`` or ``coulomb J2: Fc``."""
        return self.unknowns.names()

    def term_slice(self, index: int) -> slice:
        """Where the coefficients of terms[index] lie in the covariance."""
        return self.unknowns.places[index]

    def term_values(self, index: int) -> dict[str, Value]:
        """Parameters of one effect with standard errors and units."""
        term, where = self.terms[index], self.term_slice(index)
        found = term.effect.values(
            term.coefficients, self.covariance[where, where], term.shape, term.shape_errors
        )
        found = beside_bristles(self.terms, term, found)
        kind, place = term.effect, (term.effect_id, term.joints)
        others = [k for k, t in enumerate(self.terms) if (t.effect_id, t.joints) == place]
        again = AGAIN if others[0] < index else ""
        for name, value in found.items():
            if term.named(name) + again in self.left_open:
                found[name] = replace(value, determined=False)
        once = not (kind.repeatable or kind.one_of_each)
        # a change of what is there already, or of two that share what each may have
        less = others[0] < index if once else bool(kind.one_of_each) and len(others) > 1
        sprung = kind.series_spring or "rotor" in term.shape
        moved = self._moved(term.joints[0]) if sprung else np.inf
        told = kind.beside_link(as_estimates(term, found, less, moved), moved)
        return as_told(self.robot, term, told)

    def _moved(self, joint: int) -> float:
        """kg·m² (kg): the inertia that a joint moves, its rotor included."""
        return float(typical_inertia(self.robot, self.rigid)[joint])

    def coefficient_values(self, index: int) -> dict[str, Value]:
        """Of one effect, each as ``term_values`` has it where that has it: one error everywhere."""
        term, told = self.terms[index], self.term_values(index)
        errors = self.std_errors[self.term_slice(index)]
        share = self.robot.gain_share(term.joints)
        return {
            c.name: told.get(c.name) or Value(float(v), float(e), c.unit).with_gain_error(share)
            for c, v, e in zip(term.effect.coefficients, term.coefficients, errors, strict=True)
        }

    def contextualise(self, context: Context, before: Context | None = None) -> Context:
        """The same motion with this model's loads and total torque; before: what it made of this
        motion when links began otherwise."""
        loads = None if self.loads is None else self.load_bodies
        return contextualised(context, self.terms, self.rigid, loads, before)

    def predict(self, context: Context) -> Array:
        """Torque (N, n) N·m at the raw rate, as the sensors would report it."""
        return self.sensed(self.contextualise(context))

    def sensed(self, seen: Context) -> Array:
        """The same of a motion that ``contextualise`` has seen."""
        return sensed(seen, self.terms)

    def torque(
        self,
        q: ArrayLike,
        dq: ArrayLike,
        ddq: ArrayLike,
        time: ArrayLike | None = None,
        parameters: Parameters = "free",
        temperature: ArrayLike | None = None,
    ) -> Array:
        """Torque (N, n) in N·m (N where a joint slides), as the sensors would report it.

        q, dq, ddq: (N, n) rad, rad/s, rad/s² (m …), or (n,) for one sample, which gives (n,)
        time: (N,) s at equal steps: the samples are one motion, and effects remember. Without it
            each stands for itself: friction slides, a joint is cold, a spring rests under its load
        parameters: "free", the unconstrained fit as ``compare`` judges it, or "feasible", bodies
            that can exist and coefficients within their bounds
        temperature: (N, n) °C, where it is known
        """
        context = posed(self.robot, q, dq, ddq, time, temperature)
        out = self.of(parameters).predict(context)
        return out[0] if np.ndim(q) == 1 else out
