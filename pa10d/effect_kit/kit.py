"""All checks of one effect, one after the other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pa10d.dynamics import Robot, robot_from_profile
from pa10d.effect_kit.carried import carried
from pa10d.effect_kit.conduct import (
    as_said,
    bounded_starts,
    finite_columns,
    looks_back,
    says_what_it_uses,
)
from pa10d.effect_kit.found import found_again
from pa10d.effect_kit.numbers import alone, smooth, units
from pa10d.effect_kit.roles import played
from pa10d.effects import Effect
from pa10d.profile import load_profile

Check = Callable[[Effect, Robot, np.random.Generator, int], str | None]
"""What is wrong, as a sentence, or None; of so many random cases."""

CHECKS: dict[str, Check] = {
    "whole": as_said,
    "columns": finite_columns,
    "causality": looks_back,
    "starts": bounded_starts,
    "model": says_what_it_uses,
    "units": units,
    "derivative": smooth,
    "prediction": alone,
    "roles": played,
    "export": carried,
}
DRAWS = 20


@dataclass(frozen=True)
class KitVerdict:
    """One check: passed, and what was seen where it was not."""

    check: str
    passed: bool
    says: str = ""


def check(kind: Effect, draws: int = DRAWS, hide: bool = False, seed: int = 0) -> list[KitVerdict]:
    """Every check in turn, over ``draws`` random shapes, coefficients and motions each.

    hide: also hide it in a simulated arm and look for it again, which takes a minute
    """
    robot = robot_from_profile(load_profile("pa10-sim"))
    checks = CHECKS | ({"found again": found_again} if hide else {})
    out = []
    for name, one in checks.items():
        try:
            with np.errstate(all="ignore"):  # what is not finite is told as such
                wrong = one(kind, robot, np.random.default_rng([seed, len(name)]), draws)
        except Exception as error:  # code of others may fail in any way
            wrong = f"{type(error).__name__}: {error}"
        out.append(KitVerdict(name, wrong is None, wrong or ""))
        if name == "whole" and wrong is not None:
            break
    return out
