"""Nodes made from the files of drives that exist; whoever imports this is skipped without them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count
from pathlib import Path

import canopen
import pytest

from backends.canopen_cia402.configure import Wish
from backends.eds import load_eds
from backends.limits import AxisLimits
from backends.scaling import scaling_of
from pa10d.profile import Drive

EDS = Path(__file__).parents[3] / "shared" / "pa10" / "eds"
EPOS4 = EDS / "maxon_epos4_50_15_can_node1.dcf"
EROB = EDS / "zeroerr_erob_V1.5.eds"
GENERIC = EDS / "cia402_profile_kacanopen.eds"
EPOS4_RATED = 0.512871  # N·m, 512871 µN·m

if not EDS.is_dir():
    pytest.skip("the makers' EDS files are not here", allow_module_level=True)

_number = count()
Frozen = tuple[tuple[int, int], ...]


@contextmanager
def node_made_from(
    eds: Path, frozen: Frozen = (), other_mode: bool = False, **values: int
) -> Iterator[canopen.RemoteNode]:
    """canopen's own LocalNode with that dictionary, seen over canopen's own network.

    ``values``: x6076=… as it comes; ``frozen``: objects (index, sub-index) that keep their first
    values whatever is written; ``other_mode``: 0x6061 does not follow 0x6060.
    """
    here, there = canopen.Network(), canopen.Network()
    channel = f"real-{eds.name}-{next(_number)}"
    for network in (here, there):
        network.NOTIFIER_CYCLE = 0.02
        network.connect(interface="virtual", channel=channel)
    try:
        local = there.create_node(5, load_eds(eds, 5))

        for name, value in values.items():
            index = int(name[1:], 16)
            size = len(local.object_dictionary[index]) // 8
            local.set_data(index, 0, value.to_bytes(size, "little"))
        _behave(local, frozen, other_mode)
        node = here.add_node(5, load_eds(eds, 5))
        node.sdo.RESPONSE_TIMEOUT = 5.0  # s: a busy machine answers late
        yield node
    finally:
        here.disconnect()
        there.disconnect()


def _behave(local: canopen.LocalNode, frozen: Frozen, other_mode: bool) -> None:
    """Obey 0x6060, and take writes to frozen objects without keeping them, as some drives do."""
    store = local.set_data

    def set_data(index: int, subindex: int, data: bytes, check_writable: bool = False) -> None:
        known = subindex in local.data_store.get(index, {})
        if (index, subindex) in frozen and known:
            return
        store(index, subindex, data, check_writable)
        if index == 0x6060 and not other_mode:
            store(0x6061, 0, bytes(data))

    local.set_data = set_data


def wish(rated: float = 1.0, bitrate: int = 1_000_000) -> Wish:
    drive = Drive(node=5, counts_per_rev=524288, rated_torque=rated)
    limits = AxisLimits(-3.0, 3.0, 2.0, 10.0, rated)
    return Wish(drive, scaling_of(drive), limits, 0.002, bitrate, master=127, silence_ms=250)
