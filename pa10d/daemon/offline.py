"""Why an arm is offline: what passes by itself, and what somebody has to change."""

from __future__ import annotations

STARTING = "the control process is starting"
RENEWED = "control is being started anew, with the profile as it is now"
AGAIN = "it is being started again"  # after: the control process ended so and so
LEFT = "disconnected on request"
SLOW = "the virtual arm is not there yet; a slow machine may have to compile it for minutes"


def passes(reason: str | None) -> bool:
    """Is it the daemon's own doing, that needs nothing but time?"""
    return reason is None or reason in (STARTING, RENEWED, SLOW) or reason.endswith(AGAIN)
