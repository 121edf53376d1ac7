"""Zero-phase filtering, differentiation and decimation, the same for both sides of the equation.

All of it happens in the frequency domain: a signal is continued oddly at both ends (so that
value and slope stay continuous), transformed, multiplied by |H(f)|² of a digital Butterworth
filter (what forward-backward filtering amounts to, without its start-up transients), times
(i2πf)^d for derivatives, and transformed back on a coarser grid when it is decimated.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numba
import numpy as np
import scipy.fft
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.measurement.torque_filter import TorqueFilter

Array = NDArray[np.float64]

IN_CACHE = 100_000  # values transformed at a time
LOWEST = 1e-7  # cut-off over sampling rate: some hours at 1 kHz, far beyond any motion of an arm


def refuse_cutoff(cutoff: float, rate: float) -> None:
    """UserError where no low-pass at ``rate`` Hz can have this cut-off, Hz."""
    if not LOWEST * rate <= cutoff < 0.5 * rate:
        raise UserError(
            f"cut-off {cutoff:g} Hz: expected between {LOWEST * rate:g} Hz and half the sampling "
            f"rate ({0.5 * rate:g} Hz)"
        )


@dataclass(frozen=True)
class Lowpass:
    """Zero-phase low-pass for signals of ``samples`` values at ``rate`` Hz.

    cutoff: Hz, where |H|² is one half (forward and backward pass of a Butterworth of ``order``)
    factor: every factor-th sample is kept, the first one first
    blind: samples at each end that are not to be trusted (a derivative knows nothing of what lay
    beyond the end); the nearest trusted one stands in for them, so that their error stays there
    channel: what the torque has passed already, and what is held against it has to pass as well
    """

    samples: int
    rate: float
    cutoff: float
    factor: int = 1
    order: int = 4
    blind: int = 0
    channel: TorqueFilter | None = None

    def __post_init__(self) -> None:
        refuse_cutoff(self.cutoff, self.rate)

    @property
    def kept(self) -> int:
        """Number of samples after decimation."""
        return -(-self.samples // self.factor)

    @property
    def settle(self) -> int:
        """Samples at each end, at the decimated rate, that still know of the continuation."""
        return int(np.ceil(1.5 / self.cutoff * self.rate / self.factor))

    def __call__(self, signal: Array, derivative: int = 0) -> Array:
        """Filter along axis 0: (N, ...) -> (kept, ...); optionally the d-th time derivative."""
        return self._run(np.asarray(signal, dtype=float), (derivative,))[0]

    def of_torque(self, torque: Array, derivative: int = 0) -> Array:
        """The same for what comes out of the channel itself."""
        return replace(self, channel=None)(torque, derivative)

    def derivatives(self, signal: Array) -> tuple[Array, Array, Array]:
        """(x, ẋ, ẍ), each filtered, from one transform."""
        x, dx, ddx = self._run(np.asarray(signal, dtype=float), (0, 1, 2))
        return x, dx, ddx

    def rates(self, velocity: Array) -> tuple[Array, Array]:
        """(x, ẋ), each filtered, from one transform."""
        x, dx = self._run(np.asarray(velocity, dtype=float), (0, 1))
        return x, dx

    def gain(self, frequency: Array) -> Array:
        """|H(f)|² at ``frequency`` Hz, the factor by which a sine is scaled."""
        f = np.minimum(np.asarray(frequency, dtype=float), 0.5 * self.rate * (1 - 1e-9))
        ratio = np.tan(np.pi * f / self.rate) / np.tan(np.pi * self.cutoff / self.rate)
        with np.errstate(over="ignore"):
            return 1.0 / (1.0 + ratio ** (2 * self.order))

    def of_rows(self, rows: Array, chosen: NDArray[np.int64]) -> Array:
        """(kept, k): the chosen k of signals that lie in rows (r, N), filtered."""
        return self._rows(rows, np.asarray(chosen, dtype=np.int64), (0,))[0]

    def _run(self, signal: Array, orders: tuple[int, ...]) -> list[Array]:
        trailing = signal.shape[1:]
        rows = np.ascontiguousarray(signal.reshape(len(signal), -1).T)
        outs = self._rows(rows, np.arange(len(rows)), orders)
        return [out.reshape(self.kept, *trailing) for out in outs]

    def _rows(self, rows: Array, chosen: NDArray[np.int64], orders: tuple[int, ...]) -> list[Array]:
        if rows.shape[1] != self.samples:
            raise ValueError(f"expected {self.samples} samples, found {rows.shape[1]}")
        pad, length = self._padding()
        outs = [np.empty((len(chosen), self.kept)) for _ in orders]
        coarse = length // self.factor
        frequency = np.arange(coarse // 2 + 1, dtype=np.float64) * (self.rate / length)
        gain = self.gain(frequency) / self.factor
        passed = 1.0 if self.channel is None else self.channel.gain(frequency)
        if self.factor > 1 and coarse % 2 == 0:
            gain[-1] = 0.0
        blind = self.blind if self.blind < self.samples // 4 else 0
        step = max(1, IN_CACHE // length)
        lead = pad // self.factor
        for start in range(0, len(chosen), step):
            part = chosen[start : start + step]
            whole, level, slope = np.empty((len(part), length)), *np.empty((2, len(part), 1))
            _continue(rows, part, pad, blind, whole, level[:, 0], slope[:, 0])
            spectrum = scipy.fft.rfft(whole, axis=1, overwrite_x=True)[:, : len(frequency)]
            spectrum *= gain * passed
            for out, order in zip(outs, orders, strict=True):
                turned = spectrum if order == 0 else spectrum * (2j * np.pi * frequency) ** order
                fine = scipy.fft.irfft(turned, n=coarse, axis=1)[:, lead : lead + self.kept]
                if order == 0:
                    kept_at = pad + self.factor * np.arange(self.kept, dtype=float)
                    fine = fine + (level + slope * kept_at)
                elif order == 1:
                    fine = fine + slope * self.rate
                out[start : start + step] = fine
        return [np.ascontiguousarray(out.T) for out in outs]

    def _padding(self) -> tuple[int, int]:
        """Left padding and total length: multiples of the factor, a length FFTs like."""
        wanted = int(np.ceil(2.0 / self.cutoff * self.rate))
        wanted = min(wanted, self.samples - 1)
        pad = -(-wanted // self.factor) * self.factor
        if pad > self.samples - 1:
            pad = (self.samples - 1) // self.factor * self.factor
        blocks = -(-(self.samples + 2 * pad) // self.factor)
        while True:
            blocks = scipy.fft.next_fast_len(blocks, real=True)
            if blocks * self.factor - pad - self.samples <= self.samples - 1 and blocks % 2 == 0:
                return pad, blocks * self.factor
            if blocks * self.factor - pad - self.samples > self.samples - 1:
                if pad < self.factor:
                    raise UserError(
                        f"{self.samples} samples are too few for a {self.cutoff:g} Hz low-pass"
                    )
                pad -= self.factor
                blocks = -(-(self.samples + 2 * pad) // self.factor)
                continue
            blocks += 1


def delayed(signal: Array, delay: float, rate: float) -> Array:
    """The signal (N, n) as it would be ``delay`` seconds later: a linear-phase shift."""
    return _passed(signal, lambda f: np.exp(-2j * np.pi * f * delay), delay, rate)


def through_channel(signal: Array, channel: TorqueFilter | None, rate: float) -> Array:
    """The signal (N, n) behind a torque channel, but for its delay."""
    if channel is None:
        return signal
    return _passed(signal, channel.gain, 0.0, rate, 8.0 * channel.delay)


def _passed(
    signal: Array,
    gain: Callable[[Array], NDArray[Any]],
    delay: float,
    rate: float,
    memory: float = 0.0,
) -> Array:
    """What a filter of unit gain at rest makes of it; memory: s beyond its delay."""
    samples = len(signal)
    pad = min(samples - 1, int((abs(delay) + memory) * rate) + 64)
    whole = np.concatenate(
        [
            2 * signal[:1] - signal[pad:0:-1],
            signal,
            2 * signal[-1:] - signal[-2 : -2 - pad : -1],
        ]
    )
    ramp = np.linspace(0, 1, len(whole))[:, None] * (whole[-1] - whole[0]) + whole[0]
    slope = (whole[-1] - whole[0]) / (len(whole) - 1) * rate
    f = np.asarray(np.fft.rfftfreq(len(whole), 1 / rate), dtype=np.float64)[:, None]
    spectrum = np.fft.rfft(whole - ramp, axis=0) * gain(f)
    moved = np.fft.irfft(spectrum, n=len(whole), axis=0) + ramp - slope * delay
    return np.asarray(moved[pad : pad + samples])


@numba.njit(cache=True)
def _continue(rows, chosen, pad, blind, out, level, slope):
    """Each chosen row, its blind ends held, continued oddly by ``pad`` on the left and to the
    width of ``out`` on the right, minus the straight line from first to last value."""
    samples, length = rows.shape[1], out.shape[1]
    top = samples - 1 - blind
    for r in range(len(chosen)):
        x, y = rows[chosen[r]], out[r]
        low, high = x[blind], x[top]
        for k in range(pad):
            y[k] = 2.0 * low - x[min(max(pad - k, blind), top)]
        for k in range(samples):
            y[pad + k] = x[min(max(k, blind), top)]
        for k in range(pad + samples, length):
            y[k] = 2.0 * high - x[min(max(2 * samples + pad - 2 - k, blind), top)]
        level[r] = y[0]
        slope[r] = (y[length - 1] - y[0]) / (length - 1)
        for k in range(length):
            y[k] -= level[r] + slope[r] * k
