"""Where an error is larger than elsewhere, and what acts there."""

from __future__ import annotations

from pa10d.compare.places import Place
from pa10d.compare.regions import Region


def told_in_passing(place: Place) -> str:
    """Within a sentence."""
    said = told(place)
    return f"{said[0].lower()}{said[1:]}"


def told(place: Place) -> str:
    """With what acts where a load changes its sign."""
    if not changes_sides(place):
        return place.sentence
    return (
        f"{place.sentence}: play, or a gear or a belt that gives, acts where a load changes sides"
    )


def changes_sides(place: Place) -> bool:
    """Does a load change its sign there?"""
    what = place.what
    if not isinstance(what, Region) or what.quantity is None:
        return False
    return what.quantity.kind == "load" and what.low < 0.0 < what.high
