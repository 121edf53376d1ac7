"""Same seed, same plant, same plan: the same numbers to the last bit, frames on the bus."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from bus_helpers import Driver, make_profile, virtual_arm

from backends import by_hand
from backends.canopen_cia402.backend import CanopenBackend
from pa10d.profile import Profile


def record(profile: Profile, cycles: int = 150) -> tuple[bytes, ...]:
    """time, q, tau, status, temperature of a run, as bytes."""
    rows: list[list[np.ndarray]] = [[], [], [], [], []]
    with virtual_arm(profile):
        arm = CanopenBackend(profile)
        arm.open()
        try:
            driver = Driver(arm)
            by_hand.enable(arm, driver.hold)
            for _ in range(cycles):
                f = driver.step()
                assert f.temperature is not None
                values = (np.array(f.time), f.q, f.tau, f.status, f.temperature)
                for column, value in zip(rows, values, strict=True):
                    column.append(value.copy())
        finally:
            arm.close()
    return tuple(np.array(column).tobytes() for column in rows)


def noisy(folder: Path, seed: int) -> Profile:
    options = {"noise": 0.5, "seed": seed}
    return make_profile(folder, 7, simulation={"options": options}, control={"rate": 500.0})


@pytest.mark.long
def test_recordings_are_identical_to_the_bit(tmp_path: Path) -> None:
    first = record(noisy(tmp_path, 1))
    assert record(noisy(tmp_path, 1)) == first
    other = record(noisy(tmp_path, 2))
    assert other[0] == first[0], "time does not depend on the seed"
    assert other[2] != first[2], "the noise does"


@pytest.mark.long
def test_also_with_the_built_in_plant(tmp_path: Path) -> None:
    profile = make_profile(
        tmp_path,
        7,
        simulation={"plant": "backends.virtual.plant:build"},
        control={"rate": 500.0},
        drive={"rated_torque": 4.64},
    )
    first = record(profile, 200)
    assert record(profile, 200) == first
