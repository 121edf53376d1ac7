"""A joint that stands outside its position limits: how far it may, and which way it goes then.

Its limit on that side is where it stands, and follows it inward, never out again: an arm that was
pushed or has run over a limit can be powered to go back, and to nothing else.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pa10d.common.jsonable import JsonObject
from pa10d.control.limits import ArmLimits

Array = NDArray[np.float64]

FARTHEST = 0.2  # rad (m) beyond a limit, from which an arm may be powered to go back inside …
SHARE = 0.1  # … and at most this much of the joint's range: further out, its zero is what is wrong
SLOW = 0.1  # of the speed limit, for every joint, until all are inside
ROUNDING = 1e-6  # rad, rad/s


@dataclass(frozen=True)
class Outside:
    """axis: 0-based; position, limit: rad; beyond: rad outside of it; farthest: rad, from which
    it may be brought back inside."""

    axis: int
    position: float
    limit: float
    farthest: float

    @property
    def beyond(self) -> float:
        """rad between the limit and where the joint stands."""
        return abs(self.position - self.limit)

    @property
    def too_far(self) -> bool:
        """Whether it may not even be powered to go back."""
        return self.beyond > self.farthest

    @property
    def sentence(self) -> str:
        """One line for a person; joints numbered from 1."""
        side = "upper" if self.position > self.limit else "lower"
        return (
            f"joint {self.axis + 1} stands {self.beyond:.4f} rad beyond its {side} limit of "
            f"{self.limit:.4f} rad"
        )

    def document(self) -> JsonObject:
        """For JSON: the axis numbered from 1 as ``joint``."""
        return {
            "joint": self.axis + 1,
            "position": self.position,
            "limit": self.limit,
            "beyond": self.beyond,
            "too_far": self.too_far,
            "sentence": self.sentence,
        }


def outside(q: Array, lower: Array, upper: Array) -> list[Outside]:
    """Every joint that stands outside; (n,) rad each, limits that are unknown are infinite."""
    with np.errstate(invalid="ignore"):
        farthest = np.minimum(FARTHEST, SHARE * (upper - lower))
    return [
        Outside(
            int(j), float(q[j]), float((upper if q[j] > upper[j] else lower)[j]), float(farthest[j])
        )
        for j in np.flatnonzero((q < lower) | (q > upper))
    ]


def why_not_powered(found: list[Outside], recover: bool) -> str | None:
    """Which joints stand outside, how far, and how to get back: one line, or None. recover: it was
    asked for that the arm is powered all the same, to go back inside."""
    if not found:
        return None
    told = "; ".join(one.sentence for one in found)
    by_hand = "move it inside by hand, or correct its zero_offset"
    for one in found:
        if one.too_far:
            most = f"more than the {one.farthest:.2g} rad from which it may be powered to go back"
            return f"{told}: joint {one.axis + 1} is {most}; {by_hand}"
    return None if recover else f"{told}: ask for 'recover' to bring it back slowly, {by_hand}"


class Reach:
    """How far each joint may go now: lower, upper (n,) rad, changed in place."""

    def __init__(self, limits: ArmLimits) -> None:
        self._limits = limits
        self.lower, self.upper = limits.lower.copy(), limits.upper.copy()
        self.widened = False

    def begin(self, q: Array) -> None:
        """The arm is powered up at q (n,)."""
        np.minimum(self._limits.lower, q, out=self.lower)
        np.maximum(self._limits.upper, q, out=self.upper)
        self.widened = bool(outside(q, self._limits.lower, self._limits.upper))

    def follow(self, q: Array) -> None:
        """It is at q now: what it has come inward is not given back."""
        if not self.widened:
            return
        lower, upper = self._limits.lower, self._limits.upper
        np.minimum(lower, np.maximum(self.lower, q), out=self.lower)
        np.maximum(upper, np.minimum(self.upper, q), out=self.upper)
        self.widened = bool((self.lower < lower).any() or (self.upper > upper).any())


def wrong_on_the_way_in(rows: Array, held: Array, limits: ArmLimits) -> str | None:
    """rows (N, 4n) of q, dq, ddq, extra for an arm held at (n,) rad → one line, or None: joints
    that are outside go inward only until they are inside, and nothing is fast meanwhile."""
    n = len(held)
    q, dq = rows[:, :n], rows[:, n : 2 * n]
    found = outside(held, limits.lower - ROUNDING, limits.upper + ROUNDING)
    if not found:
        return None
    until = 0
    for one in found:
        j, sign = one.axis, np.sign(one.position - one.limit)
        beyond = sign * (q[:, j] - one.limit)
        within = np.flatnonzero(beyond <= ROUNDING)
        if not len(within):
            return (
                f"{one.sentence}, and the motion leaves it outside; expected one that ends inside"
            )
        first = int(within[0])
        way = np.diff(beyond[: first + 1], prepend=beyond[0])
        outward = (way > ROUNDING) | (sign * dq[: first + 1, j] > ROUNDING)
        if outward.any():
            row = int(np.argmax(outward))
            return f"{one.sentence}, and the motion turns it outward there (row {row})"
        stop = sign * (q[first:, j] + 0.5 * dq[first:, j] * np.abs(dq[first:, j])
                       / limits.acceleration[j] - one.limit)  # fmt: skip
        if (stop > ROUNDING).any():
            row = first + int(np.argmax(stop > ROUNDING))
            return f"joint {j + 1} would stop beyond its limit once more (row {row})"
        until = max(until, first)
    share = np.abs(dq[: until + 1]) / limits.velocity
    row, j = divmod(int(np.argmax(share)), n)
    if share[row, j] > SLOW * (1.0 + ROUNDING):
        return (
            f"joint {j + 1} moves at {dq[row, j]:.4g} rad/s (row {row}) while a joint is outside "
            f"its position limits; until it is inside {SLOW * limits.velocity[j]:.4g} rad/s are "
            "allowed"
        )
    return None
