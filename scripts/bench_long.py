"""Long recordings: an hour at 1 kHz out of a ROS 2 bag, and a model from ten such hours.

Measured are seconds and the peak memory of the command's own process (``getrusage``), as it is
started for the purpose. Everything is written to a folder of its own, which is removed afterwards:
0.5 GB per hour of bag and 0.6 GB per hour in the store. ``bag``: minutes of the bag, 0 for none;
``runs``: how many recordings of ``minutes`` each go into one identification.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from pa10d.dynamics import Robot, inverse_dynamics
from pa10d.services.robots import load_robot
from pa10d.store import Channels, RunStore, Samples

PROFILE = "pa10-7c"
RATE = 1000.0  # Hz
BLOCK = 60_000  # samples
SCALE = np.array([1.0, 1.0, 0.5, 0.5, 0.1, 0.1, 0.1])
COMMAND = """
import json, resource, sys, time
from pa10d.cli import main
began = time.perf_counter()
status = main(sys.argv[1:])
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
print(json.dumps({"status": status, "seconds": time.perf_counter() - began, "peak": peak}))
"""


def run(
    bag: float = 60.0, minutes: float = 60.0, runs: int = 10, folder: str = ""
) -> dict[str, Any]:
    """folder: where there is room (default: the system's folder for such things)."""
    profile, robot = load_robot(PROFILE)
    figures: dict[str, Any] = {"joints": robot.n, "rate_hz": RATE, "minutes": minutes}
    with tempfile.TemporaryDirectory(prefix="pa10d-long-", dir=folder or None) as place:
        data = Path(place) / "data"
        if bag:
            path = Path(place) / "bag"
            write_bag(path, robot, bag)
            size = sum(file.stat().st_size for file in path.iterdir())
            words = ["run", "import", str(path), "--profile", PROFILE, "--name", "from-bag"]
            figures["bag"] = {"minutes": bag, "bytes": size, **command(data, *words)}
        names = [f"long-{k}" for k in range(runs)]
        for k, name in enumerate(names):
            store_run(data, name, profile, robot, minutes, k)
        if runs:
            words = ["identify", *names, "--profile", PROFILE, "--name", "long"]
            figures["identify"] = {"runs": runs, **command(data, *words)}
    return figures


def command(data: Path, *words: str) -> dict[str, Any]:
    """What a command took, in a process of its own; its progress is shown."""
    call = [sys.executable, "-c", COMMAND, "--data", str(data), *words]
    done = subprocess.run(call, stdout=subprocess.PIPE, text=True, check=True)
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return found


def blocks(robot: Robot, minutes: float, seed: int) -> Iterator[tuple[np.ndarray, ...]]:
    """t, q, dq, tau a minute at a time: a Fourier series per joint, bodies, friction, noise."""
    rng = np.random.default_rng(seed)
    w = 2 * np.pi * rng.uniform(0.05, 0.6, (5, robot.n))
    a, phase = rng.uniform(0.05, 0.25, (5, robot.n)), rng.uniform(0, 6.28, (5, robot.n))
    for first in range(0, int(minutes * 60 * RATE), BLOCK):
        t = np.arange(first, first + BLOCK) / RATE
        s = w * t[:, None, None] + phase
        q, dq = (a * np.sin(s)).sum(1), (a * w * np.cos(s)).sum(1)
        ddq = -(a * w * w * np.sin(s)).sum(1)
        tau = inverse_dynamics(robot, robot.parameters, q, dq, ddq)
        tau += SCALE * (0.5 * ddq + 8.0 * np.tanh(dq / 0.005) + 12.0 * dq)
        yield t, q, dq, tau + 0.3 * SCALE * rng.normal(size=q.shape)


def store_run(data: Path, name: str, profile: Any, robot: Robot, minutes: float, seed: int) -> None:
    """Into the store without a file between."""
    channels = Channels(joints=robot.joint_names, velocity=True)
    with RunStore(data).building(name, name, channels, profile) as writer:
        for t, q, dq, tau in blocks(robot, minutes, seed):
            writer.append(Samples(np.rint(t * 1e9).astype(np.int64), q, tau, dq))


def write_bag(path: Path, robot: Robot, minutes: float, seed: int = 0) -> None:
    """A ROS 2 bag as a robot's driver would record it: /joint_states at 1 kHz, in sqlite."""
    from rosbags.rosbag2 import Writer
    from rosbags.typesys import Stores, get_typestore

    types = get_typestore(Stores.ROS2_HUMBLE)
    state, header, time = (
        types.types[f"{name}"]
        for name in (
            "sensor_msgs/msg/JointState", "std_msgs/msg/Header", "builtin_interfaces/msg/Time"
        )
    )  # fmt: skip
    nothing = np.zeros(robot.n)
    pattern = state(header(time(0, 0), "base"), list(robot.joint_names), nothing, nothing, nothing)
    form = np.frombuffer(types.serialize_cdr(pattern, state.__msgtype__), dtype=np.uint8)
    size = 8 * robot.n
    effort = len(form) - size
    velocity, position = effort - size - 8, effort - 2 * (size + 8)  # a count of 8 bytes between
    with Writer(path, version=9) as writer:
        topic = writer.add_connection("/joint_states", state.__msgtype__, typestore=types)
        for t, q, dq, tau in blocks(robot, minutes, seed):
            rows = np.tile(form, (len(t), 1))
            ns = np.rint(t * 1e9).astype(np.int64) + 1_700_000_000_000_000_000
            stamps = np.stack([ns // 10**9, ns % 10**9], axis=1).astype("<u4")
            rows[:, 4:12] = stamps.view(np.uint8)
            for at, values in ((position, q), (velocity, dq), (effort, tau)):
                rows[:, at : at + size] = np.ascontiguousarray(values).view(np.uint8)
            for k, row in enumerate(rows):
                writer.write(topic, int(ns[k]), row.tobytes())


def sentences(figures: dict[str, Any]) -> str:
    """The figures as docs/benchmarks.md has them."""
    out = []
    if found := figures.get("bag"):
        out.append(
            f"a bag of {found['minutes']:g} min ({found['bytes'] / 1e9:.2f} GB) imported in "
            f"{found['seconds']:.0f} s, peak {found['peak'] / 1e9:.2f} GB"
        )
    if found := figures.get("identify"):
        out.append(
            f"{found['runs']} runs of {figures['minutes']:g} min identified in "
            f"{found['seconds']:.0f} s, peak {found['peak'] / 1e9:.2f} GB"
        )
    return "\n".join(out)
