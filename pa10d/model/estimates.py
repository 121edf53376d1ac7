"""Which numbers of a term are estimates: a number alone does not say so.

What lies at the end of what it may be was stopped there, or has run on: it answers to something
else. What is derived of an unknown is as unknown. And where an effect may as well be nothing by
the errors of all its sizes, none of them is told.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from pa10d.common.words import listed, rounded
from pa10d.effects import Coefficient, Effect, ShapeParameter, Value
from pa10d.effects.base import SURELY
from pa10d.effects.rotor import ROTOR
from pa10d.model.term import Term

NEAR = 1e-3  # of an end: there a search was stopped by it
BEYOND = 3.0  # standard errors below nothing: no accident (0.1 %, one-sided)


def as_estimates(
    term: Term, found: Mapping[str, Value], less: bool, inertia: float = float("inf")
) -> dict[str, Value]:
    """The parameters ``found`` of a term, those that are none marked; less: it may be below
    nothing, beside what else the model has there; inertia: kg·m² that its joint moves, of which the
    rotor is a part."""
    kind = term.effect
    coefficients = {c.name: c for c in kind.coefficients}
    told = {n: c for n, c in coefficients.items() if not (c.nuisance or c.whole_at_one)}
    out = dict(found)
    for name, value in found.items():
        shape = next((s for s in kind.shapes_in(term.shape) if s.name == name), None)
        beyond = (name in told and not less and _ended(value, told[name])) or (
            shape is not None
            and (_stopped(value, shape) or (name == ROTOR.name and value.value >= inertia))
        )
        if beyond:
            out[name] = replace(value, determined=False, beyond=True)
    sizes = [out[name] for name in told if name in out]
    added = less or kind.question != "textbook"
    if added and sizes and all(SURELY * v.std_error > abs(v.value) for v in sizes):
        out.update({n: replace(out[n], determined=False) for n in told if n in out})
    if added and may_be_nothing(term, out):
        # a law of which there may as well be nothing has no shape
        shapes = {s.name for s in kind.shapes_in(term.shape) if s.scale != "choice"}
        out.update({n: replace(out[n], determined=False) for n in shapes & out.keys()})
    others = out.keys() - coefficients.keys() - {s.name for s in kind.shapes} - kind.derived.keys()
    for name in others if added else ():  # sizes that are made of several
        if SURELY * out[name].std_error > abs(out[name].value):
            out[name] = replace(out[name], determined=False)
    for name, needs in kind.derived.items():
        if name in out and not all(out[n].determined for n in needs if n in out):
            out[name] = replace(out[name], determined=False)
    return out


def no_estimates(term: Term, found: Mapping[str, Value]) -> str:
    """A sentence on those of a term's parameters that are beyond; empty where there is none."""
    said = [_said(term, name, v) for name, v in found.items() if v.beyond]
    if not said:
        return ""
    each = "that is no estimate" if len(said) == 1 else "these are no estimates"
    why = "where something else has drawn it"
    if term.effect.tells_sign:
        why += ", or its torque or its angle counts the other way (a check of the run tells)"
    return f"{term.label}: {listed(said)}: {each}, but {why}"


def may_be_nothing(term: Term, found: Mapping[str, Value]) -> bool:
    """Of an effect that its shape describes whole: may its share as well be zero?"""
    shares = [found[c.name] for c in term.effect.coefficients if c.whole_at_one and c.name in found]
    return bool(shares) and all(SURELY * v.std_error_random > abs(v.value) for v in shares)


def no_whole(term: Term, found: Mapping[str, Value]) -> bool:
    """Of an effect that its shape describes whole: is its share, but for noise, beyond what it may
    be?"""
    shares = [
        (c, found[c.name]) for c in term.effect.coefficients if c.whole_at_one and c.name in found
    ]
    return any(
        max(c.lower - v.value, v.value - c.upper) > SURELY * v.std_error_random for c, v in shares
    )


def not_one(term: Term, found: Mapping[str, Value]) -> bool:
    """Is not one of a term's numbers an estimate? Left out are those that are chosen, and shares
    of what a shape says."""
    kind = term.effect
    no_size = {s.name for s in kind.shapes if s.scale == "choice"}
    no_size |= {c.name for c in kind.coefficients if c.whole_at_one}
    told = [value for name, value in found.items() if name not in no_size]
    return bool(told) and not any(value.determined for value in told)


def _said(term: Term, name: str, value: Value) -> str:
    kind: Effect = term.effect
    parameters: list[Coefficient | ShapeParameter] = [*kind.coefficients, *kind.shapes]
    of = next(p for p in parameters if p.name == name)
    out = f"{name} comes out at {rounded(value.value, 3)}{value.unit_after}"
    if of.name == ROTOR.name:
        return f"{out}, and all that the joint moves is less"
    if value.value < of.lower == 0.0:
        return f"{out}, and nothing has less than none"
    ends = f"{of.lower:g} to {of.upper:g}" if of.lower > -float("inf") else f"up to {of.upper:g}"
    return f"{out}, the end of what it may be ({ends}) or more"


def _ended(value: Value, of: Coefficient) -> bool:
    """At or beyond an end; nothing is an end only for what is clearly below it."""
    if of.lower == 0.0 and value.value < -BEYOND * value.std_error:
        return True
    above = of.upper < float("inf") and value.value >= of.upper - NEAR * abs(of.upper)
    below = -float("inf") < of.lower < 0.0 and value.value <= of.lower + NEAR * abs(of.lower)
    return bool(above or below)


def _stopped(value: Value, of: ShapeParameter) -> bool:
    """Fitted, and at an end of what is looked at. What was told may be anything."""
    if of.smoothing or of.scale == "choice" or value.std_error == 0.0:
        return False
    if of.scale == "log":
        return of.at_edge(value.value)
    # nothing is what a joint may have of it, and so is what the field's own law has
    ends = [end for end in (of.lower, of.upper) if end and end != of.usual]
    return any(abs(value.value - end) <= NEAR * abs(end) for end in ends)
