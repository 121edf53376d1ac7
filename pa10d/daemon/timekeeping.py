"""Does this machine keep the rate that a virtual arm in real time wants? Asked before it starts."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pa10d.control.clock import Clock
from pa10d.profile import Profile

SECONDS = 0.4  # of a bare loop: what it cannot do, the whole one cannot either
RARE = 0.95  # of the cycles shall come within half a period


def kept_time(
    profile: Profile, delays: Callable[[float, float], np.ndarray] | None = None
) -> tuple[Profile, str | None]:
    """The profile, in simulated time where this machine is too slow for real time, and the line
    that says so. Real drives are never changed, ``check`` tells of them; nor is a virtual arm on a
    real bus, where others may count on real time."""
    simulation = profile.simulation
    alone = profile.can.interface == "virtualbus"
    if simulation is None or simulation.clock != "real" or not alone:
        return profile, None
    period = 1.0 / profile.control.rate
    usual = float(np.quantile((delays or _bare_loop)(period, SECONDS), RARE))
    if usual <= 0.5 * period:
        return profile, None
    said = (
        f"simulated time: this machine does not keep {profile.control.rate:g} Hz (one cycle in "
        f"twenty of a bare loop came {1e3 * usual:.1f} ms late); --clock real insists"
    )
    changed = simulation.model_copy(update={"clock": "simulated"})
    return profile.model_copy(update={"simulation": changed}), said


def _bare_loop(period: float, seconds: float) -> np.ndarray:
    """s by which each cycle of a loop that does nothing came late; given-up deadlines count."""
    late: list[float] = []
    clock, missed = Clock(period), 0
    while len(late) * period < seconds:
        clock.wait(paced=True)
        late.append(clock.late + (clock.missed - missed) * period)
        missed = clock.missed
        clock.done()
    return np.array(late)
