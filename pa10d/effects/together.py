"""What the effects of a model add up to, and in which order they may look at each other.

A term is an effect at work: ``effect``, ``joints`` (0-based), ``coefficients`` (k,) and ``shape``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pa10d.effects.base import Effect, Shape
from pa10d.effects.context import Context

Array = NDArray[np.float64]

LEAST_LEVEL = 0.1  # of what bristles usually carry: at none at all they would not bend
WARMING_ROUNDS = 4  # friction makes heat and heat takes friction: in these the two settle


class AtWork(Protocol):
    """One effect with its fitted values."""

    @property
    def effect(self) -> Effect: ...
    @property
    def joints(self) -> Sequence[int]: ...
    @property
    def coefficients(self) -> Array: ...
    @property
    def shape(self) -> Shape: ...


def torque_of(term: AtWork, context: Context, columns: Array | None = None) -> Array:
    """(N, n) N·m at the raw rate; columns: of the effect, where they are there already."""
    if columns is None:
        columns = term.effect.columns(context, term.joints, term.shape)
    if term.effect.reaches_other_joints:
        return np.asarray(columns @ term.coefficients)
    out = np.zeros_like(context.q)
    out[:, term.joints[0]] = columns @ term.coefficients
    return out


def columns_once(term: AtWork, context: Context) -> Array:
    """(N, k) or (N, n, k) columns of a term; those that ``contextualised`` has made are handed
    over and forgotten."""
    made = context.drawn.pop(_whose(term), None)
    return term.effect.columns(context, term.joints, term.shape) if made is None else made


def _whose(term: AtWork) -> tuple[object, ...]:
    return term.effect, tuple(term.joints), *sorted(term.shape.items())


def contextualised(
    context: Context,
    terms: Sequence[AtWork],
    rigid: Array,
    loads: Array | None,
    before: Context | None = None,
) -> Context:
    """The same motion with the loads and the total torque of a model of these bodies and terms.

    before: what was made of this motion with these bodies, whose loads are not computed again.
    rigid, loads: (n, 10) standard parameters, the latter those from which effects take their loads
    where these are others. Load-dependent effects see the rigid bodies, warming ones the friction
    that heats them; sensing effects see the torque of all mechanical ones.
    """
    n = context.robot.n
    named = ("builds_up_over", "damped_over", "smoothed_over")
    ways, lags, corners = (_by_joint(n, terms, names) for names in named)
    context = replace(context, ways=ways, lags=lags, corners=corners)
    textbook, rubbing = friction(context, terms)
    own_rotor = [term.joints[0] for term in terms if term.effect.is_rotor]
    loaded = replace(
        context,
        rigid=rigid if loads is None else loads,
        total=np.zeros_like(context.q),
        rubbing=rubbing,
        rotor_in_load=tuple(sorted(set(range(context.robot.n)) - set(own_rotor))),
        springs=tuple(
            (t.joints[0], t.shape["K"], t.shape["zeta"], t.shape.get("rotor", 0.0))
            for t in terms
            if t.effect.series_spring
        ),
    )
    if before is not None:
        loaded = before.handed_to(loaded)
    loaded = loaded.with_levels(_levels(loaded, terms))
    own = loaded if loads is None else replace(context, rigid=rigid)
    total = own.load + textbook
    for term in terms:
        if not term.effect.sensing and not term.effect.rubs:
            columns = term.effect.columns(loaded, term.joints, term.shape)
            total += torque_of(term, loaded, columns)
            if term.effect.uses_model:  # whoever draws it next need not integrate it again
                loaded.drawn[_whose(term)] = columns
    return loaded.with_total(total)


def _by_joint(joints: int, terms: Sequence[AtWork], names: str) -> tuple[float, ...]:
    """(n,) of each joint the shape parameter that its effect ``names``; 0: none does."""
    out = [0.0] * joints
    for term in terms:
        if name := getattr(term.effect, names):
            out[term.joints[0]] = float(term.shape.get(name, 0.0))
    return tuple(out)


def _levels(context: Context, terms: Sequence[AtWork]) -> Array | None:
    """(N, n) of all friction that a joint's bristles carry, by that to which their way belongs."""
    owners = {t.joints[0]: t.coefficients[0] for t in terms if t.effect.builds_up_over}
    if context.apart or not owners:
        return None
    levels = np.ones_like(context.q)
    for joint, own in owners.items():
        others = [t for t in terms if t.effect.carried and t.joints[0] == joint]
        whole = sum(t.coefficients[0] * t.effect.level(context, t.joints, t.shape) for t in others)
        levels[:, joint] = np.maximum(whole / own, LEAST_LEVEL) if own > 0.0 else 1.0
    return levels


def friction(context: Context, terms: Sequence[AtWork]) -> tuple[Array, Array]:
    """(N, n) N·m each: Coulomb and viscous friction, and what warmth has left of it."""
    textbook = np.zeros_like(context.q)
    for term in terms:
        if term.effect.rubs:
            textbook += torque_of(term, context)
    left = textbook
    for _ in range(WARMING_ROUNDS):
        seen = replace(context, rubbing=left)
        warming = [torque_of(term, seen) for term in terms if term.effect.feels_own_heat]
        if not warming:
            break
        left = textbook + np.sum(warming, axis=0)
    return textbook, left


def sensed(seen: Context, terms: Sequence[AtWork]) -> Array:
    """(N, n) N·m as the sensors would report it, of a motion that ``contextualised`` has seen."""
    out = seen.total.copy()
    for term in terms:
        if term.effect.sensing:
            out += torque_of(term, seen)
    return out
