"""A simulated UR5e of which nothing is hidden, as the checks of a recording see it."""

from __future__ import annotations

from backends.virtual.datasets import make_runs
from pa10d.dynamics import Robot
from pa10d.measurement.recording import Recording
from pa10d.profile import load_profile
from pa10d.services.robots import load_robot


def ur5e() -> Robot:
    return load_robot("ur5e")[1]


def recorded(seconds: float) -> Recording:
    runs, _ = make_runs(
        5, [], "white", ("train_a",), load_profile("ur5e"), seconds=seconds, rate=200.0
    )
    return runs["train_a"]
