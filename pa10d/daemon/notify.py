"""systemd's notification protocol (sd_notify(3)): a datagram to the socket it names."""

from __future__ import annotations

import contextlib
import os
import socket


def notify(*assignments: str) -> bool:
    """Send ``READY=1`` and the like; False where no service manager listens."""
    address = os.environ.get("NOTIFY_SOCKET", "")
    if not address:
        return False
    name = "\0" + address[1:] if address.startswith("@") else address
    with contextlib.suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sock:
        sock.sendto("\n".join(assignments).encode(), name)
        return True
    return False


def watchdog_period() -> float | None:
    """Seconds between signs of life, half of what systemd waits; None: it does not watch."""
    microseconds = os.environ.get("WATCHDOG_USEC", "")
    meant = os.environ.get("WATCHDOG_PID", "") in ("", str(os.getpid()))
    return float(microseconds) * 0.5e-6 if microseconds.isdigit() and meant else None
