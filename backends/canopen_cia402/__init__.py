"""CiA 402 drives on CANopen, in cyclic synchronous torque mode."""

from backends.canopen_cia402.backend import CanopenBackend
from backends.protocol import Backend
from pa10d.profile import Profile

__all__ = ["CanopenBackend", "open_backend"]


def open_backend(profile: Profile) -> Backend:
    """The backend for a profile's drives and bus, not yet connected."""
    return CanopenBackend(profile)
