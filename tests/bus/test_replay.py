"""Replay: the second backend behind the same protocol."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from bus_helpers import JOINTS, make_profile

from backends import by_hand
from backends.protocol import Backend, BackendFault
from backends.registry import open_backend
from pa10d.common.errors import UserError
from pa10d.measurement.recording import Recording
from pa10d.replay import ReplayBackend
from pa10d.store.channels import Samples
from pa10d.store.run_reader import StoredRun


def some_run(folder: Path, joints: int = 3, samples: int = 200) -> Path:
    draw = np.random.default_rng(0)
    t = np.arange(samples) * 0.005
    table = np.column_stack([t, draw.normal(size=(samples, 3 * joints))])
    names = [f"{kind}{k + 1}" for kind in ("q", "tau", "temp") for k in range(joints)]
    path = folder / "run.csv"
    np.savetxt(path, table, delimiter=",", header=",".join(["time", *names]), comments="")
    return path


def replay(folder: Path, **options: object) -> Backend:
    return open_backend(make_profile(folder, backend="replay", simulation={"options": options}))


def test_one_line_in_the_profile_swaps_the_backend(tmp_path: Path) -> None:
    path = some_run(tmp_path)
    arm = replay(tmp_path, recording=path.name)
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    arm.open()
    by_hand.enable(arm)
    assert arm.n == 3
    assert arm.period == pytest.approx(0.005)
    for row in table:
        feedback = arm.read()
        arm.write(np.zeros(3))
        assert np.allclose(feedback.q, row[1:4], atol=1e-12)
        assert np.allclose(feedback.tau, row[4:7], atol=1e-12)
        assert feedback.temperature is not None
        assert np.allclose(feedback.temperature, row[7:10])
        assert (feedback.age == 0).all()
    with pytest.raises(BackendFault, match=r"over after 0\.995 s") as caught:
        arm.read()
    assert caught.value.kind == "ended"
    by_hand.reset(arm)
    assert np.allclose(arm.read().q, table[0, 1:4])
    arm.close()


def test_a_profile_that_was_changed_since_is_told_apart(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Other joints, or the same in another order, would show one joint's angles as another's."""
    t = np.arange(50) * 0.004
    stamps = (1e9 * t).astype(np.int64) + 1
    samples = Samples(stamps, np.zeros((50, 3)), np.zeros((50, 3)))
    path = tmp_path / "run.mcap"
    path.touch()

    def opened(joints: list[str]) -> Backend:
        run = StoredRun(tuple(joints), samples, 0, {}, True)
        monkeypatch.setattr("pa10d.replay.read_run", lambda _: run)
        profile = make_profile(
            tmp_path, backend="replay", simulation={"options": {"recording": "run.mcap"}}
        )
        return open_backend(profile)

    said = opened(JOINTS[:3]).warnings
    assert any("played at the 250 Hz" in one and "says 200 Hz" in one for one in said)
    with pytest.raises(UserError, match="expected the same in this order"):
        opened(JOINTS[2::-1])


def test_it_refuses_what_is_not_a_torque() -> None:
    t = np.arange(10) * 0.01
    arm = ReplayBackend(Recording("r", t, np.zeros((10, 1)), np.zeros((10, 1))))
    arm.open()
    with pytest.raises(BackendFault, match="not finite"):
        arm.write(np.array([np.nan]))


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({}, "recording: missing"),
        ({"recording": "nowhere.csv"}, "no file .*nowhere.csv"),
    ],
)
def test_a_wrong_recording_is_one_line(tmp_path: Path, options: dict[str, str], text: str) -> None:
    with pytest.raises(UserError, match=text) as caught:
        replay(tmp_path, **options)
    assert "\n" not in str(caught.value)


def test_an_unknown_backend_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(
        UserError, match="backend: found 'nonsense', expected one of canopen_cia402"
    ):
        open_backend(make_profile(tmp_path, backend="nonsense"))
    with pytest.raises(UserError, match="no module named 'nowhere'"):
        open_backend(make_profile(tmp_path, backend="nowhere:factory"))


def test_a_backend_of_a_third_party(tmp_path: Path) -> None:
    """A module of the tests' own, named in one line."""
    arm = open_backend(make_profile(tmp_path, backend="still_arm:open_backend"))
    arm.open()
    assert arm.read().q.tolist() == [0.0, 0.0, 0.0]
