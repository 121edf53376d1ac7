"""Drives that exist: the backend against nodes made from their makers' own files."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from bus_helpers import Driver, make_profile, virtual_arm
from makers_eds import EPOS4, EPOS4_RATED, EROB, GENERIC, node_made_from, wish

from backends import by_hand
from backends.canopen_cia402.backend import CanopenBackend
from backends.canopen_cia402.configure import configure
from backends.canopen_cia402.remote import SetupError
from backends.cia402 import DriveState, state_of
from backends.protocol import BackendFault


def test_the_maxon_epos4() -> None:
    with node_made_from(EPOS4) as node:
        report = configure(node, wish(EPOS4_RATED))
        assert [node.sdo[0x1600][k + 1].raw for k in range(node.sdo[0x1600][0].raw)] == [
            0x60400010,
            0x60710010,
        ]
        assert [node.sdo[0x1A00][k + 1].raw for k in range(node.sdo[0x1A00][0].raw)] == [
            0x60640020,
            0x60770010,
            0x60410010,
        ]
        assert node.sdo[0x1400][2].raw == node.sdo[0x1800][2].raw == 1
        assert node.sdo[0x1016][1].raw == 127 << 16 | 250
        assert node.sdo[0x6060].raw == 10
    assert report.command.size == 4
    assert report.feedback.size == 8
    assert report.vendor == 0xFB
    assert "cyclic synchronous torque" in report.modes
    text = "\n".join(report.lacks)
    assert "no Communication cycle period (0x1006)" in text
    assert "does not notice when SYNC stays away" in text
    assert "no Max torque (0x6072)" in text
    assert "Max motor speed (0x6080) is left as it is" in text, "EPOS4: in velocity units"
    assert "0x1016" not in text, "an object that is there is not complained about"


def test_the_zeroerr_erob() -> None:
    with node_made_from(EROB, x6502=0x38D) as node:
        report = configure(node, wish())
    text = "\n".join(report.lacks)
    assert "no Abort connection option code (0x6007): what the drive does when" in text
    assert "no Quick stop option code (0x605A)" in text
    with (
        node_made_from(EROB, x6502=0x38D) as node,
        pytest.raises(SetupError, match="EDS allows 1000 kbit/s, the profile has 500"),
    ):
        configure(node, wish(bitrate=500_000))


def test_the_generic_profile_is_refused_and_every_reason_told() -> None:
    with node_made_from(GENERIC, x6502=0x81) as node, pytest.raises(SetupError) as caught:
        configure(node, wish())
    text = str(caught.value)
    assert "device type 0x00000000" in text
    assert "no cyclic synchronous torque mode (bit 9 of 0x6502" in text
    with node_made_from(GENERIC, x1000=0x00020192, x6502=0x2EF) as node:
        report = configure(node, wish())
    text = "\n".join(report.lacks)
    assert "no Consumer heartbeat time (0x1016): the drive does not notice when the control" in text
    assert "no Error behaviour (0x1029)" in text


def test_a_drive_without_torque_mode_is_refused_with_what_it_has() -> None:
    with (
        node_made_from(EROB, x6502=0x81) as node,
        pytest.raises(SetupError, match="offers profile position, cyclic synchronous position"),
    ):
        configure(node, wish())


def test_a_wrong_torque_unit_is_refused() -> None:
    with (
        node_made_from(EPOS4) as node,
        pytest.raises(SetupError, match=r"0x6076.*found 0\.512871 N·m, profile has 4\.64"),
    ):
        configure(node, wish(4.64))


def test_identity_is_compared() -> None:
    other = wish(EPOS4_RATED)
    other = replace(other, drive=other.drive.model_copy(update={"vendor_id": 0x9A}))
    with (
        node_made_from(EPOS4) as node,
        pytest.raises(SetupError, match=r"vendor .*found 0xFB, profile expects 0x9A"),
    ):
        configure(node, other)


@pytest.mark.by_default("eds2")
@pytest.mark.parametrize(
    ("eds", "rated"),
    [(EPOS4, EPOS4_RATED), pytest.param(EROB, 1.0, marks=pytest.mark.long), (GENERIC, 1.0)],
)
def test_a_virtual_drive_with_a_real_dictionary_lives(
    tmp_path: Path, eds: Path, rated: float
) -> None:
    """The whole way over the bus: boot, configure, enable, move, disable. What no file can know
    (the generic one has neither device type nor modes) is told as a drive tells it."""
    profile = make_profile(tmp_path, 2, drive={"eds": str(eds), "rated_torque": rated})
    with virtual_arm(profile):
        arm = CanopenBackend(profile)
        arm.open()
        try:
            assert any(line.startswith("joint 2: no ") for line in arm.warnings)
            driver = Driver(arm, amplitude=0.1)
            by_hand.enable(arm, driver.hold)
            assert {state_of(int(s)) for s in driver.run(0.5).status} == {DriveState.ENABLED}
            assert driver.reach > 0.01
            by_hand.disable(arm)
            assert {state_of(s) for s in arm.statuses()} == {DriveState.DISABLED}
        finally:
            arm.close()


SPEAKS = """
import sys
from pathlib import Path
from backends.eds import load_eds
from backends.ports import open_port
from pa10d.common.errors import UserError
from pa10d.profile import Can
for path in sys.argv[1:]:
    load_eds(Path(path), 5)
for interface in ("slcan", "pcan", "socketcan", "kvaser"):
    try:
        open_port(Can(interface=interface, channel="nowhere0"), "arm.yaml")
    except UserError as error:
        assert "cannot be opened" in str(error)
"""


def test_the_libraries_keep_their_remarks_to_themselves() -> None:
    files = [str(path) for path in (EPOS4, EROB, GENERIC)]
    done = subprocess.run(
        [sys.executable, "-c", SPEAKS, *files], capture_output=True, text=True, timeout=60
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_refusal_reaches_the_user_through_the_backend(tmp_path: Path) -> None:
    profile = make_profile(tmp_path, 2, drive={"vendor_id": 0xFB})
    with virtual_arm(profile):
        arm = CanopenBackend(profile)
        with pytest.raises(
            BackendFault, match=r"joint 1: node 10: vendor .*expects 0xFB"
        ) as caught:
            arm.open()
        assert caught.value.kind == "setup"
