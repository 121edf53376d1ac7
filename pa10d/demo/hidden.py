"""What the simulated arm of the demo hides, and how it came by it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from backends.virtual.datasets import Figures, NoPlace, figures_of, random_effect
from backends.virtual.plant.catalogue import LISTED
from backends.virtual.plant.laws import catalogue
from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject
from pa10d.common.words import from_one
from pa10d.effects import all_effects
from pa10d.profile import Profile, Simulation

SPREAD = 0.2  # by which masses differ from the URDF's; friction and rotors by more
DRAWS = 400  # until an effect falls on the joint that was asked for
OF_A_BODY = {"cx": " m", "cy": " m", "cz": " m", "inertia": " kg·m²"}
OF_THE_PLANT = {
    "sin": " N·m", "cos": " N·m", "K": " N·m/rad", "D": " N·m·s/rad", "Ia": " kg·m²", "q0": " rad",
    "displacements": " rad", "centre": " rad", "width": " rad", "cubic": " (N·m)⁻²",
}  # fmt: skip
"""Of parameters that the simulated laws have under names of their own."""
OWN_PLANT = str(Simulation().plant)


@dataclass(frozen=True)
class Hidden:
    """What the simulator knows and the diagnosis is not told.

    effects: entries as the simulator takes them; foreign: nobody here knows
    """

    effects: tuple[Mapping[str, Any], ...] = ()
    foreign: bool = False

    @property
    def name(self) -> str | None:
        """The effect, or None."""
        return str(self.effects[0]["effect"]) if self.effects else None

    @property
    def joints(self) -> tuple[int, ...]:
        """Where, numbered from 1; empty for the whole arm."""
        if not self.effects:
            return ()
        entry = self.effects[0]
        return tuple(entry.get("joints", [entry["joint"]] if "joint" in entry else []))

    def present(self, later: bool) -> list[JsonObject]:
        """What the arm has on the first day, or later: a payload and the like come in between."""
        return [dict(entry) for entry in self.effects if later or not _a_change(entry)]

    @property
    def changes(self) -> bool:
        """Whether it is there on the later day alone."""
        return self.present(later=True) != self.present(later=False)

    def in_words(self) -> str:
        """With its parameters, in their units."""
        if not self.effects:
            return "nobody here knows" if self.foreign else "nothing"
        entry = self.effects[0]
        where = f" in joint {' and '.join(map(str, self.joints))}" if self.joints else ""
        given = {k: v for k, v in entry.items() if k not in ("effect", "joint", "joints")}
        units = _units(str(self.name))
        values = ", ".join(f"{k} = {v}{units.get(k, '')}" for k, v in given.items())
        return f"{self.name}{where} ({values})"


def _units(effect: str) -> dict[str, str]:
    """Parameter -> its unit, to be put behind a value; nothing for a bare number."""
    if (kind := all_effects().get(effect)) is None:
        return OF_A_BODY
    found = {c.name: c.unit for c in kind.coefficients} | {s.name: s.unit for s in kind.shapes}
    return (
        OF_A_BODY
        | OF_THE_PLANT
        | {name: "" if unit == "1" else f" {unit}" for name, unit in found.items()}
    )


def _a_change(entry: Mapping[str, Any]) -> bool:
    """Is it something that happens to an arm, not a trait of it?"""
    kind = all_effects().get(str(entry["effect"]))
    return kind is not None and kind.question == "changed"


def hide(asked: str | None, seed: int, profile: Profile) -> Hidden:
    """EFFECT, EFFECT:JOINT, ``none``, or (None) what the profile hides in its simulation, else any
    effect that the library knows and the experiments can show, at random."""
    if profile.simulation is not None and profile.simulation.plant != OWN_PLANT:
        if asked is not None:
            raise UserError(
                f"--hide {asked}: {profile.path} brings a plant of its own "
                f"({profile.simulation.plant}), which hides what it likes"
            )
        return Hidden(foreign=True)
    if asked == "none":
        return Hidden()
    own = profile.simulation.options.get("effects") if profile.simulation is not None else None
    if own and asked is None:
        return Hidden(tuple(own))
    rng = np.random.default_rng([seed, 4])
    shown = [name for name in LISTED if not all_effects()[name].escapes_demo]
    if asked is None:
        return Hidden((_any_of(rng, shown, figures_of(profile)),))
    name, _, joint = asked.partition(":")
    known = catalogue()
    if name not in known:
        why = (
            "no such effect"
            if name not in all_effects()
            else ("its package has no law for the simulated arm (entry point pa10d.hidden)")
        )
        raise UserError(f"--hide {asked}: {why}, expected none or one of {', '.join(known)}")
    try:
        return Hidden((_placed(rng, name, joint, asked, figures_of(profile)),))
    except NoPlace as error:
        raise UserError(f"--hide {asked}: {error}, expected another effect") from error


def with_secret(profile: Profile, hidden: Hidden, seed: int, later: bool = True) -> Profile:
    """The profile whose simulator has the secret, and bodies that the seed draws; later: what
    happens to an arm has happened."""
    if profile.simulation is None:
        raise UserError(f"{profile.path}: no 'simulation'; only a simulated arm hides something")
    if hidden.foreign:
        return profile
    given = {
        "seed": 2 * seed + later,  # of the noise: no two days are alike
        "options": {
            "dynamics": {"spread": SPREAD, "seed": seed},
            **profile.simulation.options,
            "effects": hidden.present(later),
        },
    }
    return profile.model_copy(update={"simulation": profile.simulation.model_copy(update=given)})


def _any_of(rng: np.random.Generator, names: list[str], figures: Figures) -> JsonObject:
    """One that this arm can show: springs show themselves where links are heavy beside rotors."""
    left = list(names)
    while True:
        name = str(rng.choice(left))
        try:
            return random_effect(rng, name, figures)
        except NoPlace:
            left.remove(name)  # friction finds a joint on every arm


def _placed(
    rng: np.random.Generator, name: str, joint: str, asked: str, figures: Figures
) -> JsonObject:
    if not joint:
        return random_effect(rng, name, figures)
    if catalogue()[name].where == "robot":
        raise UserError(f"--hide {asked}: {name} is of the whole arm, expected no joint")
    if not joint.isdecimal() or not 1 <= int(joint) <= figures.n:
        raise UserError(f"--hide {asked}: joint {joint!r}, expected {from_one(figures.n)}")
    seen: set[int] = set()
    for _ in range(DRAWS):
        drawn = random_effect(rng, name, figures)
        places = set(drawn.get("joints", [drawn.get("joint")]))
        if int(joint) in places:
            return drawn
        seen |= places
    fit = ", ".join(map(str, sorted(seen)))
    raise UserError(f"--hide {asked}: {name} cannot be seen there, expected one of joints {fit}")
