"""Whether a model got worse where it should not, by its errors on the held-out side."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pa10d.diagnose.constants import MUCH_WORSE
from pa10d.diagnose.evidence.errors_of import doubt_of
from pa10d.diagnose.evidence.held_out import judge
from pa10d.diagnose.regression.state import SearchState
from pa10d.judgement.encoder import less_noise
from pa10d.regression import per_joint

Array = NDArray[np.float64]


def harmful(before: SearchState, after: SearchState) -> bool:
    """Is anything worse, in steady motion or where the arm turns round?"""
    return spoils(before, after) or turns_worse(before, after)


def spoils(
    before: SearchState, after: SearchState, made: tuple[Array, Array] | None = None
) -> bool:
    """Did the errors, each joint by its own measure, grow on the whole, or much and significantly
    on one joint?

    On short recordings a right effect may move what several joints share within its uncertainty,
    and away from where a joint happened to do well: that is no reason to go without it.

    made: (n,) (N·m)² that noise of the angles makes of the squared errors of either, which does not
    count then
    """
    r0, r1 = before.held_residual(), after.held_residual()
    was, now = rms(r0), rms(r1)
    if made is not None:
        was, now = (np.sqrt(less_noise(x**2, m)) for x, m in zip((was, now), made, strict=True))
    ratio = _times(now, was)
    if less_likely(ratio):
        return True
    if np.max(ratio) > 1.0 + MUCH_WORSE:
        moved = {j: r0[j] - r1[j] for j in r0}
        worse = judge(after.held, r0, moved, doubt_of(after)).worse
        return any(ratio[j] > 1.0 + MUCH_WORSE for j in worse)
    return False


def turns_worse(before: SearchState, after: SearchState) -> bool:
    """The same with reversals, which no fit looks at, where a joint did not get worse without them
    already."""
    ratio = _times(rms(after.held_residual()), rms(before.held_residual()))
    everywhere = _times(after.moving_rms(), before.moving_rms())
    beyond = everywhere / np.maximum(ratio, 1.0)
    return less_likely(everywhere) or bool(np.max(beyond) > 1.0 + MUCH_WORSE)


def less_likely(ratio: Array) -> bool:
    """Of errors that became so many times (n,) as large: is the data less likely on the whole, each
    joint's noise unknown (profile likelihood: the sum of the logarithms)? By squares one joint that
    the shared bodies left would outweigh all others, however much they gained."""
    return bool(np.sum(np.log(np.maximum(ratio, 1e-12))) > 0)


def _times(after: Array, before: Array) -> Array:
    """(n,): one where a joint has no sample to judge by."""
    return np.where(before > 0, after / np.maximum(before, 1e-300), 1.0)


def rms(residual: dict[int, Array]) -> Array:
    """(n,) N·m."""
    return np.array([per_joint.rms(residual[j]) for j in sorted(residual)])


def taken_by(before: SearchState, after: SearchState) -> float:
    """Weighted squared error that is gone from the fit side, in units of what was left before."""
    share = 1.0 - (after.fit.rms() / before.fit.rms()) ** 2
    return float(np.sum(share * [len(before.train.tau[j]) for j in range(before.train.n)]))
