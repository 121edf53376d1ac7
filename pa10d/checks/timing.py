"""Sampling rate, jitter, gaps, length."""

from __future__ import annotations

from collections.abc import Iterator

from pa10d.checks.finding import CheckFinding, Mend
from pa10d.measurement.recording import Recording
from pa10d.measurement.sampling import Timing
from pa10d.measurement.timing_words import (
    doubled,
    incomplete,
    interrupted,
    irregular,
    rounded,
    scattered,
)

SLOW, TOO_SLOW, TOO_FAST = 50.0, 10.0, 20_000.0  # Hz
UNEVEN = 0.1  # of a period: later stamps than this cost accuracy at the usual cut-offs
SHORT = 5.0  # s

STAMPS = {
    "ms": (1e3, "milliseconds"),
    "us": (1e6, "microseconds"),
    "ns": (1e9, "nanoseconds"),
    "day": (1 / 86_400, "days"),
}  # of them in a second


def unit_of_stamps(rate: float) -> str | None:
    """What stamps are in that give so few samples per "second"; None: seconds, or no guess."""
    if rate > TOO_FAST and SLOW <= rate * STAMPS["day"][0] <= TOO_FAST:
        return "day"
    for unit, (factor, _) in STAMPS.items():
        if rate < TOO_SLOW and SLOW <= rate * factor <= TOO_FAST:
            return unit
    return None


def check_timing(recording: Recording, timing: Timing | None) -> Iterator[CheckFinding]:
    """``timing``: how the stamps were before they became equal steps."""
    rate, n = recording.rate, len(recording.t)
    yield CheckFinding(
        "info", "rate", f"{n} samples at {rate:.6g} Hz, {recording.duration:.1f} s, "
        f"{recording.joints} joints"
    )  # fmt: skip
    yield from _plausible(rate)
    if rate >= TOO_SLOW and recording.duration < SHORT:
        yield CheckFinding(
            "warning",
            "short",
            f"the recording lasts {recording.duration:.2g} s",
            "record 20 s or more, so that every joint turns around several times",
        )
    if timing is not None:
        yield from _steps(timing)


def _plausible(rate: float) -> Iterator[CheckFinding]:
    if (unit := unit_of_stamps(rate)) is not None:
        stamps = Mend("time", unit)
        counted = Mend("time", "1/RATE", complete=False)
        by_one = abs(rate - 1) < 1e-6
        yield CheckFinding(
            "error",
            "time_unit",
            f"{rate:.3g} Hz: the stamps look like {STAMPS[unit][1]}"
            + (", or number the samples" if by_one else ""),
            f"--map {stamps.option}"
            + (f", or {counted.option} with the samples' rate in Hz" if by_one else ""),
            mends=(stamps, counted) if by_one else (stamps,),
        )
        return
    if rate < SLOW:
        yield CheckFinding(
            "error" if rate < TOO_SLOW else "warning",
            "slow",
            f"{rate:.3g} Hz is slow: accelerations come from differences of q",
            "record at 100 Hz or faster",
        )
    if rate > TOO_FAST:
        yield CheckFinding(
            "warning",
            "fast",
            f"{rate:.3g} Hz is faster than robots are sampled",
            "check that the stamps are seconds",
        )


def _steps(timing: Timing) -> Iterator[CheckFinding]:
    share = timing.jitter / timing.period
    if timing.scatter:
        yield CheckFinding("info", "scattered_stamps", scattered(timing))
    if timing.missing:
        yield CheckFinding("info", "missing_samples", incomplete(timing))
    if timing.uneven:
        yield CheckFinding(
            "warning" if share > UNEVEN else "info",
            "jitter",
            irregular(timing),
            "let the robot's controller stamp the samples, not the logger",
        )
    if timing.rounding is not None:
        yield CheckFinding(
            "info",
            "rounded_stamps",
            rounded(timing),
        )
    if timing.duplicates:
        yield CheckFinding(
            "warning",
            "duplicate_stamps",
            doubled(timing),
            "log more digits of the time",
        )
    if timing.gaps:
        out = timing.unmeasured
        yield CheckFinding(
            "warning",
            "gaps",
            interrupted(timing),
            "look for what the logger lost there"
            if out
            else "what stands in them was never measured: log every sample, or cut the file",
        )
