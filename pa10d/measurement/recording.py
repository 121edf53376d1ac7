"""A recording: what encoders and current sensors said during one run, as arrays."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Recording:
    """One run, uniformly sampled.

    t            (N,)    s, equidistant, starts anywhere
    q            (N, n)  rad (m for prismatic joints), joints in the profile's order
    tau          (N, n)  N·m (N), measured at the joint side
    dq           (N, n)  rad/s as the robot reported it, or None; the fit differentiates q itself
    temperature  (N, n)  °C, or None
    extra        name -> (N,): further channels, kept and never needed
    """

    name: str
    t: Array
    q: Array
    tau: Array
    dq: Array | None = None
    temperature: Array | None = None
    extra: Mapping[str, Array] = field(default_factory=dict)

    @property
    def joints(self) -> int:
        """Number of joints n."""
        return self.q.shape[1]

    @cached_property
    def rate(self) -> float:
        """Samples per second."""
        return (len(self.t) - 1) / float(self.t[-1] - self.t[0])

    @property
    def duration(self) -> float:
        """Seconds from the first sample to the last."""
        return float(self.t[-1] - self.t[0])

    def part(self, start: int, stop: int, suffix: str) -> Recording:
        """Samples start … stop-1 as a recording of its own (for splits in time)."""
        cut = slice(start, stop)
        return Recording(
            name=f"{self.name}{suffix}",
            t=self.t[cut],
            q=self.q[cut],
            tau=self.tau[cut],
            dq=None if self.dq is None else self.dq[cut],
            temperature=None if self.temperature is None else self.temperature[cut],
            extra={k: v[cut] for k, v in self.extra.items()},
        )
