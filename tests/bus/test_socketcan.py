"""The same backend and the same drives over a real SocketCAN interface (run inside the rig).

Nothing here depends on deadlines: the rig's system calls are some sixty times slower.
"""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from bus_helpers import Driver, inject_by_canopen, make_profile, patient_eds, virtual_arm

from backends import by_hand
from backends.canopen_cia402.backend import CanopenBackend
from backends.cia402 import DriveState, state_of
from backends.protocol import BackendFault
from backends.virtual.drives.injection import Injection
from pa10d.profile import Profile

pytestmark = [
    pytest.mark.realtime,
    pytest.mark.socketcan,
    pytest.mark.skipif(
        not Path("/sys/class/net/vcan0").exists(),
        reason="no vcan0 on this kernel: run scripts/rig-tests",
    ),
]
VCAN = {"interface": "socketcan", "channel": "vcan0"}


@pytest.fixture(params=["real", pytest.param("simulated", marks=pytest.mark.long)])
def profile(tmp_path: Path, request: pytest.FixtureRequest) -> Profile:
    return make_profile(
        tmp_path,
        7,
        can=VCAN,
        simulation={"clock": request.param},
        control={"rate": 50.0},
        safety={"stale_cycles": 25},
        drive={"eds": patient_eds(tmp_path), "heartbeat_ms": 200},
    )


@pytest.fixture
def arm(profile: Profile) -> Iterator[CanopenBackend]:
    with virtual_arm(profile):
        backend = CanopenBackend(profile)
        backend.open()
        try:
            yield backend
        finally:
            backend.close()


def test_the_whole_life(arm: CanopenBackend, profile: Profile) -> None:
    driver = Driver(arm, frequency=0.2)
    by_hand.enable(arm, driver.hold)
    feedback = driver.run(4.0)
    assert {state_of(int(s)) for s in feedback.status} == {DriveState.ENABLED}
    assert np.ptp(feedback.q) < 0.05, "seven equal axes move alike"
    assert driver.reach > 0.05, "it swings; where it is at the end depends on the clock"
    arm.quick_stop()
    driver.until(lambda f: {state_of(int(s)) for s in f.status} == {DriveState.DISABLED})
    by_hand.enable(arm, driver.hold)
    inject_by_canopen(profile, 3, Injection.FAULT, 0x2310)
    with pytest.raises(BackendFault, match=r"joint 4.*overcurrent"):
        driver.run(4.0)
    by_hand.disable(arm)
    by_hand.reset(arm)
    by_hand.enable(arm, driver.hold)
    driver.run(0.5)
    by_hand.disable(arm)
    assert {state_of(s) for s in arm.statuses()} == {DriveState.DISABLED}


def ip(*arguments: str) -> None:
    subprocess.run(["ip", "link", *arguments], check=True)


@pytest.mark.parametrize("profile", ["real"], indirect=True)
def test_the_interface_goes_away_in_mid_cycle_and_comes_back(arm: CanopenBackend) -> None:
    for leave, errno in ((["set", "vcan0", "down"], 100), (["del", "vcan0"], 19)):
        driver = Driver(arm, frequency=0.2)
        by_hand.enable(arm, driver.hold)
        driver.run(0.5)
        ip(*leave)
        errors = []
        for _ in range(3):
            with pytest.raises(BackendFault) as caught:
                driver.run(2.0)
            assert (caught.value.kind, caught.value.axis) == ("interface_down", None)
            errors.append(caught.value.cause)
        assert any(f"errno {errno}" in cause for cause in errors), errors
        if errno == 19:
            ip("add", "vcan0", "type", "vcan")
        ip("set", "vcan0", "up")
        reset(arm)
    driver = Driver(arm, frequency=0.2)
    by_hand.enable(arm, driver.hold)
    assert {state_of(int(s)) for s in driver.run(0.5).status} == {DriveState.ENABLED}


def reset(arm: CanopenBackend) -> None:
    """The drives look for the bus as well; give them time."""
    for attempt in range(5):
        try:
            return by_hand.reset(arm)
        except BackendFault:
            if attempt == 4:
                raise
