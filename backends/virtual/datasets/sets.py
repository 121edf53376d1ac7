"""Recordings of simulated arms with known answers, of the kind a diagnosis is tested on."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from backends.virtual.datasets.robot import open_robot, reach_of
from backends.virtual.datasets.runs import KINDS, motion_of, run_motion
from backends.virtual.plant.plant import Plant, build
from pa10d.common.jsonable import JsonObject
from pa10d.measurement.recording import Recording
from pa10d.profile import Profile


def make_runs(
    seed: int,
    effects: Sequence[Mapping[str, Any]] = (),
    noise: str | Mapping[str, Any] = "white",
    kinds: Sequence[str] = KINDS,
    profile: str | os.PathLike[str] | Profile = "pa10-sim",
    *,
    seconds: float = 40.0,
    rate: float = 500.0,
    spread: float = 0.2,
    temperature: bool = False,
    centred: bool = True,
) -> tuple[dict[str, Recording], JsonObject]:
    """Runs of one arm (drawn by the seed) with the effects hidden in it, and the truth.

    ``ref_a``, ``ref_b`` among the kinds are of the same arm before the effects came. Motions, arm
    and noise follow from the seed alone; the same call gives the same numbers. For the time that
    a torque belongs to (centred) see run_motion.
    """
    robot = open_robot(profile)
    reach = reach_of(robot)
    dynamics = {"spread": spread, "seed": seed}
    runs: dict[str, Recording] = {}
    for kind in kinds:
        number = sum(kind.encode())
        rng = np.random.default_rng([seed, number])
        present = () if kind.startswith("ref") else effects
        plant = build(
            robot, effects=present, noise=noise, seed=1000 * seed + number, dynamics=dynamics
        )
        motion = motion_of(kind, rng, reach, seconds)
        run, _ = run_motion(plant, robot, motion, seconds, rate, centred)
        runs[kind] = Recording(
            kind, run.t, run.q, run.tau, temperature=run.temperature if temperature else None
        )
    return runs, truth_of(seed, effects, noise, plant, spread)


def truth_of(
    seed: int, effects: Sequence[Mapping[str, Any]], noise: Any, plant: Plant, spread: float
) -> JsonObject:
    """What was simulated, fit for JSON."""
    book, arm = plant.textbook, plant.physics.arm
    return {
        "seed": seed,
        "effects": [dict(e) for e in effects],
        "noise": noise,
        "spread": spread,
        "rotor_inertia": book.rotor_inertia.tolist(),
        "coulomb": book.coulomb.tolist(),
        "viscous": book.viscous.tolist(),
        "mass": arm.mass.tolist(),
        "com": arm.com.tolist(),
    }
