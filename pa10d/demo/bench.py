"""The simulated arm with its secret on a bus of its own, and the daemon that commands it.

The secret is in the simulator's process alone: the daemon, its data and what it records know the
plain profile.
"""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Iterator
from pathlib import Path

from backends.registry import device
from pa10d.client import Client, local_daemon
from pa10d.common.errors import UserError
from pa10d.daemon.processes.simulator import simulated_bus, wants_simulator
from pa10d.demo.hidden import Hidden, with_secret
from pa10d.profile import Profile

CONNECT = 60.0  # s


class Bench:
    """``client`` commands the arm; ``time_passes`` lets happen to it what is to happen."""

    def __init__(self, profile: Profile, hidden: Hidden, seed: int) -> None:
        if not wants_simulator(profile):
            raise UserError(
                f"{profile.path}: the demo moves a simulated arm; expected a profile with "
                "'simulation' and can.interface: virtualbus, such as pa10-sim"
            )
        if (lacking := device(profile).lacking(profile)) is not None:
            raise UserError(lacking)
        self.profile, self._hidden, self._seed = profile, hidden, seed
        self.channel = f"demo-{os.getpid()}-{time.time_ns() % 10**9}"
        self._simulator = contextlib.ExitStack()
        self.client: Client

    @contextlib.contextmanager
    def running(self, data: Path) -> Iterator[Bench]:
        """With its processes; all of them have ended after the block."""
        with self._simulator:
            self._switch_on(later=False)
            with local_daemon(
                data, str(self.profile.path), channel=self.channel, clock="simulated"
            ) as self.client:
                yield self

    def time_passes(self) -> None:
        """The arm is switched off and, later, on again; something may have changed meanwhile."""
        self.client.disconnect()
        self._simulator.close()
        self._switch_on(later=True)
        self.client.connect()
        self.client.wait_for_robot("inactive", timeout=CONNECT)
        self.client.confirm()  # it was simulated anew, in its first pose: nothing lost its zero

    def _switch_on(self, later: bool) -> None:
        self._simulator.enter_context(simulated_bus(self._secret(later)))

    def _secret(self, later: bool) -> Profile:
        """The profile as the simulator alone gets it."""
        profile = with_secret(self.profile, self._hidden, self._seed, later)
        assert profile.simulation is not None
        simulation = profile.simulation.model_copy(update={"clock": "simulated"})
        can = profile.can.model_copy(update={"channel": self.channel})
        return profile.model_copy(update={"simulation": simulation, "can": can})
