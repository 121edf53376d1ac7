"""A model as straight-line code: what it computes, written down while it predicts one sample.

The exported Python module is run on symbols, so that whatever language the statements are in, they
are the same formulae.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pa10d.export import trace
from pa10d.export.python_module import python_module
from pa10d.export.trace import Node, NotTraceable, Traced, in_order, traced
from pa10d.export.words import grouped
from pa10d.model import Term, TorqueModel


@dataclass(frozen=True)
class Language:
    """operators: operation -> text with places for its arguments; statement: with {name}, {value};
    result: with {joint}, {value}; given: what an input is called, from its name and joint."""

    operators: Mapping[str, str]
    statement: str
    result: str
    given: Callable[[str, int], str]


class TracedModule:
    """The exported Python module of a model, with symbols for numbers."""

    def __init__(self, model: TorqueModel) -> None:
        text, self.lost = python_module(model, "traced")
        self.space: dict[str, Any] = {}
        exec(compile(text, f"<{model.name}, traced>", "exec"), self.space)
        self.space["sensitivities"] = self._sensitivities
        self.n = model.robot.n

    def torque(self, q: Traced, dq: Traced, ddq: Traced) -> Traced:
        """(1, n)."""
        s, zero = self.space, traced(np.zeros((1, self.n)))
        seen = s["Context"](
            s["ROBOT"], np.zeros(1), q, dq, ddq, rigid=0.0 * s["RIGID"], total=zero, apart=True
        )
        known = s["contextualised"](seen, s["TERMS"], s["RIGID"], s["LOADS"])
        return traced(s["sensed"](known, s["TERMS"]))

    def gravity(self, q: Traced) -> Traced:
        """(1, n): of the rigid bodies at rest."""
        s, rest = self.space, np.zeros((1, self.n))
        return traced(s["inverse_dynamics"](s["ROBOT"], s["RIGID"], q, rest, rest))

    def _sensitivities(self, robot: Any, rigid: Any, q: Any, dq: Any, ddq: Any) -> Any:
        torque = traced(self.space["inverse_dynamics"](robot, rigid, q, dq, ddq))[0]
        return tuple(
            traced([[trace.derivatives(list(torque), by)] for by in x[0]]) for x in (q, dq, ddq)
        )


def statements(wanted: Traced, language: Language) -> str:
    """Those that leave these numbers in the result."""
    names: dict[Node, str] = {}
    lines: list[str] = []
    for node in in_order(wanted[0]):
        if node.op == "input":
            names[node] = language.given(*node.args)
            continue
        names[node] = f"t{len(lines)}"
        given = (names[a] if isinstance(a, Node) else _number(a) for a in node.args)
        value = language.operators[node.op].format(*given)
        lines.append(language.statement.format(name=names[node], value=value))
    for j, value in enumerate(wanted[0]):
        text = names[value] if isinstance(value, Node) else _number(value)
        lines.append(language.result.format(joint=j, value=text))
    return "\n".join(lines)


def predicted(module: TracedModule) -> tuple[Traced, Traced]:
    """Torque of a moving sample and of the bodies at rest."""
    q, dq, ddq = (trace.inputs(name, module.n) for name in ("q", "dq", "ddq"))
    return module.torque(q, dq, ddq), module.gravity(q)


def traceable(model: TorqueModel) -> tuple[TorqueModel, list[str]]:
    """The model with what can be written down, and why the rest cannot."""
    bad: dict[str, list[Term]] = {}
    good: list[Term] = []
    if _fault(model) is None:
        return model, []
    for term in model.terms:
        reason = _fault(replace(model, terms=(term,)))
        if reason is None:
            good.append(term)
        else:
            bad.setdefault(reason, []).append(term)
    lost = [
        f"{label} not in the export: {reason}"
        for reason, terms in bad.items()
        for label in grouped(terms)
    ]
    return replace(model, terms=tuple(good)), lost


def _fault(model: TorqueModel) -> str | None:
    module = TracedModule(model)
    if module.lost:
        return module.lost[0].partition(": ")[2]
    try:
        predicted(module)
    except NotTraceable as error:
        return f"its formula takes {error}, and straight-line code has none"
    except (TypeError, ValueError, AttributeError, IndexError) as error:
        return f"its formula is no arithmetic of single samples ({error})"
    return None


def forgotten(model: TorqueModel) -> list[str]:
    """What effects remember that a function without a state takes otherwise, one line each."""
    at_work: dict[str, list[Term]] = {}
    for term in model.terms:
        if term.effect.remembers:
            at_work.setdefault(term.effect_id, []).append(term)
    return [
        f"{label} remembers {terms[0].effect.remembers}: here each sample stands for itself"
        for terms in at_work.values()
        for label in grouped(terms)
    ]


def _number(value: Any) -> str:
    text = repr(float(value))
    return f"({text})" if text.startswith("-") else text
