"""What a person is asked to confirm: a change that lets the arm do more than somebody stated."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pa10d.control.servo_design import SENSITIVITY, SLUGGISH
from pa10d.dynamics.environment import Box
from pa10d.services.tuning.arm import GAINS, Tuned
from pa10d.services.tuning.keys import KEYS, Key

ROUNDED = 1e-6  # of a value: as far as one is told, and URDF and profile write it alike
TURNED, TOUCHING = 1e-9, 1e-9  # of a rotation's entries; m
UNBOUNDED = "neither the URDF nor a drive says how much it may be"


def loosened(before: Tuned, after: Tuned) -> list[str]:
    """A sentence each, empty where nothing is to be confirmed."""
    raised = [s for key in KEYS.values() if key.per_joint for s in _raised(key, before, after)]
    swings = [one.sentence for one in swinging(before, after)]
    return [*raised, *swings, *_surroundings(before, after)]


def _raised(key: Key, before: Tuned, after: Tuned) -> Iterator[str]:
    if key.group in ("limits", "safety"):
        yield from wider(key, before, after)


def wider(key: Key, before: Tuned, after: Tuned) -> Iterator[str]:
    """A sentence for each joint whose limit lets it do more than is known to be right."""
    old, new = (np.asarray(one.in_force(key.name), dtype=float) for one in (before, after))
    bounds = after.bounds(key.name)
    if key.name == "limits.position":
        signs = {"lower": (-1.0, 0), "upper": (1.0, 1)}
        for word, (sign, k) in signs.items():
            most = [(words, bound[:, k]) for words, bound in bounds]
            yield from _above(key, after, old[:, k], new[:, k], most, f"{word} ", sign)
    else:
        yield from _above(key, after, old, new, bounds)


def _above(
    key: Key,
    after: Tuned,
    old: np.ndarray,
    new: np.ndarray,
    bounds: list[tuple[str, np.ndarray]],
    which: str = "",
    sign: float = 1.0,
) -> Iterator[str]:
    """sign: -1 where a lower value lets the arm do more."""
    units = key.units(after.robot)
    for j in np.flatnonzero(sign * new > sign * old + ROUNDED * np.abs(old)):
        bounded = np.isfinite(new[j])
        value = f"{which}{key.title} of {new[j]:.6g} {units[j]}"
        what = f"joint {j + 1}: {value if bounded else f'no {which}{key.title}'}"
        known = [(words, bound[j]) for words, bound in bounds if np.isfinite(bound[j])]
        over = [
            f"{words} {most:.6g}"
            for words, most in known
            if sign * new[j] > sign * most + ROUNDED * abs(most)
        ]
        if over:
            yield f"{what} goes beyond {' and '.join(over)}"
        elif not known:
            yield f"{what} instead of {old[j]:.6g}: {UNBOUNDED}"


@dataclass(frozen=True)
class Swings:
    """A joint, from 0, that swings with its gains; peak: of its loop's sensitivity, inf: always."""

    joint: int
    peak: float

    @property
    def sentence(self) -> str:
        """For a person."""
        how = (
            f"the sensitivity of its loop peaks at {self.peak:.2g} ({SENSITIVITY:g} is the rule, "
            f"more than {SLUGGISH:g} swings for long)"
            if np.isfinite(self.peak)
            else "its loop is not stable"
        )
        return f"joint {self.joint + 1}: with these gains {how} in the worst pose"


def swinging(before: Tuned, after: Tuned) -> Iterator[Swings]:
    """Joints whose gains are others than before, and too much or too little for them."""
    changed = others_than(before, after)
    if not changed.any():
        return
    for j in np.flatnonzero(changed):
        peak = float(after.sensitivity[j])
        if peak > SLUGGISH and peak >= before.sensitivity[j]:
            yield Swings(int(j), peak)


def others_than(before: Tuned, after: Tuned) -> np.ndarray:
    """(n,) whether the gains of a joint are others than before."""
    changed = np.zeros(after.robot.n, dtype=bool)
    for key in GAINS:
        changed |= ~np.isclose(getattr(before.gains, key), getattr(after.gains, key), rtol=1e-9)
    return changed


def _surroundings(before: Tuned, after: Tuned) -> Iterator[str]:
    old, new = (one.profile.environment for one in (before, after))
    low, high = (-np.inf if one.floor == "none" else float(one.floor) for one in (new, old))
    if low < high:
        there = "no floor" if low == -np.inf else f"the floor at {low:g} m"
        yield f"{there} instead of {high:g} m: motions may go lower"
    names = {box.name for box in new.boxes}
    for k, (box, solid) in enumerate(zip(old.boxes, before.robot.environment.boxes, strict=True)):
        if not any(_covers(other, solid) for other in after.robot.environment.boxes):
            name = box.name or f"box {k + 1}"
            stays = k < len(new.boxes) if box.name is None else box.name in names
            yield f"{name} {'changed' if stays else 'is gone'}: motions may go where it was"


def _covers(other: Box, box: Box) -> bool:
    """Whether it stands wherever the box stood, whatever it is called."""
    along = box.rotation.T @ (other.position - box.position)
    alike = np.allclose(other.rotation, box.rotation, atol=TURNED)
    return bool(alike and (np.abs(along) <= (other.size - box.size) / 2 + TOUCHING).all())
