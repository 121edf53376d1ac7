"""Every fault a backend names, and what to check first. docs/faults.md says more about each."""

from __future__ import annotations

from backends.protocol import BackendFault
from pa10d.common.words import joint_words

REMEDIES = {
    "no_answer": "power of that drive, its node id and bitrate, the cable and both terminators",
    "setup": "the drive's own configuration and EDS against the profile",
    "silent": "power of that drive and its cable; whether other axes lost PDOs too",
    "rebooted": "supply voltage of that drive under load (brown-out), its connector",
    "not_operational": "who else sends NMT commands; the drive's error history 0x1003",
    "heartbeat_lost": "the drive's firmware and bus load: it still sends PDOs but no heartbeat",
    "emcy": "the drive's manual for this code; its error history 0x1003",
    "drive_fault": "the drive's error code 0x603F and history 0x1003",
    "not_following": "its mode 0x6061, its limit and inhibit inputs, other masters on the bus",
    "other_mode": "who else commands this drive: service tools, another master",
    "altered": "who else writes to this drive: service tools, another master; reset sets it anew",
    "left_enabled": "safe-torque-off and enable inputs, the emergency stop, another bus master",
    "short_pdo": "who changed the drive's PDO mapping; start again to configure it anew",
    "repeated_pdo": "two nodes with the same id, or a TPDO that is not of transmission type 1",
    "encoder_jump": "encoder cable, shielding and supply; compare the angle with the arm",
    "queue_full": "bus load, a stopped process on the bus, whether anything acknowledges frames",
    "receive_overflow": "processor load of this machine: the loop did not read for a while",
    "bus_error": "cable, terminators (60 ohm between the lines), one bitrate for all nodes",
    "interface_down": "the CAN adapter and its cable; 'ip link show' of the interface",
    "brake_gave": "this joint's brake; whether brakes that hang on one output open together",
    "timeout": "the drive's statusword and inputs: supply, safe-torque-off, brake supply",
    "torque": "the controller: it asked for something that is not a number",
    "unaccepted_risk": "what the drive does when the control PC dies; ask its maker",
    "brake_output": "0x60FE of that drive: what its outputs are configured for",
    "bus_taken": "which program that is ('pa10d serve', 'pa10d check'); end it, or use it",
    "foreign_master": "other control PCs, service tools and gateways; a drive that produces SYNC",
    "ended": "nothing: the recording is over",
}


def fault(kind: str, cause: str, axis: int | None = None) -> BackendFault:
    """A named fault; a person sees joints counted from 1."""
    text = cause if axis is None else f"joint {axis + 1}: {cause}"
    return BackendFault(text, axis=axis, remedy=f"check {REMEDIES[kind]}", kind=kind)


def refusal(kind: str, causes: dict[int, str]) -> BackendFault:
    """One fault for all axes that have a cause: who mends one wants to know of the others. A
    cause that several share is said once."""
    first, *others = causes
    sharing: dict[str, list[int]] = {}
    for axis, cause in causes.items():
        sharing.setdefault(cause, []).append(axis)
    lines = [f"{joint_words(axes)}: {cause}" for cause, axes in sharing.items()]
    found = fault(kind, "\n".join(lines) if others else causes[first], None if others else first)
    found.axes = tuple(causes)
    return found


# CiA 301 and CiA 402 error codes of EMCY and 0x603F, the most significant digits first
_CODES = {
    0x8130: "heartbeat of the control PC lost",
    0x8110: "CAN overrun, frames lost",
    0x8120: "CAN error passive",
    0x8140: "recovered from bus-off",
    0x8210: "RPDO not processed, too short",
    0x8220: "RPDO longer than mapped",
    0x8240: "SYNC of unexpected length",
    0x8250: "RPDO did not come in time",
    0x8611: "following error",
    0x8612: "position limit reached",
    0x8700: "SYNC missing",
    0x7305: "encoder failed",
    0x7300: "sensor",
    0x7100: "brake",
    0x7500: "communication inside the drive",
    0x6320: "parameter error",
    0x5112: "logic supply",
    0x4310: "drive too hot",
    0x4210: "device too hot",
    0x3210: "DC link overvoltage",
    0x3220: "DC link undervoltage",
    0x3310: "output overvoltage",
    0x2310: "overcurrent",
    0x2320: "short circuit or earth leak",
    0x2340: "short circuit",
    0x2350: "overload (I²t)",
}
_CLASSES = {
    0x1: "generic error",
    0x2: "current",
    0x3: "voltage",
    0x4: "temperature",
    0x5: "device hardware",
    0x6: "device software",
    0x7: "additional modules",
    0x8: "monitoring",
    0x9: "external error",
    0xF: "additional functions, see the drive's manual",
}


def describe_code(code: int) -> str:
    """An EMCY code in words, e.g. ``0x2310 (overcurrent)``."""
    for candidate in (code, code & 0xFFF0, code & 0xFF00):
        if candidate in _CODES:
            return f"0x{code:04X} ({_CODES[candidate]})"
    return f"0x{code:04X} ({_CLASSES.get(code >> 12, 'vendor specific')})"
