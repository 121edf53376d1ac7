"""Reads a run back: its samples as they were measured, and as a Recording with equal steps."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.measurement.believable import EXPECTED, believable
from pa10d.measurement.recording import Recording
from pa10d.measurement.sampling import Timing
from pa10d.store import mcap_records as mcap
from pa10d.store.bag_reader import Bag, Topic, read_bag
from pa10d.store.channels import (
    COLUMN,
    COMMANDS,
    CURRENT,
    EXTRA,
    STATES,
    TEMPERATURE,
    Array,
    CommandedMotion,
    Samples,
)
from pa10d.store.entries import explained
from pa10d.store.equal_steps import equal_steps

LATEST = 2**63 - 1  # ns
_EXACT = 2**53  # ns: up to here a stamp is exact as float64 seconds


@dataclass(frozen=True)
class StoredRun:
    """A run's measurements and what was written beside them."""

    joints: tuple[str, ...]
    samples: Samples
    time_zero_ns: int  # the stamp at which the run's own clock shows 0
    metadata: dict[str, dict[str, str]]  # pa10d.run, pa10d.profile, pa10d.plan, pa10d.end
    complete: bool  # False: being written, or broken off

    def recording(self, name: str) -> tuple[Recording, Timing]:
        """With equal steps, and what the stamps were like."""
        return to_recording(self.samples, self.time_zero_ns, name)


def read_run(path: Path) -> StoredRun:
    """Everything in the bag file ``path``, finished or not; UserError where it is damaged."""
    bag = read_bag(path)
    states = bag.topics.get(STATES)
    if states is None or not len(states.stamps):
        raise UserError(f"{path}: no measurement on {STATES}; the run broke off before the first")
    try:
        run = _assembled(bag, states)
        _refuse_nonsense(run)
    except mcap.BROKEN as error:
        raise UserError(f"{path}: damaged ({explained(error)}); expected a run of pa10d") from error
    return run


def _assembled(bag: Bag, states: Topic) -> StoredRun:
    stamps = states.stamps
    samples = Samples(
        stamps,
        states.values["position"],
        states.values["effort"],
        states.values.get("velocity"),
        _commands(bag, stamps),
        _aligned(bag.topics.get(TEMPERATURE), stamps),
        _aligned(bag.topics.get(CURRENT), stamps),
        {
            topic.notes[COLUMN]: values
            for name, topic in bag.topics.items()
            if name.startswith(EXTRA) and (values := _aligned(topic, stamps)) is not None
        },
    )
    zero = bag.metadata.get("pa10d.run", {}).get("time_zero_ns", stamps[0])
    return StoredRun(states.names, samples, int(zero), bag.metadata, bag.complete)


def _refuse_nonsense(run: StoredRun) -> None:
    """ValueError where the arrays do not fit together: checksums do not cover everything."""
    samples, shape = run.samples, (len(run.samples), len(run.joints))
    sent = samples.commands
    per_joint = {
        "positions": samples.q, "torques": samples.tau, "velocities": samples.dq,
        "temperatures": samples.temperature, "currents": samples.current,
        "commands": None if sent is None else np.stack([sent.q, sent.dq, sent.tau]),
    }  # fmt: skip
    for what, values in per_joint.items():
        if values is not None and values.shape[-2:] != shape:
            raise ValueError(f"{what} of shape {values.shape}, expected {shape}")
    if not (believable(samples.q).all() and believable(samples.tau).all()):
        raise ValueError(f"positions or torques of which one is not {EXPECTED}")
    if any(values.shape != shape[:1] for values in samples.extra.values()):
        raise ValueError("a further channel with more than one value a sample")
    stamps = samples.stamps
    if stamps[0] < 0 or (np.diff(stamps) < 0).any() or not 0 <= run.time_zero_ns <= LATEST:
        raise ValueError("stamps that do not rise")


def to_recording(samples: Samples, time_zero_ns: int, name: str) -> tuple[Recording, Timing]:
    """Equal steps, resampled where the stamps are not; see sampling.Timing for how they were."""
    timing, even = to_equal_steps(samples, time_zero_ns, name)
    extra = dict(even.extra)
    if even.current is not None:
        extra |= {f"i{j + 1}": column for j, column in enumerate(even.current.T)}
    recording = Recording(name, timing.grid, even.q, even.tau, even.dq, even.temperature, extra)
    return recording.without(timing.unmeasured) if timing.unmeasured else recording, timing


def to_equal_steps(samples: Samples, time_zero_ns: int, name: str) -> tuple[Timing, Samples]:
    """Every channel on ``timing.grid``, s on the run's own clock."""
    ns = samples.stamps - time_zero_ns
    if ns[0] >= _EXACT:  # a clock since 1970: keep the fine digits, drop the whole seconds
        ns = ns - int(ns[0]) // 1_000_000_000 * 1_000_000_000
    if ns[-1] == ns[0]:
        raise UserError(f"{name}: all samples have one stamp; expected a recording of a motion")
    return equal_steps(np.multiply(ns, 1e-9, dtype=np.float64), samples)


def _aligned(topic: Topic | None, stamps: NDArray[np.int64], field: str = "data") -> Array | None:
    """The topic's values at the stamps of the joint states: (N,) or (N, n)."""
    if topic is None or not len(topic.stamps):
        return None
    values = topic.values[field]
    if np.array_equal(topic.stamps, stamps):
        return values
    origin = int(stamps[0])
    at, known = (stamps - origin) * 1e-9, (topic.stamps - origin) * 1e-9
    if values.ndim == 1:
        return np.interp(at, known, values)
    return np.stack([np.interp(at, known, column) for column in values.T], axis=1)


def _commands(bag: Bag, stamps: NDArray[np.int64]) -> CommandedMotion | None:
    topic = bag.topics.get(COMMANDS)
    q, dq, tau = (_aligned(topic, stamps, f) for f in ("position", "velocity", "effort"))
    return None if q is None or dq is None or tau is None else CommandedMotion(q, dq, tau)
