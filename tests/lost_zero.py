"""A virtual arm whose drives can be given another zero while nobody hears them."""

from __future__ import annotations

import os
import struct

import can

from backends.virtual.drives.injection import Injection
from pa10d.profile import load_profile

COUNTS = load_profile("pa10-sim").drives[2].counts_per_rev
CHANNEL = f"zero-{os.getpid()}"


def turn(node: int, radians: float, channel: str = CHANNEL) -> None:
    """The encoder of a drive reads so much more from now on."""
    counts = round(radians * COUNTS / 6.283185307179586)
    with can.Bus(interface="virtualbus", channel=channel) as bus:
        for sub, value in ((2, counts), (1, int(Injection.ENCODER_JUMP))):
            head = 0x23 if sub == 2 else 0x2F
            data = struct.pack("<BHBi", head, 0x2F00, sub, value)
            bus.send(can.Message(arbitration_id=0x600 + node, data=data, is_extended_id=False))
            while (answer := bus.recv(2.0)) is not None:
                if answer.arbitration_id == 0x580 + node:
                    break
            assert answer is not None
            assert answer.data[0] == 0x60
