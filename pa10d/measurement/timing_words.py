"""How stamps became equal steps, in words: the same when a file is read and when it is checked."""

from __future__ import annotations

from pa10d.measurement.sampling import Timing


def irregular(timing: Timing) -> str:
    """Steps that differ; the samples were read off between them."""
    share = 100 * timing.jitter / timing.period
    of_a_period = f"{share:.0f} %" if share >= 10 else f"{share:.2g} %"
    return (
        f"the stamps are irregular: steps off by up to {timing.jitter * 1e3:.3g} ms "
        f"({of_a_period} of a period); the samples were interpolated at {timing.rate:.6g} Hz"
    )


def scattered(timing: Timing) -> str:
    """Stamps of a logger that was late, of samples that were not."""
    return (
        f"the stamps scatter by up to {timing.scatter * 1e3:.3g} ms about equal steps, and the "
        f"positions do not: taken as read at {timing.rate:.6g} Hz"
    )


def incomplete(timing: Timing) -> str:
    """Steps of several periods."""
    samples = "a sample is" if timing.missing == 1 else f"{timing.missing} samples are"
    return f"{samples} missing at {timing.rate:.6g} Hz, read off between the others"


def rounded(timing: Timing) -> str:
    """Stamps with too few digits."""
    return (
        f"the stamps are rounded to {(timing.rounding or 0.0) * 1e3:g} ms and were taken as equal "
        f"steps at {timing.rate:.6g} Hz"
    )


def doubled(timing: Timing) -> str:
    """Samples of one stamp."""
    return f"{timing.duplicates} samples share a stamp with the one before and were averaged"


def interrupted(timing: Timing) -> str:
    """Stretches without samples."""
    begin, longest = max(timing.gaps, key=lambda gap: gap[1])
    many = f"{len(timing.gaps)} gaps" if len(timing.gaps) > 1 else "a gap"
    return (
        f"{many} without samples, {sum(gap[1] for gap in timing.gaps):.3g} s in all, the longest "
        f"{longest:.3g} s at {begin:.3f} s, filled by straight lines (channel 'gap')"
        + (" that no fit and no judgement uses" if timing.unmeasured else "")
    )


def told(timing: Timing) -> list[str]:
    """All that a user should know of it."""
    return [
        words(timing)
        for words, is_so in (
            (doubled, timing.duplicates),
            (scattered, timing.scatter),
            (irregular, timing.uneven),
            (incomplete, timing.missing),
            (rounded, timing.rounding is not None),
            (interrupted, timing.gaps),
        )
        if is_so
    ]
