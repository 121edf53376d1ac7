"""Devices: what the control loop can hold. Each backend speaks the protocol of protocol.py."""

import logging

for _library in ("can", "canopen"):
    # they speak of serial modules that nobody asked for and of frames that we judge ourselves;
    # who wants to hear them adds a handler of his own
    logging.getLogger(_library).addHandler(logging.NullHandler())
    logging.getLogger(_library).propagate = False
