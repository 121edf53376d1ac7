"""A drive stops its axis when the control PC dies, or the profile says that it knows better."""

from __future__ import annotations

from pathlib import Path

import pytest
from bus_helpers import make_profile, own_eds_without, running, virtual_arm

from backends import by_hand
from backends.canopen_cia402 import lifeline
from backends.canopen_cia402.backend import CanopenBackend
from backends.canopen_cia402.lifeline import not_accepted
from backends.frames import REMOTE, frame, frames
from backends.protocol import BackendFault
from backends.virtualbus import VirtualBus
from pa10d.common.errors import UserError


def heard(bus: VirtualBus) -> list[tuple[int, bytes]]:
    """Everything that came and was not looked at yet."""
    found = []
    while packet := bus.receive_packet(0.02):
        found += list(frames(packet))
    return found


def missing_us(bus: VirtualBus, axes: int) -> list[int]:
    """Nodes that report a missed master while SYNC alone goes on; they then answer no more."""
    found: set[int] = set()
    for _ in range(400):
        bus.send_packet(frame(0x80))
        packet = bus.receive_packet(0.1)
        found |= {k - 0x80 for k, data in frames(packet) if 0x80 < k < 0x100 and data[0] == 0x30}
        if len(found) == axes:
            break
    return sorted(found)


@pytest.mark.by_default("lacking0")
@pytest.mark.parametrize("lacking", [(), (0x1016,)])
def test_every_drive_notices_our_death_by_heartbeats_or_by_guarding(
    tmp_path: Path, lacking: tuple[int, ...]
) -> None:
    poor = {"eds": str(own_eds_without(tmp_path, *lacking))}
    profile = make_profile(tmp_path, 2, each={1: poor})
    with virtual_arm(profile), running(profile) as (arm, driver, other):
        assert [r.guarded for r in arm.reports] == [False, bool(lacking)]
        assert arm.warnings == []
        heard(other.bus)
        driver.run(1.0)
        asked = {can_id for can_id, _ in heard(other.bus) if can_id & REMOTE}
        assert asked == ({REMOTE | 0x70B} if lacking else set())
        assert missing_us(other.bus, 2) == [10, 11]


@pytest.mark.by_default("lacking0")
@pytest.mark.parametrize(
    ("lacking", "risks"),
    [
        ((0x6007,), {"unknown_reaction": "no Abort connection option code (0x6007)"}),
        (
            (0x1016, 0x100D),
            {"unwatched": "no Consumer heartbeat time (0x1016): the drive does not"},
        ),
    ],
)
def test_what_nobody_may_overlook(
    tmp_path: Path, lacking: tuple[int, ...], risks: dict[str, str]
) -> None:
    profile = make_profile(tmp_path, 1, drive={"eds": str(own_eds_without(tmp_path, *lacking))})
    with virtual_arm(profile):
        arm = CanopenBackend(profile)
        arm.open()
        arm.close()
    [report] = arm.reports
    assert report.risks.keys() == risks.keys()
    for name, text in risks.items():
        assert report.risks[name].startswith(text)  # type: ignore[index]
        assert f"joint 1: {report.risks[name]}" in arm.warnings  # type: ignore[index]
    assert profile.drives is not None
    drive = profile.drives[0]
    assert len(not_accepted(drive, report.risks)) == 1
    assert (
        not_accepted(drive.model_copy(update={"accepted_risks": list(risks)}), report.risks) == []
    )


def test_a_drive_without_heartbeat_is_not_said_to_have_lost_it(tmp_path: Path) -> None:
    profile = make_profile(tmp_path, 1, drive={"eds": str(own_eds_without(tmp_path, 0x1017))})
    with virtual_arm(profile), running(profile) as (arm, driver, _):
        assert "joint 1: no Producer heartbeat time (0x1017)" in arm.warnings[0]
        driver.run(2.0)


def test_accepted_risks_are_typed(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"accepted_risks.*'unwatched', .* or 'brake_on_us'"):
        make_profile(tmp_path, 1, drive={"accepted_risks": ["whatever"]})
    made = make_profile(tmp_path, 1, drive={"accepted_risks": ["unwatched"]})
    assert made.drives is not None
    assert made.drives[0].accepted_risks == ["unwatched"]


def test_a_real_arm_is_not_powered_before_its_risks_are_accepted(tmp_path: Path) -> None:
    poor = {"eds": str(own_eds_without(tmp_path, 0x6007))}
    profile = make_profile(tmp_path, 3, each={1: poor, 2: poor})
    with virtual_arm(profile):
        arm = CanopenBackend(profile)
        arm.open()
        try:
            arm.profile = profile.model_copy(update={"simulation": None})  # as if it were real
            with pytest.raises(BackendFault) as caught:
                arm.begin_enable()
            assert caught.value.kind == "unaccepted_risk"
            lines = caught.value.cause.split("\n")
            assert [line.split(":")[0] for line in lines] == ["joints 2 and 3"]  # alike
            assert caught.value.axes == (1, 2)
            accepting = {"accepted_risks": ["unknown_reaction"]}
            arm.drives = [drive.model_copy(update=accepting) for drive in arm.drives]
            by_hand.enable(arm)
            by_hand.disable(arm)
        finally:
            arm.close()


class Entries:
    """0x1016 of a drive, as far as it is asked."""

    def __init__(self, *entries: int) -> None:
        self.values = [len(entries), *entries]

    def read(self, index: int, sub: int = 0) -> int | None:
        assert index == 0x1016
        return self.values[sub] if sub < len(self.values) else None

    def write(self, index: int, value: int, sub: int = 0) -> str | None:
        assert index == 0x1016
        if sub >= len(self.values):
            return "absent"
        self.values[sub] = value
        return None


STOP_MODULE, OURS, OLD = 5 << 16 | 300, 127 << 16 | 250, 127 << 16 | 900


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ([0, 0], [OURS, 0]),
        ([STOP_MODULE, 0], [STOP_MODULE, OURS]),
        ([OLD, STOP_MODULE], [OURS, STOP_MODULE]),
        ([STOP_MODULE, OLD], [STOP_MODULE, OURS]),
        ([OLD, OLD], [OURS, 0]),
        ([5 << 16, 0], [OURS, 0]),
    ],
    ids=["none", "another's", "ours, another's", "another's, ours", "twice ours", "switched off"],
)
def test_whom_else_a_drive_watches_it_goes_on_to_watch(before: list[int], after: list[int]) -> None:
    """The module of an emergency stop stood in the first entry, which ours took."""
    drive = Entries(*before)
    assert lifeline._watch(drive, 127, 250) is None  # type: ignore[arg-type]
    assert drive.values[1:] == after


def test_a_drive_that_can_watch_nobody_else_is_no_go_and_says_whom() -> None:
    drive = Entries(STOP_MODULE)
    said = lifeline._watch(drive, 127, 250)  # type: ignore[arg-type]
    assert drive.values[1:] == [STOP_MODULE]
    assert said is not None
    assert "node 5" in said
    assert lifeline._watch(Entries(), 127, 250) == "absent"  # type: ignore[arg-type]
