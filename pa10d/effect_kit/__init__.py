"""Does an effect keep what a model, a search and a controller rely on? The conformance kit."""

from pa10d.effect_kit.kit import KitVerdict, check

__all__ = ["KitVerdict", "check"]
