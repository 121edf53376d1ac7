"""Who else commands on this bus: listened for before the first frame of our own."""

from __future__ import annotations

import time
from collections import Counter

from backends.canopen_cia402.bus_cycle import MASTER
from backends.faults import fault
from backends.frames import ERROR, REMOTE, frames
from backends.ports import Port, drain

NMT, SYNC, HEARTBEAT, COMMAND = 0x000, 0x080, 0x700 + MASTER, 0x200


def listen(port: Port, nodes: list[int], seconds: float) -> None:
    """BackendFault ``foreign_master`` where somebody commands within ``seconds``."""
    wanted = {
        NMT: "NMT commands (0x000)",
        SYNC: "SYNC (0x080)",
        HEARTBEAT: f"the heartbeat of node {MASTER}, which is ours (0x{HEARTBEAT:03X})",
    }
    wanted |= {
        COMMAND + node: f"commands to node {node} (0x{COMMAND + node:03X})" for node in nodes
    }
    drain(port)  # what an adapter had kept from before
    heard: Counter[str] = Counter()
    end = time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0:
        for can_id, _ in frames(port.receive(left)):
            if not can_id & (ERROR | REMOTE) and can_id in wanted:
                heard[wanted[can_id]] += 1
    if heard:
        what = ", ".join(f"{name} {count} times" for name, count in heard.most_common(3))
        raise fault(
            "foreign_master", f"somebody else commands on this bus: {what} in {seconds:g} s"
        )
