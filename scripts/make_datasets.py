#!/usr/bin/env python3
"""Write simulated data sets with known answers, as CSV files that `pa10d run import` reads.

    make_datasets.py --out DIR --sets 28 --seed 1            random effects, some none, some two
    make_datasets.py --out DIR --effect stribeck --sets 3    one effect, three arms
    make_datasets.py --out DIR --effect none --noise coloured

Each set is a folder with train_a, train_b, valid_a, valid_b (and ref_a, ref_b where the question
is what changed), robot.urdf and truth.json.
"""

from __future__ import annotations

import argparse
import json
import shutil
import time
from pathlib import Path
from typing import Any

import numpy as np

from backends.virtual.datasets import (
    KINDS,
    Figures,
    figures_of,
    make_runs,
    open_robot,
    random_effect,
    write_csv,
)
from backends.virtual.plant.catalogue import ALL, LISTED, UNLISTED
from pa10d.effects import all_effects

NOISES = ("white", "strong", "coloured")


def main() -> None:
    """Draw and write the sets."""
    args = arguments()
    robot = open_robot(args.profile)
    figures = figures_of(robot)
    for number in range(args.sets):
        started = time.perf_counter()
        seed = args.seed + number
        effects, noise = drawn(seed, args.effect, args.noise, figures)
        changed = any(asks_what_changed(e["effect"]) for e in effects)
        kinds = (("ref_a", "ref_b") if changed else ()) + KINDS
        runs, truth = make_runs(
            seed, effects, noise, kinds, robot, seconds=args.seconds, temperature=args.temperature
        )
        folder = args.out / f"set{seed:03d}"
        folder.mkdir(parents=True, exist_ok=True)
        for name, run in runs.items():
            write_csv(folder / f"{name}.csv.gz", run)
        shutil.copyfile(robot.urdf, folder / "robot.urdf")
        (folder / "truth.json").write_text(json.dumps(truth, indent=1), encoding="utf-8")
        hidden = ", ".join(e["effect"] for e in effects) or "nothing"
        print(f"{folder}: {hidden}, {noise} noise, {time.perf_counter() - started:.1f} s")


def drawn(
    seed: int, asked: list[str], noise: str, figures: Figures
) -> tuple[list[dict[str, Any]], str]:
    """Effects and noise of one set; asked is ["random"], ["none"] or names of effects."""
    rng = np.random.default_rng([seed, 99])
    kind = str(rng.choice(NOISES, p=[0.8, 0.1, 0.1])) if noise == "random" else noise
    if asked == ["none"]:
        return [], kind
    if asked != ["random"]:
        return [random_effect(rng, name, figures) for name in asked], kind
    how_many = int(rng.choice([0, 1, 2], p=[0.1, 0.75, 0.15]))
    pool = list(UNLISTED) if how_many == 1 and rng.random() < 0.1 else list(LISTED)
    names = [str(n) for n in rng.choice(pool, how_many, replace=False)]
    return [random_effect(rng, name, figures) for name in names], kind


def asks_what_changed(name: str) -> bool:
    """Does it happen to an arm that was known before? Effects outside the library do not."""
    kind = all_effects().get(name)
    return kind is not None and kind.question == "changed"


def arguments() -> argparse.Namespace:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True, help="folder for the sets")
    parser.add_argument("--sets", type=int, default=1, help="how many")
    parser.add_argument("--seed", type=int, default=1, help="of the first set; then counted up")
    parser.add_argument(
        "--effect",
        nargs="+",
        default=["random"],
        choices=["random", "none", *ALL],
        metavar="EFFECT",
        help=f"random, none, or any of {', '.join(ALL)}",
    )
    parser.add_argument("--noise", default="random", choices=["random", "none", *NOISES])
    parser.add_argument("--profile", default="pa10-sim", help="profile or URDF")
    parser.add_argument("--seconds", type=float, default=40.0)
    parser.add_argument("--temperature", action="store_true", help="write temp1.. where it warms")
    args = parser.parse_args()
    if len(args.effect) > 1 and {"random", "none"} & set(args.effect):
        parser.error("--effect: random and none stand alone")
    return args


if __name__ == "__main__":
    main()
