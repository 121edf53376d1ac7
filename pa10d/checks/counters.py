"""Counters that wrap round: what a drive sent with a sign, read without it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pa10d.checks.finding import Finding, Mend, joint_label
from pa10d.measurement.recording import Recording

Array = NDArray[np.float64]

WORDS = {8: 2.0**8, 16: 2.0**16, 32: 2.0**32}
NEAR = 0.02  # share of a word by which a step may be off it: the signal itself moved on


def wraps(values: Array) -> int | None:
    """Bits of the word that numbers with a sign were read from without it; None: they were not."""
    steps = np.abs(np.diff(values))
    if values.min() < 0 or not len(steps):
        return None
    for bits, word in WORDS.items():
        full = steps > (1 - NEAR) * word
        if values.max() < word and full.sum() >= 2 and (values == np.round(values)).all():
            return bits
    return None


def check_counters(recording: Recording, names: tuple[str, ...] | None) -> Iterator[Finding]:
    """What integers of drives look like when their sign was lost."""
    for field, block in (("q", recording.q), ("tau", recording.tau), ("dq", recording.dq)):
        if block is None:
            continue
        for j in range(recording.joints):
            bits = wraps(block[:, j])
            if bits is None:
                continue
            signed = Mend(f"{field}{j + 1}", f"i{bits}")
            yield Finding(
                "error",
                "wrapped",
                f"{joint_label(j, names)}: {field} jumps between 0 and {WORDS[bits]:.0f}: numbers "
                f"with a sign, read without it ({WORDS[bits] - 1:.0f} for −1)",
                f"--map {signed.option}, with the unit's factor behind it, such as [i{bits}*0.001]",
                j + 1,
                (signed,),
            )
