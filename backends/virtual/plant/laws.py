"""What other packages hide in the simulated arm: laws of their own, by the entry points
``pa10d.hidden``.

A law is written from physics, shares no code with the effect that a diagnosis knows by the same
name, and is asked once a sample, in time order, for the torque with which it resists:

    class Hose:
        where = "joint"                      # or "pair", "robot"
        parameters = {"k": None, "T": 2.0}   # None: an entry has to state it

        @staticmethod
        def draw(rng, arm):                  # an entry of a size that shows; see datasets.Figures
            return {"joint": 1, "k": 30.0}

        def __init__(self, k, T): ...

        def torque(self, dt, q, dq):         # s; rad and rad/s of its own joints → N·m on each
            ...

It is held over the sample, so it must not be stiff against that.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Protocol

import numpy as np

from backends.virtual.plant.catalogue import ALL, Spec
from backends.virtual.plant.hidden import Hidden
from backends.virtual.plant.records import Array
from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject

GROUP = "pa10d.hidden"
NEEDED: Mapping[str, Callable[[Any], bool]] = {
    "where": lambda found: found in ("joint", "pair", "robot"),
    "parameters": lambda found: (
        isinstance(found, Mapping) and all(isinstance(k, str) for k in found)
    ),
    "draw": callable,
    "torque": callable,
}


class Law(Protocol):
    """Of one arm, at its joints, from its beginning."""

    def torque(self, dt: float, q: Array, dq: Array) -> Any:
        """(k,) N·m against the motion, of its k joints (or one number for one joint)."""


class LawClass(Protocol):
    """What an entry point names."""

    where: Any
    parameters: Mapping[str, Any]

    def __call__(self, **values: Any) -> Law: ...

    def draw(self, rng: np.random.Generator, arm: Any) -> JsonObject:
        """An entry of the ``effects`` option without its ``effect``."""


@cache
def laws() -> dict[str, LawClass]:
    """id -> law, of all packages that are installed."""
    found: dict[str, LawClass] = {}
    for point in entry_points(group=GROUP):
        if point.name in ALL or point.name in found:
            raise UserError(f"{_name(point)}: the simulated arm knows {point.name!r} already")
        found[point.name] = _loaded(point)
    return found


def catalogue() -> dict[str, Spec]:
    """Everything that the simulated arm can hide."""
    return ALL | {name: Spec(law.where, law.parameters) for name, law in laws().items()}


class AtWork:
    """The laws of one arm, from its beginning."""

    def __init__(self, effects: list[Hidden], n: int) -> None:
        self._n = n
        known = laws() if any(one.effect not in ALL for one in effects) else {}
        self._each = [
            (one.effect, np.array(one.joints or range(n)), known[one.effect](**one.values))
            for one in effects
            if one.effect in known
        ]

    def __bool__(self) -> bool:
        return bool(self._each)

    def torque(self, dt: float, q: Array, dq: Array) -> Array:
        """(n,) N·m against the motion, over the next dt seconds."""
        out = np.zeros(self._n)
        for name, joints, law in self._each:
            try:
                out[joints] += np.asarray(law.torque(dt, q[joints], dq[joints]), dtype=float)
            except Exception as error:  # code of others may fail in any way
                text = (str(error).strip() or type(error).__name__).splitlines()[0]
                raise UserError(f"hidden {name}: its torque: {text}") from error
        if not np.all(np.isfinite(out)):
            raise UserError("hidden " + ", ".join(name for name, *_ in self._each) + ": "
                            f"torque {out.tolist()}, expected finite N·m")  # fmt: skip
        return out


def _loaded(point: EntryPoint) -> LawClass:
    try:
        law: Any = point.load()
    except Exception as error:  # code of others may fail in any way
        text = (str(error).strip() or type(error).__name__).splitlines()[0]
        raise UserError(f"{_name(point)}: cannot be loaded: {text}") from error
    for attribute, good in NEEDED.items():
        if not good(getattr(law, attribute, None)):
            raise UserError(
                f"{_name(point)}: {attribute} is {getattr(law, attribute, None)!r}, expected "
                "where (joint, pair or robot), parameters (name -> default or None), draw, torque"
            )
    made: LawClass = law
    return made


def _name(point: EntryPoint) -> str:
    package = point.dist.name if point.dist is not None else point.module
    return f"package {package}, entry point {point.value} of {GROUP}"
