"""How well a weight that was not hung yet would tell each joint's gain, and which to take.

The motion is that of a run there is, the noise what that run left unexplained. So one recording
without any weight is enough to choose among those at hand.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics import Robot
from pa10d.identify.scale.body import Body
from pa10d.identify.scale.gains import TOLD, TorqueGains
from pa10d.identify.scale.regression import regression
from pa10d.identify.scale.rows import EMPTY, rows_of

Array = NDArray[np.float64]

WANTED = 0.01  # standard error of a gain that is worth another weight
SPARE = 0.8  # of a joint's torque limit that motion with a weight may ask for
ASIDE = 0.1  # m to the side, by which a weight might be hung for a joint that it does not load
BETTER = 0.8  # of the present error that another weight must come down to, to be worth hanging
LARGEST = 5.0  # times the mass that was hung: beyond, ask again after trying


@dataclass(frozen=True)
class Prospect:
    """A weight at hand: std_error (n,) of the gains once it was hung too, NaN where not determined;
    without (n,): the same foretold without it; too_much: joint (0-based) whose torque limit it
    would pass, None where it may be hung; aside: joints (0-based) that it would tell only if it
    were hung ASIDE to the side, along ``axis``."""

    body: Body
    std_error: Array
    without: Array
    too_much: int | None
    aside: tuple[int, ...] = ()
    axis: str = ""

    @property
    def worst(self) -> float:
        """Largest error of those that are determined; endless where none is."""
        return float(np.nanmax(self.std_error)) if np.isfinite(self.std_error).any() else np.inf


def prospects(robot: Robot, found: TorqueGains, bodies: Sequence[Body]) -> list[Prospect]:
    """What each weight at hand would add; ``found`` may be of empty runs alone."""
    source = found.parts[0]
    out = []
    now = predicted_errors(robot, found, None)
    for body in bodies:
        error = predicted_errors(robot, found, body)
        part = source.with_weight(robot, body, EMPTY)
        drawn = np.abs(source.run.tau - source.asked + part.asked).max(axis=0)
        over = np.flatnonzero(drawn > SPARE * robot.effort)
        aside, axis = _aside(robot, found, body, error)
        out.append(Prospect(body, error, now, int(over[0]) if len(over) else None, aside, axis))
    return out


def best(found: TorqueGains, seen: Sequence[Prospect]) -> Prospect | None:
    """The weight to hang next: the lightest that brings every gain to WANTED, else the one that
    tells most joints and these best; None where none adds anything."""
    able = [one for one in seen if one.too_much is None and np.isfinite(one.worst)]
    if not able:
        return None
    enough = [one for one in able if one.worst <= WANTED]
    chosen = (
        min(enough, key=lambda one: one.body.mass) if enough
        else max(able, key=lambda one: (np.isfinite(one.std_error).sum(), -one.worst))
    )  # fmt: skip
    before = np.where(np.isfinite(chosen.without), chosen.without, TOLD)
    better = chosen.std_error < BETTER * before
    poor = ~(found.std_error <= WANTED)
    return chosen if (better & poor).any() else None


def predicted_errors(robot: Robot, found: TorqueGains, body: Body | None) -> Array:
    """(n,) standard errors of the gains with one more run of the same motion, carrying ``body``;
    None: with what there is. NaN where not determined. Recordings that disagree go on doing so."""
    parts, residuals = [*found.parts], [*found.residuals]
    if body is not None:
        load = 1 + max(part.load for part in parts)
        parts.append(parts[0].with_weight(robot, body, load))
        residuals.append(residuals[0])
    out = np.full(robot.n, np.nan)
    for j, joint in enumerate(found.joints):
        gain = joint.gain if joint.told else 1.0
        torques = [
            left[:, j] + gain * part.asked[:, j]
            for left, part in zip(residuals, parts, strict=True)
        ]
        seen, _ = regression(rows_of(parts, j, torques))
        if seen is None:
            continue
        error = float(np.hypot(seen.std_error, joint.spread / np.sqrt(seen.repeats)))
        if error < TOLD * abs(gain):
            out[j] = error
    return out


def heavier(robot: Robot, found: TorqueGains, masses: Sequence[float]) -> float | None:
    """kg of the weight, at the place of the one that was hung, that brings every gain that is
    ``limited_by_noise`` to WANTED, as far as a joint's torque allows; None where there is none or
    nothing would do."""
    noise = np.array([joint.of_noise for joint in found.joints])
    limited = limited_by_noise(found)
    heaviest = max(masses, default=0.0)
    if heaviest <= 0 or not limited.any():
        return None
    wanted = heaviest * min(float(noise[limited].max()) / WANTED, LARGEST)
    for part in found.parts:
        drawn, own = np.abs(part.run.tau).max(axis=0), np.abs(part.asked).max(axis=0)
        room = np.where(own > 0, (SPARE * robot.effort - drawn) / np.maximum(own, 1e-12), np.inf)
        wanted = min(wanted, heaviest * (1.0 + max(float(room.min()), 0.0)))
    return float(f"{wanted:.2g}") if wanted > 1.05 * heaviest else None


def limited_by_noise(found: TorqueGains) -> NDArray[np.bool_]:
    """(n,) whether noise keeps a gain from WANTED, and not recordings that disagree: what those
    leave open no weight takes off."""
    return np.array([joint.of_noise > WANTED and joint.spread <= WANTED for joint in found.joints])


def _aside(
    robot: Robot, found: TorqueGains, body: Body, error: Array
) -> tuple[tuple[int, ...], str]:
    """Joints that are told only where the weight hangs to the side, and along which axis."""
    missing = np.isnan(error) & np.isnan(found.std_error)
    chosen: tuple[tuple[int, ...], str] = ((), "")
    for axis, (x, y) in {"x": (ASIDE, 0.0), "y": (0.0, ASIDE)}.items():
        if missing.any():
            moved = predicted_errors(robot, found, body.beside(x, y))
            told = tuple(int(j) for j in np.flatnonzero(missing & np.isfinite(moved)))
            if len(told) > len(chosen[0]):
                chosen = told, axis
    return chosen
