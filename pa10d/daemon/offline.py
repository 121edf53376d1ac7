"""Why an arm is offline: what passes by itself, and what somebody has to change."""

from __future__ import annotations

STARTING = "the control process is starting"
RENEWED = "control is being started anew, with the profile as it is now"
AGAIN = "it is being started again"  # after: the control process ended so and so
LEFT = "disconnected on request"


def passes(reason: str | None) -> bool:
    """Is it the daemon's own doing, that needs nothing but time?"""
    return reason is None or reason in (STARTING, RENEWED) or reason.endswith(AGAIN)
