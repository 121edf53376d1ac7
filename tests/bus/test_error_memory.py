"""What drives remember of their errors is read and emptied, on a bus that is open or was not."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import canopen
import numpy as np
import pytest
from bus_helpers import (
    Driver,
    Meddler,
    inject_by_canopen,
    make_profile,
    own_eds_without,
    virtual_arm,
)

from backends import by_hand
from backends.canopen_cia402.backend import CanopenBackend
from backends.canopen_cia402.network import PortNetwork
from backends.error_history import DriveErrors, KeepsErrors
from backends.protocol import BackendFault
from backends.virtual.drives.injection import Injection
from backends.virtualbus import VirtualBus
from pa10d.profile import Profile


@pytest.fixture(scope="module")
def profile(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Profile]:
    """Three drives; the last one keeps no history."""
    folder: Path = tmp_path_factory.mktemp("memory")
    bare = {"eds": str(own_eds_without(folder, 0x1003, 0x603F))}
    made = make_profile(folder, each={2: bare}, control={"rate": 100.0})
    with virtual_arm(made):
        yield made


@pytest.fixture
def arm(profile: Profile) -> Iterator[CanopenBackend]:
    made = CanopenBackend(profile)
    assert isinstance(made, KeepsErrors)
    yield made
    made.close()


def test_a_bus_that_was_never_opened_is_visited(profile: Profile, arm: CanopenBackend) -> None:
    """As after a start that was refused; nothing is configured, and others may come after."""
    inject_by_canopen(profile, 1, Injection.EMCY, 0x2310)
    inject_by_canopen(profile, 1, Injection.EMCY, 0x4210)
    first, second, third = arm.read_errors()
    assert first == DriveErrors(0, 0, ())
    assert second.history == (0x4210, 0x2310)
    assert second.document()["history"][0]["words"] == "0x4210 (device too hot)"
    assert second.document()["wrong_now"] == ["generic error", "current", "temperature"]
    assert second.document()["error"]["words"] == "0x4210 (device too hot)"
    assert third == DriveErrors(0, None, None)


def test_beside_a_cycle_nothing_is_missed(profile: Profile, arm: CanopenBackend) -> None:
    """The cycle goes on as before, and what a drive tells meanwhile is a fault as ever."""
    arm.clear_errors()
    arm.open()
    driver = Driver(arm)
    for _ in range(5):
        driver.step()
    assert [one.history for one in arm.read_errors()] == [(), (), None]
    for _ in range(5):
        assert driver.step().age.max() == 0
    inject_by_canopen(profile, 0, Injection.FAULT, 0x2310)
    with pytest.raises(BackendFault, match="overcurrent"):
        driver.run(0.1)
    assert arm.read_errors()[0].history == (0x2310,)
    cleared = arm.clear_errors()
    assert [one.history for one in cleared] == [(), (), None]
    assert cleared[0].code == 0x2310, "the error itself is not acknowledged by that"
    assert [one.problem for one in cleared] == ["", "", "it keeps no history (0x1003)"]
    by_hand.reset(arm)
    by_hand.enable(arm, driver.hold)
    assert np.all(driver.run(0.2).age == 0)


def test_a_silent_drive_hides_no_other(
    profile: Profile, arm: CanopenBackend, monkeypatch: pytest.MonkeyPatch
) -> None:
    silent, patient = profile.drives[1].node, PortNetwork.add_drive

    def hasty(
        network: PortNetwork, node: int, dictionary: canopen.ObjectDictionary
    ) -> canopen.RemoteNode:
        """Only the one that cannot answer is waited for briefly: a busy host answers late."""
        remote = patient(network, node, dictionary)
        if node == silent:
            remote.sdo.RESPONSE_TIMEOUT = 0.05
        return remote

    monkeypatch.setattr(PortNetwork, "add_drive", hasty)
    inject_by_canopen(profile, 0, Injection.EMCY, 0x8611)
    with VirtualBus(profile.can.channel) as bus:
        Meddler(profile, bus).inject(1, Injection.UNPLUGGED)
    first, second, third = arm.read_errors()
    assert first.history is not None
    assert first.history[0] == 0x8611
    assert second.problem.startswith("no answer to SDO 0x1003")
    assert second.history is None
    assert third.problem == ""
    assert second.document()["problem"] == second.problem
