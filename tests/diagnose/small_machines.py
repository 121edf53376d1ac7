"""Recordings of small real machines beside the project; skipped where they are absent."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

from pa10d.dynamics import Robot, robot_from_urdf
from pa10d.measurement.recording import Recording

sys.path.append(str(Path(__file__).parents[2] / "scripts"))
bench_real = importlib.import_module("bench_real")


def machine(name: str, files: Sequence[str]) -> tuple[Robot, list[Recording]]:
    """The robot of a folder and some of its runs."""
    folder = bench_real.DATA / name
    if not folder.exists():
        pytest.skip(f"{folder} is not here: recordings of real machines")
    robot = robot_from_urdf(str(folder / "robot.urdf"))
    return robot, [bench_real.load(name, file, robot.n) for file in files]


def servo(*motions: str) -> tuple[Robot, list[Recording]]:
    """A small servo that swings a known weight: all four gains of each motion."""
    gains = (100, 200, 400, 800)
    return machine("bam_xl330", [f"xl330_{m}_kp{k}.csv" for m in motions for k in gains])
