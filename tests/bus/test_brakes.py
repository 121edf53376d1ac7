"""``drives[].brake`` on a real bus: set before power goes, released under power only."""

from __future__ import annotations

from pathlib import Path

import pytest
from bus_helpers import Driver, make_profile, running, second_master, virtual_arm

from backends import by_hand
from backends.canopen_cia402.backend import CanopenBackend
from backends.canopen_cia402.brakes import CLOSES_IN, Brakes
from backends.cia402 import Control
from backends.frames import frame, frames
from backends.protocol import BackendFault
from backends.virtual.drives.injection import Injection
from backends.virtualbus import VirtualBus
from pa10d.profile import Profile

SET = bytes.fromhex("23 fe 60 01 01 00 00 00")
FREE = bytes.fromhex("23 fe 60 01 00 00 00 00")


def give_the_brake_to_the_master(profile: Profile, axis: int) -> None:
    """As an integrator does whose drive works no brake by itself: the bit in the mask."""
    with second_master(profile, axis) as node:
        node.sdo[0x60FE][2].raw = 1


def brake(profile: Profile, axis: int) -> tuple[int, int]:
    """(the output, whether the brake is closed) as the drive has them."""
    with second_master(profile, axis) as node:
        return node.sdo[0x60FE][1].raw, node.sdo[0x2F04].raw


def sequence_of(bus: VirtualBus, node: int) -> list[str]:
    """What was said to one node, in order, repetitions left out."""
    names = {SET: "set", FREE: "free"}
    said: list[str] = []
    while packet := bus.receive_packet(0.05):
        for can_id, data in frames(packet):
            if can_id == 0x600 + node and data in names:
                said.append(names[data])
            elif can_id == 0x200 + node:
                said.append(Control(data[0]).name)
    return [word for k, word in enumerate(said) if k == 0 or word != said[k - 1]]


@pytest.mark.parametrize("ends", ["disable", "quick stop", "close", "fault"])
def test_the_output_follows_the_power(tmp_path: Path, ends: str) -> None:
    profile = make_profile(tmp_path, 2)
    with virtual_arm(profile), VirtualBus(profile.can.channel) as spy:
        give_the_brake_to_the_master(profile, 1)
        arm = CanopenBackend(profile)
        arm.open()
        try:
            assert any("joint 2: Digital outputs (0x60FE): its mask" in w for w in arm.warnings)
            assert brake(profile, 1) == (1, 1)
            driver = Driver(arm)
            sequence_of(spy, 11)
            by_hand.enable(arm, driver.hold)
            driver.run(0.1)
            assert sequence_of(spy, 11)[-4:] == ["SWITCH_ON", "ENABLE", "free", "ENABLE"]
            assert brake(profile, 1) == (0, 0)
            driver.run(0.3)
            sequence_of(spy, 11)
            if ends == "disable":
                by_hand.disable(arm, driver.hold)
                said = sequence_of(spy, 11)
                assert said.index("set") < said.index("SWITCH_ON"), "it holds before power goes"
            elif ends == "quick stop":
                arm.quick_stop()
                driver.run_on(1.0)
            elif ends == "fault":
                with second_master(profile, 1) as node:
                    node.sdo[0x2F00][2].raw = 0x2310
                    node.sdo[0x2F00][1].raw = int(Injection.FAULT)
                driver.run_on(1.0)
        finally:
            arm.close()
        assert brake(profile, 1) == (1, 1)


def test_a_drive_that_works_its_brake_itself_is_told_the_same(tmp_path: Path) -> None:
    """The bit is out of its mask, and its own sequence decides."""
    profile = make_profile(tmp_path, 1)
    with virtual_arm(profile):
        with running(profile) as (arm, _, _other):
            assert arm.warnings == []
            assert brake(profile, 0) == (0, 0)
        assert brake(profile, 0) == (1, 1)


def test_without_a_brake_the_output_is_not_touched(tmp_path: Path) -> None:
    profile = make_profile(tmp_path, 1, drive={"brake": False})
    with virtual_arm(profile):
        with second_master(profile, 0) as node:
            node.sdo[0x60FE][1].raw = 0x10000
        with running(profile) as (arm, _, _other):
            assert arm.warnings == [
                "joint 1: no brake by the profile: without power this joint is held by nothing"
            ]
            assert brake(profile, 0)[0] == 0x10000
        assert brake(profile, 0)[0] == 0x10000


def test_an_output_that_the_drive_refuses_is_a_fault(tmp_path: Path) -> None:
    profile = make_profile(tmp_path, 2)
    with virtual_arm(profile), running(profile) as (_, driver, other):
        refused = bytes.fromhex("80 fe 60 01 22 00 00 08")
        other.bus.send_packet(frame(0x58B, refused))
        with pytest.raises(BackendFault, match="joint 2: does not set its brake's output") as found:
            driver.run(0.5)
        assert found.value.kind == "brake_output"
        assert "`brake_output`" in (Path(__file__).parents[2] / "docs" / "faults.md").read_text()


def test_power_waits_for_the_brake_and_other_outputs_stay() -> None:
    sent: list[tuple[int, int]] = []
    brakes = Brakes([None, 0xA0000], lambda axis, value: sent.append((axis, value)))
    enabled, on = [0x1627] * 2, [int(Control.ENABLE)] * 2
    off = [int(Control.SWITCH_ON)] * 2
    assert brakes.let_pass(on, [0x0623] * 2, 0.0) == on
    assert sent == [], "powered, but not yet enabled: it is set already"
    assert brakes.let_pass(on, enabled, 0.1) == on
    assert brakes.let_pass(off, enabled, 1.0) == [Control.SWITCH_ON, Control.ENABLE]
    assert brakes.let_pass(off, enabled, 1.0 + CLOSES_IN / 2) == [Control.SWITCH_ON, Control.ENABLE]
    assert brakes.let_pass(off, enabled, 1.0 + CLOSES_IN) == off
    assert brakes.let_pass(on, enabled, 2.0) == on, "enabled again before it went off"
    for stopping in (0x1607, 0x160F):
        brakes.let_pass([int(Control.QUICK_STOP)] * 2, [stopping] * 2, 3.0)
    assert sent == [(1, 0xA0000), (1, 0xA0001), (1, 0xA0000)]
    brakes.let_pass(on, [0x0628] * 2, 4.0)
    assert sent[-1] == (1, 0xA0001), "a fault takes the power, whatever was asked"
