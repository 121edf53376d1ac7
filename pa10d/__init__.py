"""Hold a robot arm by its CANopen amplifiers and learn what its torque is made of."""

__version__ = "0.1.0"
