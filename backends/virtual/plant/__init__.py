"""The simulated arm: rigid links with true stiction, and effects hidden in it on request."""

from backends.virtual.plant.plant import Plant, build

__all__ = ["Plant", "build"]
