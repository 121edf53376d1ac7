"""A recording whose arrays lie on disk: what is looked at is read, and nothing is kept.

Ten hours at 1 kHz are 6 GB of positions, velocities and torques. Who works a stretch at a time
(``part``) needs a stretch of memory; who asks for a whole channel gets it, for as long as he holds
it.
"""

from __future__ import annotations

import os
import tempfile
import weakref
from collections.abc import Sequence
from pathlib import Path
from typing import IO, cast

import numpy as np
from numpy.typing import NDArray

from pa10d.measurement.recording import Recording
from pa10d.store.room import refuse_without_room

Array = NDArray[np.float64]

LARGE = 400_000_000  # bytes of recordings in memory from which on they go to disk
CHANNELS = ("t", "q", "tau", "dq", "temperature")


def size_in_memory(samples: int, joints: int) -> int:
    """Bytes of a recording: stamps, q, tau and dq."""
    return 8 * samples * (1 + 3 * joints)


class RecordingOnDisk(Recording):
    """The same recording, its channels in a file without a name: it is gone when this object is,
    and when the process is, however that ends. Further channels (``extra``) are left behind."""

    _file: IO[bytes]
    _places: dict[str, tuple[int, tuple[int, ...]]]

    def __init__(self, recording: Recording, folder: Path) -> None:
        """folder: where there is room. UserError where there is none."""
        found = {name: getattr(recording, name) for name in CHANNELS}
        refuse_without_room(folder, sum(v.nbytes for v in found.values() if v is not None))
        file = tempfile.TemporaryFile(dir=folder)  # noqa: SIM115
        weakref.finalize(self, file.close)
        places: dict[str, tuple[int, tuple[int, ...]]] = {}
        for name, values in found.items():
            if values is not None:
                places[name] = (file.tell(), values.shape)
                np.ascontiguousarray(values, dtype=np.float64).tofile(file)
        file.flush()
        own = {"name": recording.name, "excluded": recording.excluded, "extra": {}}
        for name, value in {**own, "_file": file, "_places": places}.items():
            object.__setattr__(self, name, value)  # a frozen dataclass has no other way

    @property
    def t(self) -> Array:
        """(N,) s."""
        return cast(Array, self._rows("t", slice(None)))

    @property
    def q(self) -> Array:
        """(N, n) rad."""
        return cast(Array, self._rows("q", slice(None)))

    @property
    def tau(self) -> Array:
        """(N, n) N·m."""
        return cast(Array, self._rows("tau", slice(None)))

    @property
    def dq(self) -> Array | None:
        """(N, n) rad/s, or None."""
        return self._rows("dq", slice(None))

    @property
    def temperature(self) -> Array | None:
        """(N, n) °C, or None."""
        return self._rows("temperature", slice(None))

    @property
    def joints(self) -> int:
        """Number of joints n."""
        return self._places["q"][1][1]

    def part(self, start: int, stop: int, suffix: str) -> Recording:
        """Samples start … stop-1, in memory."""
        cut = slice(start, stop)
        return Recording(
            name=f"{self.name}{suffix}",
            **{name: self._rows(name, cut) for name in CHANNELS},  # type: ignore[arg-type]
            excluded=self._excluded_in(cut),
        )

    def without(self, stretches: Sequence[tuple[float, float]]) -> Recording:
        """In memory."""
        return self.part(0, self._places["t"][1][0], "").without(stretches)

    def _rows(self, name: str, cut: slice) -> Array | None:
        if name not in self._places:
            return None
        begin, shape = self._places[name]
        start, stop, _ = cut.indices(shape[0])
        width = 8 * int(np.prod(shape[1:], dtype=np.int64))
        out = np.empty((max(0, stop - start), *shape[1:]))
        view, at = memoryview(out.data).cast("B"), begin + start * width
        while len(view):  # the kernel hands out 2 GB at a time
            read = os.preadv(self._file.fileno(), [view], at)
            if not read:
                raise OSError(f"{self.name}: its file on disk is shorter than it was written")
            view, at = view[read:], at + read
        return out
