"""``drives[].brake`` on a real bus: set before power goes, released under power only."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bus_helpers import Driver, make_profile, running, second_master, virtual_arm

from backends import by_hand
from backends.canopen_cia402.backend import CanopenBackend
from backends.canopen_cia402.brakes import CLOSES_IN, Brake, Brakes
from backends.cia402 import Control
from backends.eds import OWN_EDS
from backends.frames import frame, frames
from backends.protocol import BackendFault, Feedback
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


@pytest.mark.by_default("fault")
@pytest.mark.parametrize(
    "ends",
    [
        "disable",
        *(pytest.param(end, marks=pytest.mark.long) for end in ("quick stop", "close")),
        "fault",
    ],
)
def test_the_output_follows_the_power(tmp_path: Path, ends: str) -> None:
    profile = make_profile(tmp_path, 2)
    with virtual_arm(profile), VirtualBus(profile.can.channel) as spy:
        give_the_brake_to_the_master(profile, 1)
        arm = CanopenBackend(profile)
        arm.open()
        try:
            assert any("joint 2: Digital outputs (0x60FE): its mask" in w for w in arm.warnings)
            driver = Driver(arm)
            driver.run(0.1)
            assert brake(profile, 1) == (1, 1)
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


@pytest.mark.long
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


@pytest.mark.by_default("fault")
@pytest.mark.parametrize(
    ("ends", "falls"),
    [
        pytest.param("quick stop", 2e-3, marks=pytest.mark.long),
        ("fault", 2e-3),
        pytest.param("fault of one whose sign nobody has seen", 0.015, marks=pytest.mark.long),
        ("refused quick stop", 2e-3),
    ],
    ids=["quick stop", "fault", "fault before its sign is known", "refused quick stop"],
)
def test_nothing_falls_before_a_brake_that_only_we_close(
    tmp_path: Path, ends: str, falls: float
) -> None:
    """The pendulum is held at 0.8 rad against gravity; its drive does not close the brake. falls:
    rad; 8e-3 where power goes first, as it has to before its sign is known."""
    settings: dict[str, Any] = {}
    if ends == "refused quick stop":
        text = OWN_EDS.read_text()
        at = text.index("[605A]")
        end = text.index("HighLimit=", at)
        (tmp_path / "plain.eds").write_text(
            text[:end] + text[end:].replace(text[end:].splitlines()[0], "HighLimit=2", 1)
        )
        settings = {"drive": {"eds": str(tmp_path / "plain.eds")}}
    profile = make_profile(tmp_path, 1, **settings)
    with virtual_arm(profile):
        give_the_brake_to_the_master(profile, 0)
        arm = CanopenBackend(profile)
        arm.trust([0] if ends == "fault" else [])
        arm.open()
        try:
            lifted = Lifted(arm)
            by_hand.enable(arm, lifted.torque)
            lifted.run(2.0)
            held_at = arm.read().q[0]
            arm.write(lifted.torque(arm.read()))
            with second_master(profile, 0) as node:
                stays = ends != "refused quick stop"
                assert node.sdo[0x605A].raw == (6 if stays else 2)
                if "fault" in ends:
                    node.sdo[0x2F00][2].raw = 0x2310
                    node.sdo[0x2F00][1].raw = int(Injection.FAULT)
            if "quick stop" in ends:
                arm.quick_stop()
            lowest = held_at
            for _ in range(100):
                with suppress(BackendFault):
                    lowest = min(lowest, arm.read().q[0])
                arm.write(np.zeros(1))
            assert held_at - lowest < falls
            assert arm.statuses()[0] & 0x6F in (0x40, 0x08)
            assert brake(profile, 0) == (1, 1)
        finally:
            arm.close()


class Lifted(Driver):
    """Holds its joints at 0.8 rad."""

    def torque(self, feedback: Feedback, moving: bool = True) -> Any:
        now, q = feedback.time, feedback.q.copy()
        dq = np.zeros_like(q)
        if self._last is not None and now > self._last[0]:
            dq = (q - self._last[1]) / (now - self._last[0])
        self._last = (now, q)
        return np.clip(600 * (min(0.8, 0.8 * now) - q) - 60 * dq + 20 * np.sin(q), -100, 100)


def test_a_brake_that_only_we_close_is_a_risk_to_be_accepted(tmp_path: Path) -> None:
    profile = make_profile(tmp_path, 2)
    with virtual_arm(profile):
        give_the_brake_to_the_master(profile, 1)
        arm = CanopenBackend(profile)
        arm.open()
        try:
            arm.profile = profile.model_copy(update={"simulation": None})  # as if it were real
            with pytest.raises(BackendFault, match=r"accepted_risks: \[brake_on_us\]") as caught:
                arm.begin_enable()
            assert caught.value.axes == (1,)
        finally:
            arm.close()


AT = np.zeros(2)
ON, OFF, QUICK = ([int(w)] * 2 for w in (Control.ENABLE, Control.SWITCH_ON, Control.QUICK_STOP))
IS_ENABLED, IN_QUICK_STOP, REACTS = [0x1627] * 2, [0x1607] * 2, [0x160F] * 2


class Told:
    """What the drive of axis 1 was told, and whether it confirms."""

    def __init__(self, ours: bool = False, answers: bool = True) -> None:
        self.sent: list[tuple[int, int]] = []
        self.silent: list[int] = []
        self.answers = answers
        self.brakes = Brakes(
            [Brake(), Brake(0xA0000, ours)], [2.0, 2.0], self._take, self.silent.append
        )

    def _take(self, axis: int, value: int) -> None:
        self.sent.append((axis, value))
        if self.answers:
            self.brakes.taken(axis)


def test_time_in_which_nobody_tells_a_drive_anything_is_no_silence_of_its_own() -> None:
    """After a fault nothing is sent until the reset; a drive that is back by then is told again."""
    told = Told(answers=False)
    brakes, now = told.brakes, 0.0
    brakes.let_pass(OFF, IS_ENABLED, now, AT)
    brakes.let_pass(ON, IS_ENABLED, now, AT)
    for now in (10.0, 10.5):
        brakes.let_pass(ON, IS_ENABLED, now, AT)
    assert told.silent == []
    assert len(told.sent) >= 3, "it was told again"
    told.answers = True
    told.brakes.let_pass(ON, IS_ENABLED, 11.0, AT)
    assert told.silent == []
    told.answers = False
    brakes.let_pass(OFF, IS_ENABLED, 11.1, AT)
    for now in np.arange(11.1, 13.0, 0.02):
        brakes.let_pass(OFF, IS_ENABLED, float(now), AT)
    assert told.silent == [1], "that one was asked all the while"


def test_power_waits_for_the_brake_and_other_outputs_stay() -> None:
    told = Told()
    brakes, sent = told.brakes, told.sent
    assert brakes.let_pass(ON, [0x0623] * 2, 0.0, AT) == ON
    assert sent == [], "powered, but not yet enabled: it is set already"
    assert brakes.let_pass(ON, IS_ENABLED, 0.1, AT) == ON
    assert brakes.let_pass(OFF, IS_ENABLED, 1.0, AT) == [Control.SWITCH_ON, Control.ENABLE]
    half = brakes.let_pass(OFF, IS_ENABLED, 1.0 + CLOSES_IN / 2, AT)
    assert half == [Control.SWITCH_ON, Control.ENABLE]
    assert brakes.let_pass(OFF, IS_ENABLED, 1.0 + CLOSES_IN, AT) == OFF
    assert brakes.let_pass(ON, IS_ENABLED, 2.0, AT) == ON, "enabled again before it went off"
    brakes.let_pass(QUICK, IS_ENABLED, 3.0, AT)
    for stopping in (IN_QUICK_STOP, REACTS):
        brakes.let_pass(QUICK, stopping, 3.0, AT)
    assert sent == [(1, 0xA0000), (1, 0xA0001), (1, 0xA0000)], "not onto an axis that moves"
    brakes.let_pass(ON, [0x0628] * 2, 4.0, AT)
    assert sent[-1] == (1, 0xA0001), "a fault takes the power, whatever was asked"


@pytest.mark.parametrize("state", [IN_QUICK_STOP, REACTS])
def test_a_brake_that_only_we_close_falls_in_as_the_axis_comes_to_rest(state: list[int]) -> None:
    told = Told(ours=True)
    brakes, sent = told.brakes, told.sent
    brakes.let_pass(ON, IS_ENABLED, 0.0, AT)
    q, speed, now = np.zeros(2), 1.0, 0.0
    passed = [brakes.let_pass(QUICK, IS_ENABLED, 0.0, q)[1]]
    while len(sent) < 2:
        now, q, speed = now + 0.01, q + 0.01 * speed, speed - 0.02
        passed.append(brakes.let_pass(QUICK, state, now, q)[1])
        assert speed > 0.0, "it stands, and its brake is open"
    assert speed == pytest.approx(2.0 * CLOSES_IN, abs=0.03), "rest is as far away as the brake"
    brakes.let_pass(QUICK, state, now + 0.9 * CLOSES_IN, q)
    assert set(passed) == {Control.QUICK_STOP}
    off = [int(Control.DISABLE_VOLTAGE)] * 2
    ends = brakes.let_pass(off, state, now + 0.95 * CLOSES_IN, q)[1]
    assert ends == (Control.QUICK_STOP if state == IN_QUICK_STOP else Control.DISABLE_VOLTAGE)
    ends = brakes.let_pass(QUICK, state, now + CLOSES_IN, q)[1]
    assert ends == (Control.DISABLE_VOLTAGE if state == IN_QUICK_STOP else Control.QUICK_STOP)


def test_who_does_not_confirm_is_told_again_and_not_waited_for_for_ever() -> None:
    told = Told()
    told.brakes.let_pass(ON, IS_ENABLED, 0.0, AT)
    told.answers = False
    told.sent.clear()
    for k in range(99):
        assert told.brakes.let_pass(OFF, IS_ENABLED, 1.0 + 0.01 * k, AT)[1] == Control.ENABLE
    assert 18 <= len(told.sent) <= 20
    assert set(told.sent) == {(1, 0xA0001)}
    assert told.silent == []
    assert told.brakes.let_pass(OFF, IS_ENABLED, 2.01, AT) == OFF
    told.brakes.let_pass(OFF, IS_ENABLED, 2.1, AT)
    assert told.silent == [1], "said once"

    late = Told(answers=False)
    late.brakes.let_pass(ON, IS_ENABLED, 0.0, AT)
    late.brakes.taken(1)
    late.brakes.let_pass(OFF, IS_ENABLED, 1.0, AT)
    late.brakes.let_pass(OFF, IS_ENABLED, 1.2, AT)
    late.brakes.taken(1)
    assert late.brakes.let_pass(OFF, IS_ENABLED, 1.3, AT)[1] == Control.ENABLE
    assert late.brakes.let_pass(OFF, IS_ENABLED, 1.35, AT) == OFF, "counted from the answer on"
