"""CiA 402 drives on CANopen, in cyclic synchronous torque mode."""

from backends.bus_budget import profile_budget, wrong_with_rate
from backends.cia402 import remarks, state_of
from backends.device import Device
from backends.protocol import Backend
from pa10d.profile import Profile


def open_backend(profile: Profile) -> Backend:
    """The backend for a profile's drives and bus, not yet connected."""
    from backends.canopen_cia402.backend import CanopenBackend  # CAN libraries, where they are used

    return CanopenBackend(profile)


def _lacking(profile: Profile) -> str | None:
    if not profile.drives:
        return f"profile {profile.name} names no drives"
    return wrong_with_rate(profile, profile_budget(profile))


DEVICE = Device(state_of, remarks, profile_budget, _lacking)
