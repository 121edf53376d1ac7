"""Devices: what the control loop can hold. Each backend speaks the protocol of protocol.py."""
