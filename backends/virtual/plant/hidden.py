"""The ``effects`` option of a plant, checked against the catalogue, one entry per effect."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from backends.virtual.plant.catalogue import ABOVE_ZERO, ALL, REQUIRED, Spec, Where
from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject


@dataclass(frozen=True)
class Hidden:
    """One effect that this arm has; joints are 0-based indices, empty for the whole robot."""

    effect: str
    joints: tuple[int, ...]
    values: Mapping[str, Any]

    @property
    def joint(self) -> int:
        """The (first) joint concerned, 0-based."""
        return self.joints[0]

    def __getitem__(self, name: str) -> float:
        return float(self.values[name])


def hidden_effects(options: Any, n: int, known: Mapping[str, Spec] = ALL) -> list[Hidden]:
    """Check the option for an arm of n joints; known: what it can hide."""
    if not isinstance(options, list | tuple) or not all(isinstance(e, Mapping) for e in options):
        raise UserError("simulation.options.effects: expected a list of {effect: .., ...}")
    return [_parse(number, dict(one), n, known) for number, one in enumerate(options, 1)]


def _parse(number: int, asked: JsonObject, n: int, known: Mapping[str, Spec]) -> Hidden:
    where = f"simulation.options.effects, entry {number}"
    name = asked.pop("effect", None)
    if not isinstance(name, str) or name not in known:
        raise UserError(f"{where}: effect: found {name!r}, expected one of {', '.join(known)}")
    spec = known[name]
    joints = _joints(where, name, spec.where, asked, n)
    if unknown := set(asked) - set(spec.parameters):
        expected = ", ".join(spec.parameters)
        raise UserError(f"{where}: {name} has no {sorted(unknown)[0]!r}; expected {expected}")
    values = {**spec.parameters, **asked}
    for key, value in values.items():
        if value is REQUIRED:
            raise UserError(f"{where}: {name} needs a value for {key}")
        if type(spec.parameters[key]) is not str and not _is_number(value, spec.parameters[key]):
            raise UserError(f"{where}: {name}.{key}: found {value!r}, expected a number")
        size = value if isinstance(value, int | float) else 1.0
        if name in ALL and key in ABOVE_ZERO and size <= 0:
            raise UserError(f"{where}: {name}.{key}: found {value!r}, expected more than 0")
    return Hidden(name, joints, values)


def _is_number(value: Any, default: Any) -> bool:
    if isinstance(default, list):
        return isinstance(value, list | tuple) and all(isinstance(v, int | float) for v in value)
    return isinstance(value, int | float) and not isinstance(value, bool)


def _joints(where: str, name: str, scope: Where, asked: JsonObject, n: int) -> tuple[int, ...]:
    wanted = {"joint": 1, "pair": 2, "robot": 0}[scope]
    given = asked.pop("joints", None)
    single = asked.pop("joint", None)
    joints = [single] if single is not None else list(given or [])
    good = all(isinstance(j, int) and 1 <= j <= n for j in joints)
    if len(joints) != wanted or not good or len(set(joints)) != len(joints):
        form = {"joint": "joint: J", "pair": "joints: [I, J]", "robot": "no joint"}[scope]
        raise UserError(f"{where}: {name}: joints {joints}, expected {form}, counted 1..{n}")
    return tuple(j - 1 for j in joints)
