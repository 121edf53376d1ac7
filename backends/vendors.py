"""Where makers of drives depart from the standard in what the backend reads."""

from __future__ import annotations

MAXON = 0x000000FB

# unit of 0x6076 in N·m; CiA 402 says mN·m
RATED_TORQUE_UNIT = {MAXON: 1e-6}
STANDARD_RATED_TORQUE_UNIT = 1e-3


def rated_torque_unit(vendor: int) -> float:
    """N·m per count of 0x6076 for a vendor id (0x1018:1)."""
    return RATED_TORQUE_UNIT.get(vendor, STANDARD_RATED_TORQUE_UNIT)


OWN_PRODUCT = (0, 0x50413130)  # vendor id, product code of the package's own virtual drive

# products whose 0x6085 is in encoder counts/s²; elsewhere its unit is the drive's own affair
DECELERATION_IN_COUNTS = {OWN_PRODUCT}

# products whose 0x6080 is in motor revolutions per minute, as CiA 402 has it; many choose a unit
SPEED_IN_RPM = {OWN_PRODUCT}

# (vendor, product) -> index of the motor temperature and °C per count
TEMPERATURE_OBJECT = {OWN_PRODUCT: (0x2F10, 0.1)}
