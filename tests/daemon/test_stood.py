"""Where the arm stood at rest, kept for the daemon that comes next."""

from __future__ import annotations

import asyncio
import json

import numpy as np
import pytest

from pa10d.daemon.robot.stood import StoodAt
from pa10d.profile import load_profile

NAME = "stood.json"

SIMULATED = load_profile("pa10-sim")
REAL = SIMULATED.model_copy(update={"simulation": None})
POSE, STILL = np.linspace(0.0, 0.6, 7), np.zeros(7)


def noted(folder, profile=REAL, dq=STILL) -> None:
    async def note() -> None:
        stood = StoodAt(profile, folder)
        stood.note(POSE, dq)
        await asyncio.sleep(0.1)
        stood.close()

    asyncio.run(note())


def test_it_is_there_for_the_next_one(tmp_path):
    noted(tmp_path)
    assert StoodAt(REAL, tmp_path).known == pytest.approx(POSE)


def test_a_virtual_arm_begins_anew(tmp_path):
    noted(tmp_path, SIMULATED)
    assert not list(tmp_path.iterdir())


def test_what_moves_is_not_kept(tmp_path):
    noted(tmp_path, dq=0.1 + STILL)
    assert StoodAt(REAL, tmp_path).known is None


def test_of_an_arm_that_is_powered_nothing_is_kept(tmp_path):
    """Who is killed then leaves it wherever it comes to rest."""

    async def powered() -> None:
        stood = StoodAt(REAL, tmp_path)
        stood.note(POSE, STILL)
        await stood.forget()
        assert stood.known is None
        stood.close()

    asyncio.run(powered())
    assert not (tmp_path / NAME).exists()
    assert StoodAt(REAL, tmp_path).known is None


def test_of_another_zero_nothing_is_known(tmp_path):
    noted(tmp_path)
    turned = [REAL.drives[0].model_copy(update={"zero_offset": 0.1}), *REAL.drives[1:]]
    other = REAL.model_copy(update={"drives": turned})
    assert StoodAt(other, tmp_path).known is None
    stood = StoodAt(REAL, tmp_path)
    stood.becomes(other)
    assert stood.known is None


@pytest.mark.parametrize(
    "damage",
    ["", "[1]", "{", '{"stood": 3}', "NaN", "[" * 5000, "drives", "short"],
)
def test_what_is_damaged_is_not_known(tmp_path, damage):
    noted(tmp_path)
    kept = json.loads((tmp_path / NAME).read_text())
    if damage == "drives":
        damage = json.dumps({**kept, "stood": [float("nan")] * 7})
    if damage == "short":
        damage = json.dumps({**kept, "stood": [0.0]})
    (tmp_path / NAME).write_text(damage)
    assert StoodAt(REAL, tmp_path).known is None


def test_a_disk_that_takes_nothing_is_said_once(tmp_path, caplog):
    async def note() -> None:
        stood = StoodAt(REAL, tmp_path / "nowhere")
        for turn in range(3):
            stood.note(POSE + turn, STILL)
            await asyncio.sleep(0.1)
        stood.close()

    asyncio.run(note())
    assert [r.message for r in caplog.records] == [
        f"{tmp_path}/nowhere/.{NAME}: No such file or directory; where the arm stands is not kept"
    ]
