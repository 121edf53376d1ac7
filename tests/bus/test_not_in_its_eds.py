"""A drive obeys what it has, not what a file says of it: EDS files that are cut short, of another
size, or written by Windows."""

from __future__ import annotations

from pathlib import Path

import pytest
from canopen import RemoteNode, SdoAbortedError, SdoCommunicationError
from canopen.objectdictionary import UNSIGNED8, UNSIGNED16
from makers_eds import EPOS4, EPOS4_RATED, EROB, GENERIC, node_made_from, wish

from backends.canopen_cia402.configure import configure
from backends.canopen_cia402.network import PortNetwork
from backends.canopen_cia402.remote import NO_ANSWER, SetupError
from backends.eds import load_eds

CIA_402 = {"x1000": 0x00020192, "x6502": 0x200}


def forget(node: RemoteNode, *indices: int) -> None:
    """As if the EDS had none of them."""
    for index in indices:
        del node.object_dictionary[index]


@pytest.mark.parametrize(
    ("index", "value", "text"),
    [
        (0x607E, 0xC0, r"Polarity \(0x607E\): found 0xC0"),
        (0x6091, 100, r"Gear ratio \(0x6091\): found 100:1"),
        (0x6502, 0x81, "the drive offers profile position"),
    ],
)
def test_what_its_eds_leaves_out_is_compared_all_the_same(
    index: int, value: int, text: str
) -> None:
    plain = {f"x{index:04X}": value} if index != 0x6091 else {}
    with node_made_from(GENERIC, **CIA_402 | plain) as node:
        if index == 0x6091:
            node.sdo[0x6091][1].raw, node.sdo[0x6091][2].raw = value, 1
        forget(node, index)
        with pytest.raises(SetupError, match=text):
            configure(node, wish())


def test_what_its_eds_leaves_out_is_set_all_the_same() -> None:
    with node_made_from(EPOS4, x60B2=300, x6007=0) as node:
        wanted = {0x60B2: 0, 0x6007: 1, 0x605E: 0}
        variables = {index: node.sdo[index] for index in wanted}
        node.sdo[0x1403][1].raw = 0x385  # another drive's feedback
        other = node.sdo[0x1403][1]
        forget(node, *wanted, 0x1403)
        report = configure(node, wish(EPOS4_RATED))
        assert {index: variable.raw for index, variable in variables.items()} == wanted
        assert other.raw == 0x80000385
    assert report.risks == {}
    assert report.has_reaction
    lacks = "\n".join(report.lacks)
    assert not [index for index in wanted if f"0x{index:04X}" in lacks]
    assert (0x60B2, 0) in report.fixed, "and looked after while the arm is held"


def test_what_cannot_be_mended_stays_refused() -> None:
    with node_made_from(EPOS4, frozen=((0x60B2, 0),), x60B2=300) as node:
        forget(node, 0x60B2)
        with pytest.raises(SetupError, match=r"Torque offset \(0x60B2\): expected 0, found 300"):
            configure(node, wish(EPOS4_RATED))


def test_whatever_a_drive_answers_about_what_it_has_not(monkeypatch: pytest.MonkeyPatch) -> None:
    with node_made_from(EROB) as node:
        ask = node.sdo.upload

        def upload(index: int, sub: int) -> bytes:
            if index not in node.object_dictionary:
                raise SdoAbortedError(0x08000000)  # "general error"
            return ask(index, sub)

        monkeypatch.setattr(node.sdo, "upload", upload)
        report = configure(node, wish())
    assert "unknown_reaction" in report.risks
    assert "no Abort connection option code (0x6007)" in "\n".join(report.lacks)


def test_a_drive_that_says_nothing_about_what_it_has_not_is_asked_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with node_made_from(EROB) as node:
        ask, asked = node.sdo.upload, []

        def upload(index: int, sub: int) -> bytes:
            if index not in node.object_dictionary:
                asked.append(index)
                raise SdoCommunicationError(NO_ANSWER)
            return ask(index, sub)

        monkeypatch.setattr(node.sdo, "upload", upload)
        report = configure(node, wish())
    assert len(asked) == 1, "each takes three seconds"
    assert "unknown_reaction" in report.risks


def test_a_drive_knows_its_sizes() -> None:
    with node_made_from(GENERIC, **CIA_402, x607E=0xC0) as node:
        node.object_dictionary[0x607E].data_type = UNSIGNED16
        with pytest.raises(SetupError, match=r"Polarity \(0x607E\): found 0xC0"):
            configure(node, wish())
    with node_made_from(EROB) as node:
        node.object_dictionary[0x1006].data_type = UNSIGNED8
        lacks = "\n".join(configure(node, wish()).lacks)
    assert "Communication cycle period (0x1006): by its EDS it has 1 bytes, 2000 needs" in lacks


def test_less_torque_than_is_asked_for_is_refused() -> None:
    """Under 5 % of its torque the joint would sink as its brake opens."""
    with (
        node_made_from(GENERIC, ((0x6072, 0),), **CIA_402, x6072=50) as node,
        pytest.raises(SetupError, match=r"keeps 50 ‰ .* at most 0\.05 N·m in limits\.torque"),
    ):
        configure(node, wish())


@pytest.mark.parametrize("encoding", ["cp1252", "utf-8-sig", "utf-16"])
def test_files_written_by_windows(tmp_path: Path, encoding: str) -> None:
    text = EROB.read_text(errors="replace")
    path = tmp_path / "drive.eds"
    path.write_bytes(
        text.replace("ParameterName=", "ParameterName=µ ", 1).encode(encoding, "replace")
    )
    assert load_eds(path, 5)[0x6071].data_type == load_eds(EROB, 5)[0x6071].data_type


def test_half_of_a_pdo_is_none(tmp_path: Path) -> None:
    path = tmp_path / "drive.eds"
    path.write_text(EROB.read_text(errors="replace").replace("[1601", "[2601"))
    found = load_eds(path, 5)
    assert 0x1401 not in found
    PortNetwork(None).add_drive(5, found)  # type: ignore[arg-type]
