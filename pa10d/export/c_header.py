"""A model as one C header: straight-line code, no allocation, no dependency but math.h.

What it computes is written down while the exported Python module predicts one sample, so that both
are the same formulae.
"""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np

from pa10d.export import trace
from pa10d.export.python_module import python_module
from pa10d.export.trace import Node, NotTraceable, Traced, in_order, traced
from pa10d.export.words import grouped
from pa10d.model import Term, TorqueModel

OPERATORS = {
    "add": "{} + {}", "subtract": "{} - {}", "multiply": "{} * {}", "divide": "{} / {}",
    "negative": "-{}", "absolute": "fabs({})", "power": "pow({}, {})", "sin": "sin({})",
    "cos": "cos({})", "tanh": "tanh({})", "exp": "exp({})", "sqrt": "sqrt({})", "log": "log({})",
    "arcsin": "asin({})", "sign": "(double)(({0} > 0.0) - ({0} < 0.0))",
    "maximum": "fmax({}, {})", "minimum": "fmin({}, {})",
    "greater": "(double)({} > {})", "greater_equal": "(double)({} >= {})",
    "less": "(double)({} < {})", "less_equal": "(double)({} <= {})",
    "where": "({} != 0.0 ? {} : {})",
}  # fmt: skip

HEADER = """\
/* Joint torques of {name}: {about}.
 *
 * Written by pa10d. One header, no allocation, no state: call it from any loop.
 *
 *     {id}_torque(q, dq, ddq, tau)     feed-forward torque of a wanted motion
 *     {id}_gravity(q, tau)             what holds the arm where it stands, friction not counted
 *
 * Joints, in this order: {joints}
 * Units: rad (m), rad/s, rad/s^2, N m (N) at the joint side.
{notes} */
#ifndef {guard}
#define {guard}

#include <math.h>

#define {guard}_JOINTS {n}

static inline void {id}_torque(const double q[{n}], const double dq[{n}], const double ddq[{n}],
                               double tau[{n}])
{{
{torque}
}}

static inline void {id}_gravity(const double q[{n}], double tau[{n}])
{{
{gravity}
}}

#endif
"""


def c_header(model: TorqueModel, about: str) -> tuple[str, list[str]]:
    """The header's text, and one line per effect that it cannot carry."""
    kept, lost = traceable(model)
    torque, gravity = _predicted(TracedModule(kept))
    name = re.sub(r"\W", "_", model.name)
    name = name if name[0].isalpha() else f"model_{name}"
    notes = [
        f"{label} remembers {terms[0].effect.remembers}: here each call stands for itself"
        for terms in _alike([t for t in kept.terms if t.effect.remembers])
        for label in grouped(terms)
    ]
    told = [*notes, *(f"NOT CARRIED: {line}" for line in lost)]
    text = HEADER.format(
        name=_comment(model.name),
        about=_comment(about),
        id=name,
        guard=f"PA10D_{name.upper()}_H",
        joints=_comment(", ".join(model.robot.joint_names)),
        n=model.robot.n,
        notes="".join(f" * {_comment(line)}\n" for line in told),
        torque=code(torque),
        gravity=code(gravity),
    )
    return text, lost


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


def code(wanted: Traced) -> str:
    """Statements that leave these numbers in tau."""
    names: dict[Node, str] = {}
    lines: list[str] = []
    for node in in_order(wanted[0]):
        if node.op == "input":
            names[node] = node.args[0]
            continue
        names[node] = f"t{len(lines)}"
        given = (names[a] if isinstance(a, Node) else _number(a) for a in node.args)
        lines.append(f"    const double {names[node]} = {OPERATORS[node.op].format(*given)};")
    for j, value in enumerate(wanted[0]):
        text = names[value] if isinstance(value, Node) else _number(value)
        lines.append(f"    tau[{j}] = {text};")
    return "\n".join(lines)


def _predicted(module: TracedModule) -> tuple[Traced, Traced]:
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
        _predicted(module)
    except NotTraceable as error:
        return f"its formula takes {error}, and straight-line code has none"
    except (TypeError, ValueError, AttributeError, IndexError) as error:
        return f"its formula is no arithmetic of single samples ({error})"
    return None


def _alike(terms: list[Term]) -> list[list[Term]]:
    found: dict[str, list[Term]] = {}
    for term in terms:
        found.setdefault(term.effect_id, []).append(term)
    return list(found.values())


def _number(value: Any) -> str:
    text = repr(float(value))
    return f"({text})" if text.startswith("-") else text


def _comment(text: str) -> str:
    return text.replace("*/", "* /")
