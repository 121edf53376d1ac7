"""Does this machine keep the rate that a loop in real time wants? Asked before it starts."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pa10d.control.clock import Clock
from pa10d.control.punctuality import RATES
from pa10d.profile import Profile
from pa10d.profile.profile import MOST_BANDWIDTH

Delays = Callable[[float, float], np.ndarray]
SECONDS = 0.4  # of a bare loop: what it cannot do, the whole one cannot either
RARE = 0.95  # of the cycles shall come within half a period


def kept_time(profile: Profile, delays: Delays | None = None) -> tuple[Profile, str | None]:
    """The profile, in simulated time where this machine is too slow for real time, and the line
    that says so. Real drives are never changed, nor is a virtual arm on a real bus, where others
    may count on real time: of them ``slower`` tells. Measured once: at a second look the machine
    may do better or worse."""
    simulation = profile.simulation
    alone = profile.can.interface == "virtualbus"
    if simulation is None or simulation.clock != "real" or not alone:
        return profile, slower(profile, delays)
    usual = _usual_delay(profile, delays)
    if usual <= 0.5 / profile.control.rate:
        return profile, None
    said = f"simulated time: {_not_kept(profile, usual)}; --clock real insists"
    changed = simulation.model_copy(update={"clock": "simulated"})
    return profile.model_copy(update={"simulation": changed}), said


def slower(profile: Profile, delays: Delays | None = None) -> str | None:
    """What to tell where a loop in real time, of real drives or of an arm that others have started,
    will not keep its rate: the highest that this machine keeps. It is for a person to write down:
    gains, limits of the drives and plans depend on it."""
    simulation = profile.simulation
    if profile.drives is None or (simulation is not None and simulation.clock != "real"):
        return None
    usual = _usual_delay(profile, delays)
    if usual <= 0.5 / profile.control.rate:
        return None
    return f"{_not_kept(profile, usual)}; {rate_to_write(profile, usual)}"


def rate_to_write(profile: Profile, delay: float) -> str:
    """What to set where cycles come s late as a rule that must not."""
    rate = profile.control.rate
    kept = next((r for r in RATES if r < 0.99 * rate and delay <= 0.5 / r), None)
    if kept is None:
        return f"nor {RATES[-1]} Hz: end other programs, or use a quicker machine"
    gains = profile.control.gains
    stated = [key for key in ("kp", "ki", "kd") if getattr(gains, key) is not None]
    bandwidth, most = profile.control.bandwidth_hz, MOST_BANDWIDTH * kept
    also = f", control.gains anew (they were set at {rate:g} Hz)" if stated else ""
    if bandwidth is not None and bandwidth > most:
        also += f", control.bandwidth_hz: {most:g} at most"
    return f"write control.rate: {kept}{also}, or end other programs and allow real-time priority"


def _not_kept(profile: Profile, delay: float) -> str:
    return (
        f"this machine does not keep {profile.control.rate:g} Hz (one cycle in twenty of a bare "
        f"loop came {1e3 * delay:.1f} ms late)"
    )


def _usual_delay(profile: Profile, delays: Delays | None) -> float:
    return float(np.quantile((delays or _bare_loop)(1.0 / profile.control.rate, SECONDS), RARE))


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
