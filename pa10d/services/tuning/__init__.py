"""Gains, limits and surroundings of a profile: seen, changed with a diff before, and undone."""

from pa10d.services.tuning.by_hand import why_not_held
from pa10d.services.tuning.edit import propose, show, undo, versions, write
from pa10d.services.tuning.told import (
    ProfileDifference,
    ProfileTuning,
    ProfileVersion,
    ProfileVersions,
)
from pa10d.services.tuning.versions import own_profile

__all__ = [
    "ProfileDifference",
    "ProfileTuning",
    "ProfileVersion",
    "ProfileVersions",
    "own_profile",
    "propose",
    "show",
    "undo",
    "versions",
    "why_not_held",
    "write",
]
