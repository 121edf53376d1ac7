"""The simulated arm with its secret, and the daemon that commands it over CAN.

The hidden friction is in the simulator's process alone: the daemon, its data and what it records
know the plain profile.
"""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pa10d.client import Client, local_daemon
from pa10d.common.jsonable import JsonObject
from pa10d.daemon.processes.simulator import simulated_bus
from pa10d.profile import Profile


class Laboratory:
    """Runs experiments, one after another; each is stored under its name."""

    def __init__(self, client: Client) -> None:
        self._client = client

    def run(
        self,
        kind: str,
        parameters: Mapping[str, Any],
        name: str,
        controller: str = "pid",
        model: str | None = None,
    ) -> JsonObject:
        """The experiment's result: ``analysis``, ``recommendation``, ``runs``."""
        return self._client.experiment(
            kind, parameters, name=name, controller=controller, model=model, replace=True
        )


@contextlib.contextmanager
def laboratory(profile: Profile, secret: Profile, data: Path) -> Iterator[Laboratory]:
    """On a bus and a port of its own, as fast as this machine can; all processes end with the
    block. secret: the profile as the simulator alone gets it."""
    channel = f"case-study-{os.getpid()}-{time.time_ns() % 10**9}"
    own = secret.model_copy(
        update={"can": secret.can.model_copy(update={"channel": channel})},
    )
    with (
        simulated_bus(own),
        local_daemon(data, str(profile.path), channel=channel, clock="simulated") as client,
    ):
        yield Laboratory(client)
