"""A control process to be killed: enables the arm of a profile and swings it until the end."""

import os
import sys
import time
from contextlib import suppress

from bus_helpers import Driver

from backends import by_hand
from backends.canopen_cia402.backend import CanopenBackend
from pa10d.profile import load_profile

with suppress(PermissionError):
    os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(20))
arm = CanopenBackend(load_profile(sys.argv[1]))
arm.open()
driver = Driver(arm)
by_hand.enable(arm, driver.hold)
driver.run(0.3)
print("moving", flush=True)
started = time.monotonic()
while time.monotonic() - started < 30:
    driver.step()
