"""A recording: what encoders and current sensors said during one run, as arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pa10d.measurement.clipped import clipped

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
    excluded     stretches (begin, end), s since the first sample, that no fit and no judgement uses
    limited      (N, n) True where a torque stands at a limit; None: as it shows by itself
    """

    name: str
    t: Array
    q: Array
    tau: Array
    dq: Array | None = None
    temperature: Array | None = None
    extra: Mapping[str, Array] = field(default_factory=dict)
    excluded: tuple[tuple[float, float], ...] = ()
    limited: NDArray[np.bool_] | None = None

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

    def without(self, stretches: Sequence[tuple[float, float]]) -> Recording:
        """The same with these stretches excluded, too, the torque a straight line in each: what is
        wrong there must reach nothing else through a filter."""
        apart = tuple(sorted({*self.excluded, *stretches}))
        marked = replace(self, excluded=apart, limited=self.clipped)
        out = marked.left_out
        if not out.any() or out.all():
            return marked
        at, known = np.flatnonzero(out), np.flatnonzero(~out)
        tau = self.tau.copy()
        for j in range(self.joints):
            tau[at, j] = np.interp(at, known, tau[known, j])
        return replace(marked, tau=tau)

    @cached_property
    def left_out(self) -> NDArray[np.bool_]:
        """(N,) True within an excluded stretch."""
        t, out = self.t - self.t[0], np.zeros(len(self.t), dtype=bool)
        for begin, end in self.excluded:
            out |= (t >= begin) & (t <= end)
        return out

    @cached_property
    def clipped(self) -> NDArray[np.bool_]:
        """(N, n) True where a torque stands at a limit, and nobody knows what it was."""
        return clipped(self.q, self.tau) if self.limited is None else self.limited

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
            excluded=self._excluded_in(cut),
            limited=self.clipped[cut],
        )

    def _excluded_in(self, cut: slice) -> tuple[tuple[float, float], ...]:
        """What is excluded of a part, on the part's own clock."""
        if not self.excluded:
            return ()
        t = self.t[cut] - self.t[0]
        moved = [(max(a - t[0], 0.0), min(b, t[-1]) - t[0]) for a, b in self.excluded]
        return tuple((float(a), float(b)) for a, b in moved if a < b)
