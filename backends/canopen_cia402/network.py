"""canopen on our own port: one reader of the bus, whether configuring or cycling.

While drives are configured a thread hands frames to canopen; in the cycle there is none, so that
nothing competes with the loop for the interpreter.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import time

import canopen

from backends.frames import ERROR, REMOTE, frame, frames
from backends.ports import Port

POLL = 0.02  # s; how long leaving the listening phase may take
SDO_TIMEOUT, SDO_RETRIES = 1.0, 2


class PortNetwork(canopen.Network):
    """A canopen.Network whose frames go through a Port."""

    def __init__(self, port: Port) -> None:
        super().__init__()
        self._port = port
        self.failure: OSError | None = None  # what ended the listening thread

    def send_message(self, can_id: int, data: bytes, remote: bool = False) -> None:
        with self.send_lock:
            self._port.send(frame(can_id | (REMOTE if remote else 0), bytes(data)))

    def add_drive(self, node: int, dictionary: canopen.ObjectDictionary) -> canopen.RemoteNode:
        """A remote node with patient SDO transfers."""
        remote = canopen.RemoteNode(node, dictionary)
        remote.sdo.RESPONSE_TIMEOUT, remote.sdo.MAX_RETRIES = SDO_TIMEOUT, SDO_RETRIES
        self[node] = remote
        return remote

    def disconnect(self) -> None:
        """The port belongs to somebody else."""

    @contextmanager
    def listening(
        self,
        also: Callable[[int, bytes], None] = lambda can_id, data: None,
        idle: Callable[[], None] = lambda: None,
    ) -> Iterator[None]:
        """Receive in a thread for as long as the block lasts.

        ``also`` sees every frame, error frames included; ``idle`` is called now and then.
        """
        done = threading.Event()

        def run() -> None:
            try:
                while not done.is_set():
                    packet = self._port.receive(POLL)
                    idle()
                    for can_id, data in frames(packet):
                        also(can_id, data)
                        if not can_id & (ERROR | REMOTE):
                            self.notify(can_id, bytearray(data), time())
            except OSError as error:
                self.failure = error

        thread = threading.Thread(target=run, name="canopen configuration", daemon=True)
        thread.start()
        try:
            yield
        finally:
            done.set()
            thread.join()
        if self.failure is not None:
            raise self.failure
