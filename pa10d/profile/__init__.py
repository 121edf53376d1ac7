"""Profiles: one YAML file describes one robot."""

from pa10d.profile.load import find_profile, load_profile
from pa10d.profile.profile import Can, Control, Drive, Gains, Profile, Risk, Simulation, Tool

__all__ = [
    "Can",
    "Control",
    "Drive",
    "Gains",
    "Profile",
    "Risk",
    "Simulation",
    "Tool",
    "find_profile",
    "load_profile",
]
