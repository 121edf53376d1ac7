"""A bare exchange of frames between two processes: what the machine's own part of a cycle costs.

The frames of one cycle (RPDOs and SYNC one way, TPDOs back) over a Unix socket, nothing looked at.
"""

from __future__ import annotations

import os
import socket
import time
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from backends.frames import frame

MOST = 4096  # bytes of a packet


class Pace(NamedTuple):
    """Of one round: wall and processor time of the asking process, medians, µs."""

    wall: float
    processor: float


def ping_pong(nodes: Sequence[int], cycles: int) -> Pace:
    """Question and answer ``cycles`` times, of drives with these node ids."""
    question = b"".join(frame(0x200 + node, bytes(4)) for node in nodes) + frame(0x80)
    answer = b"".join(frame(0x180 + node, bytes(8)) for node in nodes)
    here, there = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    child = os.fork()
    if child == 0:
        here.close()
        while there.recv(MOST):
            there.send(answer)
        os._exit(0)
    there.close()
    wall, processor = np.empty(cycles), np.empty(cycles)
    try:
        for k in range(cycles):
            began, used = time.perf_counter_ns(), time.thread_time_ns()
            here.send(question)
            here.recv(MOST)
            processor[k] = time.thread_time_ns() - used
            wall[k] = time.perf_counter_ns() - began
    finally:
        here.close()  # which ends the other one
        os.waitpid(child, 0)
    return Pace(float(np.median(wall)) / 1000, float(np.median(processor)) / 1000)
