"""From whatever state the nodes are in to OPERATIONAL and configured, several at once."""

from __future__ import annotations

import threading
import time
from concurrent.futures import ThreadPoolExecutor

import canopen

from backends.canopen_cia402.configure import DriveReport, Wish, configure
from backends.canopen_cia402.network import PortNetwork
from backends.canopen_cia402.remote import SetupError
from backends.faults import refusal
from pa10d.common.words import listed

START, PRE_OPERATIONAL, RESET_COMMUNICATION = 1, 128, 130
BOOT_TIMEOUT = 5.0  # s


class BootWatch:
    """Notes which nodes sent their boot-up message."""

    def __init__(self) -> None:
        self._booted: set[int] = set()
        self._changed = threading.Condition()

    def frame(self, can_id: int, data: bytes) -> None:
        if 0x700 < can_id <= 0x77F and data == b"\0":
            with self._changed:
                self._booted.add(can_id - 0x700)
                self._changed.notify_all()

    def forget(self) -> None:
        """Boot-ups from before our reset do not count."""
        with self._changed:
            self._booted.clear()

    def wait(self, nodes: list[int], timeout: float) -> list[int]:
        """The nodes that did not boot within ``timeout`` s."""
        with self._changed:
            self._changed.wait_for(lambda: self._booted.issuperset(nodes), timeout)
            return [node for node in nodes if node not in self._booted]


def bring_up(
    network: PortNetwork,
    nodes: dict[int, canopen.RemoteNode],
    wishes: dict[int, Wish],
    boot: BootWatch,
) -> dict[int, DriveReport]:
    """Reset communication, configure and start the axes ``nodes``; call while listening.

    BackendFault names every axis that does not answer or does not serve, each in one line.
    """
    ids = {axis: node.id for axis, node in nodes.items()}
    boot.forget()
    for number in ids.values():
        network.send_message(0, bytes([RESET_COMMUNICATION, number]))
    silent = boot.wait(list(ids.values()), BOOT_TIMEOUT)
    mute = {axis: number for axis, number in ids.items() if number in silent}
    if mute:
        raise refusal("no_answer", dict.fromkeys(mute, _silent(list(mute.values()))))
    with ThreadPoolExecutor(max(len(nodes), 1)) as pool:
        running = {axis: pool.submit(configure, nodes[axis], wishes[axis]) for axis in nodes}
    reports, refused = {}, {}
    for axis, result in running.items():
        try:
            reports[axis] = result.result()
        except SetupError as error:
            refused[axis] = f"node {ids[axis]}: {error}"
    if refused:
        raise refusal("setup", refused)
    for number in ids.values():
        network.send_message(0, bytes([START, number]))
    return reports


def _silent(numbers: list[int]) -> str:
    """What is common to all axes whose nodes say nothing."""
    many = len(numbers) > 1
    named = listed([str(number) for number in numbers])
    return f"node{'s' if many else ''} {named} {'do' if many else 'does'} not answer to NMT reset"


def let_go(network: PortNetwork, nodes: dict[int, canopen.RemoteNode]) -> None:
    """Give the nodes back as they were: communication as after power-on, PRE-OPERATIONAL."""
    for node in nodes.values():
        network.send_message(0, bytes([RESET_COMMUNICATION, node.id]))
    time.sleep(0.01)  # let the frames out before the port closes
