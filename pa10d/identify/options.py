"""How a textbook model is fitted: one value for command line, API, page and library."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pa10d.common.jsonable import parsed
from pa10d.identify.given import read_given


@dataclass(frozen=True)
class FitOptions:
    """cutoff         Hz of the zero-phase low-pass on both sides of the equation; default: from the
                   data
    with_effects   ids of further effects, on every joint (stribeck) or one of them (stribeck:2)
    robust         let samples far off the model count less (knocks, collisions, glitches)
    faster_than    rad/s per joint; only samples in which the joint is faster are fitted, because
                   friction is linear there (set A of Vuong & Ang 2009)
    prior          %, how near the bodies are to the URDF's, of what is usual for a link (one
                   standard deviation); default: nothing is known of them
    given          name, value and standard error (SI) of single parameters that somebody knows
    """

    cutoff: float | None = None
    with_effects: tuple[str, ...] = ()
    robust: bool = False
    faster_than: tuple[float, ...] | None = None
    prior: float | None = None
    given: tuple[tuple[str, float, float], ...] = ()

    @classmethod
    def read(cls, document: Mapping[str, Any]) -> FitOptions:
        """From a request, in which ``given`` is in words such as ``Fc3=12±2``; further fields are
        passed over."""
        words = document.get("given") or ()
        return parsed(cls, {**document, "given": [read_given(word) for word in words]})
