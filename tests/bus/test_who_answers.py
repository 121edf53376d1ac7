"""Two drives that answer for each other are refused before anything is powered."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest
from bus_helpers import make_profile, virtual_arm

from backends.canopen_cia402 import bring_up
from backends.canopen_cia402.backend import CanopenBackend
from backends.canopen_cia402.who_answers import require_own
from backends.protocol import BackendFault

OFF = 1 << 31


def exchanged(configure):
    """Set up as asked, and then each sends under the COB-ID of the other."""

    def wrongly(node, wish):
        report = configure(node, wish)
        for cob_id in (OFF, 0):
            other = 0x180 + (21 - node.id)
            node.sdo.download(0x1800, 1, struct.pack("<I", cob_id | other))
        return report

    return wrongly


@pytest.mark.by_default("False")
@pytest.mark.parametrize("crossed", [True, False])
def test_exchanged_cob_ids_are_named(tmp_path: Path, monkeypatch, crossed: bool) -> None:
    profile = make_profile(tmp_path, 2, each={1: {"zero_offset": 0.4}})
    if crossed:
        monkeypatch.setattr(bring_up, "configure", exchanged(bring_up.configure))
    with virtual_arm(profile):
        arm = CanopenBackend(profile)
        if not crossed:
            arm.open()
            arm.close()
            return
        with pytest.raises(BackendFault) as refused:
            arm.open()
    said = str(refused.value)
    assert "where node 11 stands: the drives answer for each other" in said
    assert "joint 1: node 10 stands at" in said
    assert "joint 2: node 11 stands at" in said


@pytest.mark.parametrize(
    ("told", "heard"),
    [
        ([0, 0, 900], [0, 0, 900]),
        ([0, 500, 900], [70, 500, 900]),  # pushed by hand meanwhile
        ([None, None, 900], [900, 0, 900]),  # do not tell by SDO
        ([0, 900, 900], [900, 900, 900]),  # two stand there
    ],
)
def test_who_answers_for_itself_or_leaves_a_doubt_is_not_refused(told, heard) -> None:
    require_own([1, 2, 3], told, heard, [10.0] * 3)
