"""Objects the backend uses in a drive, and what it means for safety where one is lacking."""

from __future__ import annotations

import canopen

ESSENTIAL = {
    0x6040: "Controlword",
    0x6041: "Statusword",
    0x6060: "Modes of operation",
    0x6064: "Position actual value",
    0x6071: "Target torque",
    0x6077: "Torque actual value",
}

# index -> (name, what its absence means)
WANTED = {
    0x1006: (
        "Communication cycle period",
        "the drive does not notice when SYNC stays away",
    ),
    0x1029: (
        "Error behaviour",
        "whether the drive leaves OPERATIONAL after a communication error is up to its maker",
    ),
    0x605A: (
        "Quick stop option code",
        "how the drive brakes on a quick stop, and whether it lets go afterwards, is fixed",
    ),
    0x605C: (
        "Disable operation option code",
        "the drive may let go before its brake has closed: the arm can sag on disable",
    ),
    0x605E: (
        "Fault reaction option code",
        "how the drive comes to rest on a fault is fixed: it may coast instead of braking, or "
        "brake along a ramp, which drives a joint on whose torque acts the wrong way round",
    ),
    0x603F: ("Error code", "a fault without EMCY cannot be named"),
    0x6061: (
        "Modes of operation display",
        "whether the drive takes the command for a torque shows only in what it does",
    ),
    0x6072: (
        "Max torque",
        "the torque limit holds in pa10d only, not in the drive",
    ),
    0x607D: (
        "Software position limit",
        "the position limit holds in pa10d only, not in the drive",
    ),
    0x6080: (
        "Max motor speed",
        "the speed limit holds in pa10d only; while pa10d is kept from its work nothing limits it",
    ),
    0x6085: ("Quick stop deceleration", "how hard a quick stop brakes is up to the drive"),
    0x60C2: (
        "Interpolation time period",
        "the drive cannot be told the cycle time",
    ),
}

# the drive notices that the control PC died, and stops: see lifeline.py
LIFELINE = {
    0x1016: (
        "Consumer heartbeat time",
        "the drive does not notice when the control PC dies and keeps its last torque",
    ),
    0x1017: (
        "Producer heartbeat time",
        "a drive that hangs shows only by missing PDOs",
    ),
    0x6007: (
        "Abort connection option code",
        "what the drive does when communication is lost cannot be chosen: ask its maker",
    ),
}

# what is compared with the profile where the drive tells it
COMPARED = {
    0x6076: (
        "Motor rated torque",
        "the unit of torque cannot be compared with the profile: a wrong one moves the arm wrongly",
    ),
    0x608F: (
        "Position encoder resolution",
        "counts_per_rev cannot be compared with the drive: turn the joint by a known angle",
    ),
}

# SDO aborts: no such object, no such sub-index, no value there, no data at the moment
ABSENT = (0x06020000, 0x06090011, 0x060A0023, 0x08000024)


def declared(node: canopen.RemoteNode, index: int) -> bool:
    """Whether the EDS knows the object."""
    return index in node.object_dictionary


def lack(index: int) -> str:
    """One line about a lacking object."""
    name, meaning = (LIFELINE | WANTED | COMPARED)[index]
    return f"no {name} (0x{index:04X}): {meaning}"
