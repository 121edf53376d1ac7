"""Numbers that begin anew: counters and angles that ran over, integers that lost their sign.

They are told from the samples as they were logged: equal steps made of irregular stamps smear a
jump over its neighbours.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

WORDS = {8: 2.0**8, 16: 2.0**16, 32: 2.0**32}
LARGE = 0.5  # of the whole range: a step beyond it is no motion
SMALL = 0.25  # of the whole range: what steps beside the jumps stay below
BESIDE = 5  # samples on either side of a jump that tell how fast the signal was
LEVELS = 20  # steps of a sensor that a range has to be wider than to tell anything
MOST = 200  # jumps that are looked at
WHOLE = 1e-6  # by which a whole number may be off after a factor and its inverse
ALONE = {True: (32,), False: (16, 32)}
"""Words whose upper half is told where no jump is: counts of an encoder may lie anywhere in 16."""
TURNS = {"2pi": 2 * np.pi, "1": 1.0, "360": 360.0, "3600": 3600.0, "36000": 36000.0}
"""Once round, in what angles are written in."""
ANGLES = {"2pi": "*rad", "1": "*rev", "360": "*deg", "3600": "*deg/10", "36000": "*deg/100"}


@dataclass(frozen=True)
class Wrap:
    """sign_bits: of a word whose sign was lost; else period: after which the numbers begin anew,
    as a mapping writes it (``wrap360*deg``: what begins anew at 360 is in degrees), and what it is
    in figures. told: whether it is a period that is usual, or only what the jumps amount to, or, of
    a word, whether the numbers jump over its zero at all."""

    sign_bits: int = 0
    period: float = 0.0
    written: str = ""
    told: bool = True


def wrap_of(values: Array, factor: float = 1.0, *, position: bool = False) -> Wrap | None:
    """(N,) of one channel, at the stamps that were logged; None: it never begins anew. factor: SI
    units per number of the file; position: whether its zero is anybody's choice."""
    logged = values / factor
    whole = np.rint(logged)
    logged = whole if len(values) and np.abs(logged - whole).max() < WHOLE else logged
    bits = lost_sign(logged)
    if not bits:
        upper = upper_half(logged)
        told = running_over(values)
        if told or upper is None or upper not in ALONE[position]:
            return told
        return Wrap(sign_bits=upper, told=False)
    return running_over(values) if running_over(signed(logged, bits)) else Wrap(sign_bits=bits)


def signed(values: Array, bits: int) -> Array:
    """Numbers of so many bits that were read without their sign, with it."""
    word = WORDS[bits]
    return np.asarray(np.mod(values + 0.5 * word, word) - 0.5 * word)


def lost_sign(values: Array) -> int | None:
    """Bits of the word that numbers with a sign were read from without it; None: they were not.

    They jump by most of the word wherever they pass zero, and with their sign they do not."""
    steps = np.abs(np.diff(values))
    if not len(steps) or not values.min() >= 0 or not (values == np.round(values)).all():
        return None
    for bits, word in WORDS.items():
        full = steps > (1 - SMALL) * word
        if values.max() >= word or full.sum() < 2:
            continue
        if np.abs(np.diff(signed(values, bits))).max() < LARGE * word:
            return bits
    return None


def upper_half(values: Array) -> int | None:
    """Bits of the word whose upper half all numbers lie in, near its end, as numbers do that are
    below zero throughout and were read without their sign; None: of no word."""
    if not len(values) or not (values == np.round(values)).all() or np.ptp(values) < LEVELS:
        return None
    for bits in (16, 32):
        word = WORDS[bits]
        if 0.5 * word <= values.min() and values.max() < word:
            return bits
    return None


def running_over(values: Array) -> Wrap | None:
    """A jump is the period less what the signal moved on meanwhile, and that is what it moves by
    just before and after; so each jump tells the period."""
    steps = np.diff(values)
    reach = float(np.ptp(values)) if len(values) else 0.0
    far = np.abs(steps) > LARGE * reach
    if not reach > 0 or not far.any() or far.all() or np.abs(steps[~far]).max() > SMALL * reach:
        return None
    told, error = _periods(steps, far)
    if not len(told):
        return None
    whole = bool((values == np.round(values)).all())
    sizes = np.abs(steps[steps != 0])
    fine = 2 * float(sizes.min())
    if reach < LEVELS * fine:
        return None  # a sensor at rest between two of its levels
    doubt = np.maximum(error, fine) + 1e-6 * told
    middle = float(np.median(told))
    known = dict(TURNS) | ({f"{2**bits}": 2.0**bits for bits in range(8, 33)} if whole else {})
    fits = {
        text: period
        for text, period in known.items()
        if period >= reach * (1 - 1e-6) and (np.abs(told - period) <= doubt).all()
    }
    if fits and not (len(told) < 2 and "1" in fits):  # a jump by about one may be anything
        text = min(fits, key=lambda one: abs(fits[one] - middle))
        return Wrap(period=fits[text], written=f"wrap{text}{ANGLES.get(text, '')}")
    same = len(told) >= 2 and (np.abs(told - middle) <= doubt).all() and middle >= reach
    return Wrap(period=middle, written="wrapCOUNTS", told=False) if same else None


def _periods(steps: Array, far: NDArray[np.bool_]) -> tuple[Array, Array]:
    """The period that each jump tells, and how far off it may be."""
    periods, errors = [], []
    for k in np.flatnonzero(far)[:MOST]:
        around = slice(max(k - BESIDE, 0), k + BESIDE + 1)
        beside = steps[around][~far[around]]
        if len(beside):
            periods.append(abs(float(np.median(beside) - steps[k])))
            errors.append(float(np.ptp(beside)))
    return np.array(periods), np.array(errors)


def unwrapped(values: Array, period: float) -> Array:
    """(N,) running on where the numbers began anew; exact for whole numbers."""
    turns = np.concatenate([[0.0], np.cumsum(np.rint(np.diff(values) / period))])
    return np.asarray(values - period * turns)


def centred(values: Array, period: float) -> Array:
    """The same (N,) so many whole periods away that their middle is nearest to zero: which of its
    rounds a counter began in, and whether it has a sign, is not in its numbers."""
    if not len(values):
        return values
    middle = 0.5 * (float(values.min()) + float(values.max()))
    return np.asarray(values - period * np.rint(middle / period))
