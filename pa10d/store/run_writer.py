"""Writes a run as it happens: what was appended is on disk 0.2 s later, whatever comes then."""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO

import numpy as np

from pa10d.common.errors import UserError
from pa10d.common.locked_file import lock_at_once
from pa10d.common.version import __version__
from pa10d.profile import Profile
from pa10d.store.bag_metadata import write_bag_metadata
from pa10d.store.bag_repair import END
from pa10d.store.bag_writer import BagWriter, MessageBlock, Stamps
from pa10d.store.channels import Array, Channels, Samples
from pa10d.store.folders import locked
from pa10d.store.room import give_back, reserve
from pa10d.store.run_info import BAG, RunInfo, Status, said_meanwhile
from pa10d.store.run_repair import repair_run

FLUSH = 0.2  # s
LARGEST = 4096  # samples in a chunk
PATIENCE = 1.0  # s that the end of a run waits for others: meanwhile nothing else is written


class RunWriter:
    """One run being written into ``folder``; made by RunStore.start."""

    def __init__(
        self,
        folder: Path,
        info: RunInfo,
        channels: Channels,
        profile: Profile | None = None,
        plan: str = "",
        time_zero_ns: int | None = None,
    ) -> None:
        """``time_zero_ns``: the stamp that is t = 0 of the recording; None: the first one."""
        self.folder, self.info, self.channels = folder, info, channels
        self.then: Callable[[RunInfo], RunInfo] | None = None  # once it has been closed
        reserve(folder)
        self._file = _open(folder / BAG)
        lock_at_once(self._file)
        self._waiting: list[tuple[Stamps, dict[str, dict[str, Array]]]] = []
        self._queued = 0  # samples waiting
        self._count = 0
        self._span: tuple[int, int] | None = None
        self._flushed = time.monotonic()
        try:
            self._bag = BagWriter(self._file, info.software)
            self._topics = {
                topic: self._bag.add_channel(topic, template, notes)
                for topic, (template, notes) in channels.templates().items()
            }
            self._write_origin(profile, plan, time_zero_ns)
            self._bag.flush()
            info.save(folder)
        except BaseException:
            self._file.close()
            raise

    def append(self, samples: Samples) -> None:
        """Add samples (copied), stamps rising; on disk when 0.2 s have passed."""
        if not len(samples):
            return
        topics = samples.by_topic(self.channels)
        for first in range(0, len(samples), LARGEST):
            cut = slice(first, first + LARGEST)
            values = {
                t: {f: v[cut].copy() for f, v in fields.items()} for t, fields in topics.items()
            }
            self._waiting.append((samples.stamps[cut].copy(), values))
            self._queued += len(samples.stamps[cut])
            if self._queued >= LARGEST:
                self.flush()
        first_stamp = int(samples.stamps[0]) if self._span is None else self._span[0]
        self._span = (first_stamp, int(samples.stamps[-1]))
        self._count += len(samples)
        if time.monotonic() - self._flushed >= FLUSH:
            self.flush()

    def flush(self) -> None:
        """Hand what is waiting to the operating system, as one chunk."""
        self._flushed = time.monotonic()
        if not self._waiting:
            return
        stamps = np.concatenate([part for part, _ in self._waiting])
        blocks = [
            MessageBlock(
                channel,
                stamps,
                {
                    name: np.concatenate([values[topic][name] for _, values in self._waiting])
                    for name in self._waiting[0][1][topic]
                },
            )
            for topic, channel in self._topics.items()
        ]
        self._waiting.clear()
        self._queued = 0
        self._bag.write_chunk(blocks)
        self._bag.flush()

    def close(self, status: Status = "success", reason: str = "", **changes: object) -> RunInfo:
        """Finish the bag and say how the run ended."""
        self.flush()
        self._bag.add_metadata(END, {"status": status, "reason": reason})
        self._bag.close()
        os.fsync(self._file.fileno())
        write_bag_metadata(self.folder, BAG, self._bag.index)
        self.info = self.info.but(
            status=status,
            reason=reason,
            **_extent(self._count, self._span),
            **changes,
        )
        give_back(self.folder)
        self._tell()
        self._file.close()
        if self.then is not None:
            told, self.info = self.info, self.then(self.info)
            if self.info != told:
                self._tell()
        return self.info

    def salvage(self, reason: str) -> RunInfo:
        """End a run that could not be written on: everything that is whole stays readable."""
        held = os.dup(self._file.fileno())  # nobody takes it for abandoned meanwhile
        try:
            self.abandon()
            give_back(self.folder)
            self.info = said_meanwhile(self.folder, self.info)
            repaired = repair_run(self.folder, self.info)
            self.info = repaired.but(status="failed", reason=reason, repaired=False)
            if self.then is not None:
                self.info = self.then(self.info)
            self._tell()
        finally:
            os.close(held)
        return self.info

    def _tell(self) -> None:
        """Describe the run as it is now; what a person has said of it since it began stays.

        A lock that another process does not let go of keeps no run from its end.
        """
        with contextlib.ExitStack() as held:
            with contextlib.suppress(UserError):
                held.enter_context(locked(self.folder.parent, PATIENCE))
            self.info = said_meanwhile(self.folder, self.info)
            self.info.save(self.folder)

    def abandon(self) -> None:
        """Let go of the file as it is; what was not written goes nowhere."""
        if self._file.closed:
            return
        nowhere = os.open(os.devnull, os.O_WRONLY | os.O_CLOEXEC)
        os.dup2(nowhere, self._file.fileno(), inheritable=False)
        os.close(nowhere)
        self._file.close()

    def _write_origin(self, profile: Profile | None, plan: str, time_zero: int | None) -> None:
        run = {"id": self.info.id, "name": self.info.name, "created": self.info.created}
        run |= {"kind": self.info.kind, "source": self.info.source, "software": __version__}
        if time_zero is not None:
            run["time_zero_ns"] = str(time_zero)
        self._bag.add_metadata("pa10d.run", run)
        if profile is not None:
            texts = {"yaml": profile.path, "urdf": profile.urdf}
            texts_read = {k: p.read_text("utf-8", "replace") for k, p in texts.items()}
            self._bag.add_metadata("pa10d.profile", {"name": profile.name, **texts_read})
        if plan:
            self._bag.add_metadata("pa10d.plan", {"plan": plan})


def _open(path: Path) -> BinaryIO:
    return path.open("wb", buffering=1 << 16)


def _extent(count: int, span: tuple[int, int] | None) -> dict[str, float]:
    duration = (span[1] - span[0]) / 1e9 if span else 0.0
    return {
        "samples": count,
        "duration": duration,
        "rate": (count - 1) * 1e9 / (span[1] - span[0]) if span and duration > 0 else 0.0,
    }
