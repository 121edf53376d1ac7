"""A CAN bus between processes of one machine, for machines without SocketCAN.

Registered with python-can as interface ``virtualbus``: ``can.Bus(interface="virtualbus",
channel="pa10d")`` and every tool of python-can work on it.
"""

from backends.virtualbus.bus import VirtualBus

__all__ = ["VirtualBus"]
