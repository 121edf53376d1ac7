"""A model for other programs: see ``formats``."""
