"""What a joint shows while it slides: its friction, and a link that sways behind it.

A joint that goes to and fro by one way, at several speeds, shaken or not, obeys

    torque = J·ddq + C·sgn(dq) + B·dq + g0 + g1·q

wherever it slides. All of it at once, low-passed alike on both sides, tells dry friction from
viscous better than steady windows do: what shakes, gathers speed or rings has its own term. With a
spring between motor and link the link is where a filter of the motor's angle puts it,

    x = ω²/(s² + 2ζω·s + ω²) · q,   ω² = (K - G)/J_link,

and the same equation has J_link·ddx and gravity at x in place of the rigid link. It is linear in
all but ω and ζ, and so these are tried one by one (variable projection: Golub & Pereyra, Inverse
Problems 19, 2003). Such a link is seen here where it sways too slowly for the lines of the small
torques, from half a hertz on.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.control.gains import BUS_DELAY

Array = NDArray[np.float64]

SMOOTH, OF_RATE = 16.0, 1.0 / 6.0  # Hz that is looked at, at most; of the rate
MOVES = 0.02  # rad/s: slower may stick
AROUND = 0.06  # s before and after, in which it moves as well
ENDS = 0.1  # s that the filters spoil at either end
FEWEST = 0.15  # s to either side, for friction to be told
EVERY = 1.0 / 64.0  # s between rows that are looked at: more say no more below ``SMOOTH``
SLOWEST, FASTEST, SWAYS = 0.4, 6.0, 30  # Hz, how many are tried
EDGE = 1.05  # from either end: what is best there is no swing
LOSSES = (0.003, 0.02, 0.1)  # of critical damping
STEPS, REFINED = np.array([[0.0, 0.0], [0.05, 0.0], [0.0, 0.5]]), 40  # of their logarithms
BEHIND = [0.0, -np.inf, -np.inf, -np.inf]  # least of what ``_swaying`` is multiplied by
DRY = 2  # which column is dry friction's; viscous friction's is before it
NEAR, ALIKE = 0.25, 64.0  # how far it may be from what it was, of it; rows that err alike
HALVES = 2.0  # times as much is left without the spring, at least
APART = 0.1  # as a logarithm, of two frequencies that are not one
CARRIED = 0.2  # of the inertia that is the link's, at least: less is a neighbour that sways


@dataclass(frozen=True)
class Friction:
    """Of one joint, N·m and N·m·s/rad; moved: rad that it went; effort: N·m, half the range."""

    coulomb: float
    viscous: float
    moved: float
    effort: float


@dataclass(frozen=True)
class Sway:
    """hertz: at which the link would swing, its motor held; kg·m² of rotor and link; N·m/rad."""

    hertz: float
    rotor: float
    link: float
    stiffness: float

    @property
    def carried(self) -> float:
        """Share of the inertia that is behind the spring."""
        return self.link / (self.link + self.rotor)


@dataclass(frozen=True)
class _Rows:
    """Of where the joint slides: what is looked at of a signal, and the columns all have alike."""

    low: Array
    keep: NDArray[np.int64]
    common: Array
    wanted: Array
    dry: float

    def of(self, signals: Array) -> Array:
        """Signals (..., N) as columns."""
        return np.asarray(scipy.signal.sosfiltfilt(self.low, signals)[..., self.keep].T)

    def fit(self, own: Array, floors: list[float]) -> tuple[Array, float]:
        """Coefficients of J, B, C, g0 and these columns, and N·m that are left, RMS."""
        columns = np.column_stack([self.common, own])
        scale = np.maximum(np.linalg.norm(columns, axis=0), 1e-12)
        lower = np.array([0.0, 0.0, 0.0, -np.inf, *floors])
        found = scipy.optimize.lsq_linear(
            columns / scale, self.wanted, bounds=(lower, np.inf), method="bvls"
        )
        return found.x / scale, float(np.sqrt(2.0 * found.cost / len(self.wanted)))

    def likely(self, own: Array, floors: list[float]) -> Array:
        """The same coefficients, dry friction not far from what it was before: what rings along
        with the strokes looks like friction."""
        left = self.fit(own, floors)[1]
        if self.dry <= 0.0 or left <= 0.0:
            return self.fit(own, floors)[0]
        weight = np.sqrt(ALIKE) * left / (NEAR * self.dry)
        row = weight * np.eye(self.common.shape[1])[DRY]
        told = replace(
            self,
            common=np.vstack([self.common, row]),
            wanted=np.append(self.wanted, weight * self.dry),
        )
        return told.fit(np.vstack([own, np.zeros(own.shape[1])]), floors)[0]


def slid_friction(
    q: Array, torque: Array, rate: float, softest: float, dry: float
) -> tuple[Friction, Sway | None] | None:
    """From angle rad and sent torque N·m (N,) of one joint that stood, then went to and fro. None
    where it did not slide to both sides. softest: N·m/rad that a gear's spring has at least; dry:
    N·m of friction as small motions before had it, 0: not known."""
    rows = _rows(q, torque, rate, dry)
    if rows is None:
        return None
    t, gone = np.arange(len(q)) / rate, q - q[0]

    def columns(x: Sequence[float]) -> Array:
        return _swaying(rows, gone, t, 2.0 * np.pi * np.exp(x[0]), float(np.exp(x[1])), rate)

    def left(x: Sequence[float]) -> float:
        return rows.fit(columns(x), BEHIND)[1]

    tried = np.geomspace(SLOWEST, FASTEST, SWAYS)
    first = min(itertools.product(np.log(tried), np.log(LOSSES)), key=left)
    ends = np.log([[SLOWEST, FASTEST], [LOSSES[0], LOSSES[-1]]])
    at = scipy.optimize.minimize(
        left, first, bounds=ends, method="Nelder-Mead",
        options={"maxiter": REFINED, "initial_simplex": np.array(first) + STEPS},
    ).x  # fmt: skip
    rigid = rows.of(gone[None])
    sway = _sway(rows.likely(columns(at), BEHIND), float(np.exp(at[0])), softest)
    if sway is not None and left(at) < rows.fit(rigid, [-np.inf])[1] / HALVES:
        best = rows.likely(columns(at), BEHIND)
    else:
        best, sway = rows.likely(rigid, [-np.inf]), None
    moved, effort = float(np.ptp(q)), 0.5 * float(np.ptp(torque))
    return Friction(float(best[DRY]), float(best[DRY - 1]), moved, effort), sway


def _sway(found: Array, hertz: float, softest: float) -> Sway | None:
    """What these coefficients say of rotor, link and spring; None where that is no gear."""
    stiffness = max(float(found[4]) * (2.0 * np.pi * hertz) ** 2, 1e-12)
    link = float(found[4]) / max(1.0 - float(found[5]) / stiffness, 1e-12)
    sway = Sway(hertz, float(found[0]), max(link, 1e-12), stiffness)
    inside = SLOWEST * EDGE < hertz < FASTEST / EDGE
    gear = stiffness > max(softest, found[5]) and sway.carried > CARRIED
    return sway if inside and gear else None


def _rows(q: Array, torque: Array, rate: float, dry: float) -> _Rows | None:
    low = scipy.signal.butter(2, min(SMOOTH, OF_RATE * rate), fs=rate, output="sos")
    t = np.arange(len(q)) / rate
    acts = np.interp(t - BUS_DELAY / rate, t, torque)  # when what was sent moves the joint
    smooth, ends = scipy.signal.sosfiltfilt(low, q), max(1, round(ENDS * rate))
    dq = np.gradient(smooth, 1.0 / rate)
    width = 2 * max(1, round(AROUND * rate)) + 1
    slides = scipy.ndimage.minimum_filter1d((np.abs(dq) > MOVES).astype(np.uint8), width) > 0
    slides[:ends], slides[-ends:] = False, False
    if min((slides & (dq > 0)).sum(), (slides & (dq < 0)).sum()) < FEWEST * rate:
        return None
    keep = np.flatnonzero(slides)[:: max(1, int(EVERY * rate))]
    sense = scipy.signal.sosfiltfilt(low, np.sign(dq))
    common = np.stack([np.gradient(dq, 1.0 / rate), dq, sense, np.ones(len(q))], axis=1)[keep]
    return _Rows(low, keep, common, scipy.signal.sosfiltfilt(low, acts)[keep], dry)


def _swaying(rows: _Rows, gone: Array, t: Array, w: float, loss: float, rate: float) -> Array:
    """Columns of a link that swings at ``w`` rad/s: its acceleration, its angle, and what swing it
    had at the begin. gone: (N,) rad, the motor's way from there."""
    # w²/(s² + 2·loss·w·s + w²) with the trapezoidal rule (Tustin); this runs thousands of times
    twice, lossy, square = 2.0 * rate, 4.0 * loss * w * rate, w**2
    ahead = [square, 2.0 * square, square]
    back = [twice**2 + lossy + square, 2.0 * (square - twice**2), twice**2 - lossy + square]
    angle = scipy.signal.lfilter(ahead, back, gone)
    fades = np.exp(-loss * w * t)
    seen = [square * (gone - angle), angle, fades * np.cos(w * t), fades * np.sin(w * t)]
    return rows.of(np.stack(seen))


def own_sways(seen: Mapping[int, Sway]) -> dict[int, Sway]:
    """Of joints, those that sway by themselves. A link that sways pushes its neighbours at its own
    frequency; its own motor, with little of the inertia before the spring, is where it belongs."""
    own: dict[int, Sway] = {}
    for j, one in sorted(seen.items(), key=lambda item: -item[1].carried):
        if all(abs(np.log(one.hertz / other.hertz)) > APART for other in own.values()):
            own[j] = one
    return own
