"""Sampling rate, jitter, gaps, length."""

from __future__ import annotations

from collections.abc import Iterator

from pa10d.checks.finding import CheckFinding, Mend, percent
from pa10d.measurement.recording import Recording
from pa10d.measurement.sampling import Timing

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
    if timing.resampled:
        yield CheckFinding(
            "warning" if share > UNEVEN else "info",
            "jitter",
            f"the stamps are irregular: steps off by up to {timing.jitter * 1e3:.3g} ms "
            f"({percent(share)} of a period); the samples were interpolated",
            "let the robot's controller stamp the samples, not the logger",
        )
    if timing.rounding is not None:
        yield CheckFinding(
            "info",
            "rounded_stamps",
            f"the stamps are rounded to {timing.rounding * 1e3:g} ms and were taken as equal steps",
        )
    if timing.duplicates:
        yield CheckFinding(
            "warning",
            "duplicate_stamps",
            f"{timing.duplicates} samples share a stamp with the one before and were averaged",
            "log more digits of the time",
        )
    if timing.gaps:
        begin, longest = max(timing.gaps, key=lambda gap: gap[1])
        many = f"{len(timing.gaps)} gaps" if len(timing.gaps) > 1 else "a gap"
        out = timing.unmeasured
        yield CheckFinding(
            "warning",
            "gaps",
            f"{many} without samples, {sum(g[1] for g in timing.gaps):.3g} s in "
            f"all, the longest {longest:.3g} s at {begin:.3f} s, filled by straight lines"
            + (" that no fit and no judgement uses" if out else ""),
            "look for what the logger lost there"
            if out
            else "what stands in them was never measured: log every sample, or cut the file",
        )
