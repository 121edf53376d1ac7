"""Turn a list of hidden effects into arrays over joints."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from backends.virtual.plant.hidden import Hidden
from backends.virtual.plant.records import Array
from pa10d.common.errors import UserError


def of(effects: Iterable[Hidden], name: str) -> list[Hidden]:
    """The effects with this id."""
    return [e for e in effects if e.effect == name]


def per_joint(effects: Iterable[Hidden], name: str, key: str, n: int, absent: float = 0.0) -> Array:
    """(n,) values of one parameter, ``absent`` on joints that do not have the effect."""
    out = np.full(n, absent)
    seen: set[int] = set()
    for effect in of(effects, name):
        if effect.joint in seen:
            raise UserError(f"simulation.options.effects: {name} twice on joint {effect.joint + 1}")
        seen.add(effect.joint)
        out[effect.joint] = effect[key]
    return out
