"""The simulated arm of the demo: what is hidden in it, and its recordings in the store."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from backends.virtual.datasets import KINDS, figures_of, foreign_runs, make_runs, random_effect
from backends.virtual.plant.catalogue import ALL, LISTED
from pa10d.dynamics import Robot
from pa10d.effects import all_effects
from pa10d.errors import UserError
from pa10d.profile import Profile, Simulation
from pa10d.recording import Recording
from pa10d.services.library import Library
from pa10d.store import Channels, Samples

REFERENCE = ("ref_a", "ref_b")
FIT, VALIDATE = KINDS[:2], KINDS[2:]
DRAWS = 400  # until an effect falls on the joint that was asked for
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

    @property
    def changed(self) -> bool:
        """Does it ask what changed (a refit would absorb it), not what is missing?"""
        kind = all_effects().get(self.name or "")
        return kind is not None and kind.question == "changed"

    def in_words(self) -> str:
        """With its parameters."""
        if not self.effects:
            return "nobody here knows" if self.foreign else "nothing"
        entry = self.effects[0]
        where = f" in joint {' and '.join(map(str, self.joints))}" if self.joints else ""
        given = {k: v for k, v in entry.items() if k not in ("effect", "joint", "joints")}
        values = ", ".join(f"{k} = {v}" for k, v in given.items())
        return f"{self.name}{where} ({values})"


def hide(asked: str | None, seed: int, profile: Profile) -> Hidden:
    """EFFECT, EFFECT:JOINT, ``none``, or (None) what the profile hides in its simulation, else any
    effect that the library knows, at random."""
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
    name, _, joint = (asked or str(rng.choice(list(LISTED)))).partition(":")
    if name not in ALL:
        raise UserError(f"--hide {asked}: no such effect, expected none or one of {', '.join(ALL)}")
    return Hidden((_placed(rng, name, joint, asked or name, profile),))


def _placed(
    rng: np.random.Generator, name: str, joint: str, asked: str, profile: Profile
) -> dict[str, Any]:
    figures = figures_of(profile)
    if not joint:
        return random_effect(rng, name, figures)
    if ALL[name].where == "robot":
        raise UserError(f"--hide {asked}: {name} is of the whole arm, expected no joint")
    if not joint.isdigit() or not 1 <= int(joint) <= figures.n:
        raise UserError(f"--hide {asked}: joint {joint!r}, expected a number from 1 to {figures.n}")
    seen: set[int] = set()
    for _ in range(DRAWS):
        drawn = random_effect(rng, name, figures)
        places = set(drawn.get("joints", [drawn.get("joint")]))
        if int(joint) in places:
            return drawn
        seen |= places
    fit = ", ".join(map(str, sorted(seen)))
    raise UserError(f"--hide {asked}: {name} cannot be seen there, expected one of joints {fit}")


def record(
    hidden: Hidden, seed: int, noise: str, profile: Profile, seconds: float
) -> dict[str, Recording]:
    """Measurements, and nothing but measurements, of the arm that the seed draws."""
    if hidden.foreign:
        return foreign_runs(seed, KINDS, profile, seconds=seconds)
    kinds = (*REFERENCE, *KINDS) if hidden.changed else KINDS
    return make_runs(seed, hidden.effects, noise, kinds, profile, seconds=seconds)[0]


def store_runs(
    library: Library, runs: Mapping[str, Recording], robot: Robot, profile: Profile, prefix: str
) -> None:
    """Put them where every command finds them, under prefix + kind."""
    for kind, run in runs.items():
        stamps = np.round(run.t * 1e9).astype(np.int64)
        with library.runs.building(
            prefix + kind, kind, Channels(joints=robot.joint_names), profile,
            source="simulated", tags=("demo",), replace=True,
        ) as writer:  # fmt: skip
            writer.append(Samples(stamps, run.q, run.tau))


def names(prefix: str, kinds: Sequence[str]) -> list[str]:
    """As stored."""
    return [prefix + kind for kind in kinds]
