"""A drive with a past: cleared where that is ours to do, refused where it changes a meaning."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from bus_helpers import Driver, make_profile, running, second_master, virtual_arm
from canopen import RemoteNode
from makers_eds import EPOS4, EPOS4_RATED, EROB, GENERIC, node_made_from, wish

from backends import by_hand
from backends.canopen_cia402.backend import CanopenBackend
from backends.canopen_cia402.configure import configure
from backends.canopen_cia402.remote import SetupError
from backends.cia402 import remarks
from backends.protocol import BackendFault
from pa10d.profile import Profile

CIA_402 = {"x1000": 0x00020192, "x6502": 0x200}


@pytest.fixture
def profile(tmp_path: Path) -> Iterator[Profile]:
    made = make_profile(tmp_path, 3)
    with virtual_arm(made):
        yield made


# --- on the bus, with the package's own drives ---


def test_what_an_earlier_master_left_is_cleared(profile: Profile) -> None:
    with second_master(profile, 1) as node:
        node.sdo[0x60B2].raw = 300
        node.sdo[0x60B0].raw, node.sdo[0x60B1].raw = 5, 6
    arm = CanopenBackend(profile)
    arm.open()
    try:
        driver = Driver(arm)
        by_hand.enable(arm, driver.hold)
        assert np.abs(driver.run(1.0).tau).max() < 40.0, "600 ‰ of 100 N·m nobody asked for"
    finally:
        arm.close()
    with second_master(profile, 1) as node:
        assert [node.sdo[index].raw for index in (0x60B0, 0x60B1, 0x60B2)] == [0, 0, 0]


def test_all_joints_are_refused_at_once_each_in_a_line(profile: Profile) -> None:
    pasts = [(0x607E, 0, 0xC0), (0x6091, 1, 100), (0x608F, 1, 4096)]
    for axis, (index, sub, value) in enumerate(pasts):
        with second_master(profile, axis) as node:
            (node.sdo[index][sub] if sub else node.sdo[index]).raw = value
    arm = CanopenBackend(profile)
    with pytest.raises(BackendFault) as caught:
        arm.open()
    lines = caught.value.cause.split("\n")
    assert [line[:17] for line in lines] == [f"joint {k + 1}: node {10 + k}:" for k in range(3)]
    assert "Polarity (0x607E): found 0xC0, the drive turns position, velocity" in lines[0]
    assert "Gear ratio (0x6091): found 100:1, profile gear_ratio has 50" in lines[1]
    assert "Encoder resolution (0x608F): found 4096:1" in lines[2]
    assert "204800 to one of the joint, profile counts_per_rev has 819200" in lines[2]
    assert caught.value.kind == "setup"


@pytest.mark.long
def test_one_refused_joint_is_named_as_ever(profile: Profile) -> None:
    with second_master(profile, 2) as node:
        node.sdo[0x607E].raw = 0x80
    with pytest.raises(BackendFault, match=r"joint 3: node 12: Polarity") as caught:
        CanopenBackend(profile).open()
    assert caught.value.axis == 2


@pytest.mark.parametrize("shown", ["fast", pytest.param("slow", marks=pytest.mark.long)])
def test_a_changed_mode_is_seen_while_it_moves(profile: Profile, shown: str) -> None:
    """At once by bit 12; where a drive has none, by the mode that it shows."""
    with running(profile) as (arm, driver, other):
        if shown == "slow":
            arm._watch._followed = [False] * 3
            arm._watch._check_following = lambda axis, enabled: None  # type: ignore[method-assign]
        else:
            arm._poll._questions, arm._poll._shows_mode = [], [False] * 3
        other.sdo(1, "2F 60 60 00", 0)
        with pytest.raises(BackendFault) as caught:
            driver.run(3.0)
        assert caught.value.axis == 1
        kind = "not_following" if shown == "fast" else "other_mode"
        assert caught.value.kind == kind
        assert f"`{kind}`" in (Path(__file__).parents[2] / "docs" / "faults.md").read_text()
        arm.quick_stop()
        driver.run_on(1.0)
        by_hand.reset(arm)  # the mode is chosen anew
        by_hand.enable(arm, driver.hold)
        driver.run(0.3)


def test_warning_and_limit_are_remarks() -> None:
    enabled = 0x1637
    assert remarks(enabled) == []
    assert [text.split(":")[0] for text in remarks(enabled | 0x80)] == [
        "its drive warns (bit 7 of the statusword)"
    ]
    assert "bit 11" in remarks(enabled | 0x800)[0]
    assert remarks(0x0250 | 0x800) == [], "an unpowered drive limits nothing"


# --- with the makers' own dictionaries ---


def offsets(node: RemoteNode) -> list[int]:
    return [node.sdo[index].raw for index in (0x60B0, 0x60B1, 0x60B2)]


@pytest.mark.parametrize(("eds", "rated"), [(EPOS4, EPOS4_RATED), (EROB, 1.0)])
def test_offsets_and_timers_of_real_drives(eds: Path, rated: float) -> None:
    with node_made_from(eds, x60B0=7, x60B1=8, x60B2=300) as node:
        node.sdo[0x1800][3].raw = 1000  # 100 ms
        if eds == EROB:
            node.sdo[0x1800][5].raw = node.sdo[0x1400][5].raw = 50
        configure(node, wish(rated))
        assert offsets(node) == [0, 0, 0]
        assert node.sdo[0x1800][3].raw == 0
        if eds == EROB:
            assert node.sdo[0x1800][5].raw == node.sdo[0x1400][5].raw == 0


def test_an_offset_that_stays_is_refused() -> None:
    with (
        node_made_from(EPOS4, frozen=((0x60B2, 0),), x60B2=300) as node,
        pytest.raises(SetupError, match=r"Torque offset \(0x60B2\): expected 0, found 300"),
    ):
        configure(node, wish(EPOS4_RATED))


def test_nothing_is_written_to_a_drive_that_is_refused() -> None:
    with node_made_from(EPOS4, x60B2=300) as node:
        with pytest.raises(SetupError, match="0x6076"):
            configure(node, wish(4.64))
        assert node.sdo[0x60B2].raw == 300


def test_the_rated_torque_of_a_small_motor_is_told_in_few_units() -> None:
    with node_made_from(EROB, x6076=17) as node:  # mN·m
        configure(node, wish(0.0174))
        with pytest.raises(SetupError, match=r"0x6076.*found 0\.017 N·m, profile has 0\.0181"):
            configure(node, wish(0.0181))


def test_an_inhibit_time_that_stays_is_refused() -> None:
    with node_made_from(EROB, frozen=((0x1800, 3),)) as node:
        node.sdo[0x1800][3].raw = 1000
        with pytest.raises(SetupError, match=r"inhibit time \(0x1800:3\) stays at 1000"):
            configure(node, wish())


@pytest.mark.parametrize("value", [0x80, 0x40, 0xC0])
def test_polarity(value: int) -> None:
    with (
        node_made_from(GENERIC, **CIA_402, x607E=value) as node,
        pytest.raises(SetupError, match=f"Polarity .* found 0x{value:02X}"),
    ):
        configure(node, wish())


@pytest.mark.parametrize(
    ("encoder", "gear", "feed", "counts", "ratio", "text"),
    [
        ((10486, 1), (1, 1), None, 524300, 50.0, None),  # the motor's encoder, gear unknown to it
        ((16384, 1), (50, 1), (819200, 1), 819200, 50.0, None),  # the shaft is the joint
        ((16384, 1), (1, 1), (16384, 1), 819200, 50.0, None),
        ((16384, 1), (50, 1), None, 819200, 50.0, None),
        ((16384, 1), (127, 4), None, 16384 * 31.75, 31.75, None),
        ((16384, 1), (1, 1), None, 819201, 50.0, None),  # as exact as a person writes it
        ((1, 1), (1, 1), None, 819200, 50.0, None),  # nobody filled it in
        ((4096, 1), (1, 1), None, 819200, 50.0, r"0x608F\): found 4096:1 .* 204800 to one of the"),
        ((16384, 1), (100, 1), None, 819200, 50.0, r"Gear ratio \(0x6091\): found 100:1"),
        ((16384, 1), (50, 1), (1000, 1), 819200, 50.0, r"Feed \(0x6092\): found 1000:1"),
        ((16384, 1), (1, 1), (360000, 1), 819200, 50.0, r"Feed .* 1.8e\+07 to one of the joint"),
    ],
)
def test_counts_gear_and_feed(
    encoder: tuple[int, int],
    gear: tuple[int, int],
    feed: tuple[int, int] | None,
    counts: float,
    ratio: float,
    text: str | None,
) -> None:
    asked = wish()
    drive = asked.drive.model_copy(update={"counts_per_rev": counts, "gear_ratio": ratio})
    with node_made_from(GENERIC, **CIA_402) as node:
        for index, pair in ((0x608F, encoder), (0x6091, gear), (0x6092, feed or (1, 1))):
            node.sdo[index][1].raw, node.sdo[index][2].raw = pair
        if text is None:
            report = configure(node, replace(asked, drive=drive))
            assert ("0x608F" in "\n".join(report.lacks)) == (encoder == (1, 1))
        else:
            with pytest.raises(SetupError, match=text):
                configure(node, replace(asked, drive=drive))


def test_what_a_drive_does_not_have_is_not_missed_but_told() -> None:
    with node_made_from(EROB) as node:
        lacks = "\n".join(configure(node, wish()).lacks)
    assert "no Position encoder resolution (0x608F): counts_per_rev cannot be compared" in lacks
    assert "0x607E" not in lacks


def test_a_drive_that_does_not_say_its_modes_is_asked() -> None:
    with node_made_from(GENERIC, x1000=0x00020192) as node:
        configure(node, wish())
        assert node.sdo[0x6061].raw == 10
    with (
        node_made_from(GENERIC, x1000=0x00020192, x6061=1, other_mode=True) as node,
        pytest.raises(SetupError, match="torque not accepted: 0x6060 written, 0x6061 shows 1"),
    ):
        configure(node, wish())


def test_sync_that_a_drive_has_elsewhere_is_ours_again() -> None:
    with node_made_from(EROB, x1005=0x40000081) as node:
        configure(node, wish())
        assert node.sdo[0x1005].raw == 0x80
    with (
        node_made_from(EROB, frozen=((0x1005, 0),), x1005=0x81) as node,
        pytest.raises(SetupError, match=r"COB-ID SYNC \(0x1005\): expected 0x80, found 129"),
    ):
        configure(node, wish())


# --- what else an earlier master may have left ---


def test_limits_watches_and_pdos_of_an_earlier_master(profile: Profile) -> None:
    """5 % of the torque to one side would let the arm sink; the same heartbeat watched twice is
    refused by the drive."""
    assert profile.drives is not None
    with second_master(profile, 1) as node:
        node.sdo[0x60E0].raw = node.sdo[0x60E1].raw = 50
    arm = CanopenBackend(profile)
    arm.open()
    try:
        driver = Driver(arm)
        by_hand.enable(arm, driver.hold)
        driver.run(0.3)
    finally:
        arm.close()
    with second_master(profile, 1) as node:
        most = node.sdo[0x6072].raw
        assert [node.sdo[0x60E0].raw, node.sdo[0x60E1].raw] == [most, most]


@pytest.mark.long
def test_a_sync_counter_of_an_earlier_master_is_taken_away(profile: Profile) -> None:
    """A drive changes it only while it has no communication cycle period (CiA 301)."""
    with second_master(profile, 1) as node:
        node.sdo[0x1019].raw, node.sdo[0x1006].raw = 40, 5000
    arm = CanopenBackend(profile)
    arm.open()
    try:
        by_hand.enable(arm, Driver(arm).hold)
    finally:
        arm.close()
    with second_master(profile, 1) as node:
        assert node.sdo[0x1019].raw == 0


def test_an_older_watch_on_our_heartbeat_gives_way() -> None:
    with node_made_from(EPOS4) as node:
        node.sdo[0x1016][2].raw = 127 << 16 | 9000
        assert configure(node, wish(EPOS4_RATED)).risks == {}
        assert [node.sdo[0x1016][k].raw for k in (1, 2)] == [127 << 16 | 250, 0]


def test_a_pdo_that_cannot_be_silenced_is_refused() -> None:
    with node_made_from(EROB, frozen=((0x1402, 1),)) as node:
        node.sdo[0x1402][1].raw = 0x405
        with pytest.raises(SetupError, match=r"RPDO 3 \(0x1402\) stays on"):
            configure(node, wish())


def test_every_pdo_is_silenced_however_many_there_are(tmp_path: Path) -> None:
    node_with = tmp_path / "many.eds"
    text = EROB.read_text(errors="replace")
    records = re.findall(r"(?ms)^\[1[46]03(?:sub\d+)?\].*?(?=^\[|\Z)", text)
    node_with.write_text(text + "\n" + re.sub(r"(?m)^\[(1[46])03", r"[\g<1>07", "".join(records)))
    with node_made_from(node_with) as node:
        node.sdo[0x1407][1].raw = 0x385  # another drive's feedback, say
        configure(node, wish())
        assert node.sdo[0x1407][1].raw == 0x80000385


def test_a_window_in_which_commands_count_is_opened(tmp_path: Path) -> None:
    with_window = tmp_path / "window.eds"
    more = "\n[1007]\nParameterName=Window\nObjectType=0x7\nDataType=0x0007\nAccessType=rw\n"
    with_window.write_text(EROB.read_text(errors="replace") + more + "DefaultValue=0\n")
    with node_made_from(with_window, x1007=100) as node:
        configure(node, wish())
        assert node.sdo[0x1007].raw == 0
    with (
        node_made_from(with_window, frozen=((0x1007, 0),), x1007=100) as node,
        pytest.raises(SetupError, match=r"window length \(0x1007\): expected 0, found 100"),
    ):
        configure(node, wish())


def test_emergencies_that_nobody_hears_are_told() -> None:
    with node_made_from(EROB, x1014=0x80000085) as node:
        lacks = "\n".join(configure(node, wish()).lacks)
    assert "COB-ID EMCY (0x1014): expected 0x85, found" in lacks


@pytest.mark.parametrize(
    ("low", "high", "refused"),
    [(0, 0, False), (-(2**31), 2**31 - 1, False), (0, 524287, True), (-250000, 10**6, True)],
)
def test_a_position_that_runs_over_on_the_way_is_refused(
    low: int, high: int, refused: bool
) -> None:
    """±3 rad are ±250 332 counts."""
    with node_made_from(EPOS4) as node:
        node.sdo[0x607B][1].raw, node.sdo[0x607B][2].raw = low, high
        if refused:
            with pytest.raises(SetupError, match=r"Position range limit \(0x607B\): found"):
                configure(node, wish(EPOS4_RATED))
        else:
            configure(node, wish(EPOS4_RATED))
