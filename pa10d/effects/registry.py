"""All known effects by id: those of the library and those of entry-point group pa10d.effects."""

from __future__ import annotations

import importlib
import pkgutil
from functools import cache
from importlib.metadata import EntryPoint, entry_points

from pa10d.common.errors import UserError
from pa10d.common.words import did_you_mean
from pa10d.effects import library
from pa10d.effects.base import Effect
from pa10d.effects.check import fault
from pa10d.effects.dead_band import DeadBand
from pa10d.effects.smooth_map import SmoothMap, smooth_map

GROUP = "pa10d.effects"
_DEAD_BAND = DeadBand()


@cache
def all_effects() -> dict[str, Effect]:
    """id -> effect, the library first."""
    found: dict[str, Effect] = {}
    for module in pkgutil.iter_modules(library.__path__):
        loaded = importlib.import_module(f"{library.__name__}.{module.name}")
        for item in vars(loaded).values():
            if isinstance(item, type) and issubclass(item, Effect) and item is not Effect:
                found[item.id] = item()
    for point in entry_points(group=GROUP):
        effect = _from_elsewhere(point)
        if effect.id in found:
            raise UserError(f"{_name(point)}: effect {effect.id!r} exists already")
        found[effect.id] = effect
    return found


def effect(name: str, over: tuple[str, ...] = ()) -> Effect:
    """The effect with this id; over: quantities, for the map, which is in no list of effects: it
    is nothing that an arm could have. Nor is a reading's dead band."""
    if name == SmoothMap.id:
        return smooth_map(over or SmoothMap().over)
    if name == DeadBand.id:
        return _DEAD_BAND
    known = all_effects()
    if name not in known:
        expected = f"expected one of {', '.join(sorted(known))}"
        raise UserError(f"{name}: no such effect; {expected}{did_you_mean(name, known)}")
    return known[name]


def _from_elsewhere(point: EntryPoint) -> Effect:
    """An effect of another package; whatever is wrong with it is one line that names it."""
    try:
        made = point.load()()
    except Exception as error:  # code of others may fail in any way
        text = (str(error).strip() or type(error).__name__).splitlines()[0]
        raise UserError(f"{_name(point)}: cannot be loaded: {text}") from error
    if (wrong := fault(made)) is not None:
        raise UserError(f"{_name(point)}: {wrong}")
    assert isinstance(made, Effect)
    return made


def _name(point: EntryPoint) -> str:
    package = point.dist.name if point.dist is not None else "an installed package"
    return f"{package}: entry point {GROUP} {point.name} = {point.value}"
