"""Dry friction and bristles of one joint: together they are known, apart they need not be.

How sharply dry friction turns round is all that tells it from bristles, over which friction builds
up. Where the data show nothing of that, either may carry any part: least squares at an assumed
sharpness know the parts as well as the whole, and are wrong by many of their standard errors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pa10d.effects import Value
from pa10d.model.term import Term


def beside_bristles(terms: Sequence[Term], term: Term, found: dict[str, Value]) -> dict[str, Value]:
    """The parameters ``found`` of a term with the doubt that what dry friction and bristles share
    adds, where nothing tells them apart."""
    dry = next((t for t in terms if t.joints == term.joints and _assumed_sharp(t)), None)
    on = next((t for t in terms if t.joints == term.joints and t.effect.builds_up_over), None)
    if dry is None or on is None or (term is not dry and term is not on):
        return found
    # the smaller one may be no more than how the other turns round
    moved, own = min(abs(float(t.coefficients[0])) for t in (dry, on)), float(term.coefficients[0])
    share = abs(moved / own) if own else 0.0
    kept = {s.name for s in term.effect.shapes}  # the way and the sharpness are no levels
    return {
        name: value
        if name in kept
        else replace(
            value,
            std_error=float(np.hypot(value.std_error, share * value.value)),
            random=float(np.hypot(value.std_error_random, share * value.value)),
        )
        for name, value in found.items()
    }


def _assumed_sharp(term: Term) -> bool:
    """Dry friction of which the data do not show how sharply it turns round."""
    name = term.effect.smoothed_over
    if not name:
        return False
    shape = next(s for s in term.effect.shapes if s.name == name)
    return not shape.determined(term.shape[name], term.shape_errors.get(name, 0.0))
