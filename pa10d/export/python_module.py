"""A model as a Python module that needs NumPy and nothing else."""

from __future__ import annotations

import pprint
from typing import Any

from pa10d.common.jsonable import JsonObject
from pa10d.dynamics import typical_inertia
from pa10d.effects import Context
from pa10d.effects.together import contextualised, sensed
from pa10d.export import bodies
from pa10d.export.source import NotWritable, SourceText
from pa10d.export.words import grouped
from pa10d.model import Term, TorqueModel

HEAD = '''"""Joint torques of {name}: {about}.

Written by pa10d; stands on NumPy alone.

    torque(q, dq, ddq)          one sample, shape (n,), or many, (N, n), in any order
    torque(q, dq, ddq, time)    (N, n), time (N,) s at equal steps: the rows are one motion, so that
                                friction, warmth and springs remember
    torque_series(q, dq, ddq, dt)   the same, dt seconds apart

Joints: {joints}
Units: rad (m), rad/s, rad/s², N·m (N), torque at the joint side.
{remembers}{lost}"""

'''

INTERFACE = '''

class Term:
    """One effect at work on its joints, numbered from 0."""

    def __init__(self, effect, joints, coefficients, shape):
        self.effect, self.joints, self.shape = effect, joints, shape
        self.coefficients = np.array(coefficients)


JOINTS = {joints!r}
NOT_CARRIED = {not_carried!r}
ROBOT = Robot(
    **{{key: np.array(value) for key, value in {robot}.items()}}
)
RIGID = np.array({rigid})
LOADS = {loads}
REMEMBERS = {memory!r}
TERMS = [
{terms}
]


def torque(q, dq, ddq, time=None, temperature=None):
    """Torque of one sample (n,), of many independent ones (N, n), or with time of one motion.

    temperature: (N, n) °C, where it is known
    """
    moved = [np.atleast_2d(np.asarray(x, dtype=float)) for x in (q, dq, ddq)]
    samples = len(moved[0])
    if any(x.shape != (samples, len(JOINTS)) for x in moved):
        raise ValueError(f"q, dq, ddq: expected ({{samples}}, {{len(JOINTS)}}) each")
    t = np.zeros(samples) if time is None else np.asarray(time, dtype=float)
    warm = None if temperature is None else np.atleast_2d(np.asarray(temperature, dtype=float))
    seen = Context(
        ROBOT, t - t[0], *moved, rigid=0.0 * RIGID, total=0.0 * moved[0], temperature=warm,
        apart=time is None,
    )
    out = sensed(contextualised(seen, TERMS, RIGID, LOADS), TERMS)
    return out[0] if np.ndim(q) == 1 else out


def torque_series(q, dq, ddq, dt=None, temperature=None):
    """Torque (N, n) along one motion, its rows dt seconds apart."""
    if dt is None and REMEMBERS:
        raise ValueError(f"dt: expected the seconds between rows for {{', '.join(REMEMBERS)}}")
    return torque(q, dq, ddq, (1.0 if dt is None else dt) * np.arange(len(q)), temperature)
'''


def python_module(model: TorqueModel, about: str) -> tuple[str, list[str]]:
    """The module's text, and one line per effect that it cannot carry."""
    source = SourceText()
    carried: list[tuple[Term, str]] = []
    missing: dict[str, list[Term]] = {}
    for needed in (bodies.Robot, Context, contextualised, sensed):
        source.add(needed, needed.__name__)
    for term in model.terms:
        try:
            carried.append((term, _class_of(source, term)))
        except NotWritable as reason:
            missing.setdefault(str(reason), []).append(term)
    lost = [
        f"{label} not in the export: {reason}"
        for reason, terms in missing.items()
        for label in grouped(terms)
    ]
    head = HEAD.format(
        name=_in_docstring(model.name),
        about=_in_docstring(about),
        joints=_in_docstring(", ".join(model.robot.joint_names)),
        remembers=_remembered([term for term, _ in carried]),
        lost="".join(f"\nNOT CARRIED: {line}" for line in lost) + ("\n" if lost else ""),
    )
    tail = INTERFACE.format(
        joints=list(model.robot.joint_names),
        not_carried=[term.label for terms in missing.values() for term in terms],
        robot=_pretty(_robot(model)),
        rigid=_pretty(model.rigid.tolist()),
        loads="None" if model.loads is None else f"np.array({_pretty(model.load_bodies.tolist())})",
        memory=sorted({t.effect_id for t, _ in carried if t.effect.remembers}),
        terms="\n".join(_term(term, name) for term, name in carried),
    )
    return head + source.text() + tail, lost


def _in_docstring(text: str) -> str:
    """What a person named, where quotes would end the text and a backslash change it."""
    return text.replace("\\", "\\\\").replace('"""', "'''")


def writable(model: TorqueModel) -> tuple[Term, ...]:
    """The effects that a module carries."""
    source, found = SourceText(), []
    for term in model.terms:
        try:
            _class_of(source, term)
        except NotWritable:
            continue
        found.append(term)
    return tuple(found)


def _class_of(source: SourceText, term: Term) -> str:
    if term.over:
        raise NotWritable("a map of what nobody understands stays where its range is watched")
    return source.add_effect(term.effect)


def _robot(model: TorqueModel) -> JsonObject:
    robot = model.robot
    fields = ("parent", "order", "rotation", "translation", "axis", "prismatic", "gravity")
    typical = typical_inertia(robot, model.load_bodies)
    return {key: getattr(robot, key).tolist() for key in fields} | {"typical": typical.tolist()}


def _term(term: Term, name: str) -> str:
    shape = {key: float(value) for key, value in term.shape.items()}
    coefficients = [float(c) for c in term.coefficients]
    return f"    Term({name}(), {list(term.joints)!r}, {coefficients!r}, {shape!r}),"


def _remembered(terms: list[Term]) -> str:
    found = {t.effect_id: t.effect.remembers for t in terms if t.effect.remembers}
    return "".join(f"\n{name} remembers {what}." for name, what in found.items()) + "\n" * bool(
        found
    )


def _pretty(data: Any) -> str:
    return pprint.pformat(data, width=100, compact=True, sort_dicts=False)
