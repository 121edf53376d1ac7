"""Is a candidate real? Statistics on runs that the fit has not seen.

r0: held-out residual without the candidate; p: what the fit predicts the candidate to change.
The slope of r0 on p is near one for a real effect and near zero for a chance one; its standard
error follows from the noise's own spectrum, so that slow, coloured noise counts as the few
independent samples that it is.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import scipy
import scipy.fft
from numpy.typing import NDArray

from pa10d.diagnose.constants import (
    BLOCK_SECONDS,
    HARM_SIGNIFICANT,
    MATERIAL_HARM,
    SHARE_OF_GAIN,
    SMOOTHING_HZ,
)
from pa10d.diagnose.evidence.drift import GoesWithMotion, drift
from pa10d.diagnose.regression.side import Side
from pa10d.regression.per_joint import PerJoint, rms

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Evidence:
    """slope: of the held-out residual on the predicted change; z: slope over its error
    p_value: one-sided, not corrected for the number of candidates; Student's, with the degrees
    of freedom that the estimate of the noise has (Satterthwaite)
    before, after: (n,) N·m RMS of the held-out residual without and with the candidate
    worse: joints whose error rises significantly
    cluster_t: t over blocks of time of how alike residual and change are in each, which no noise
    model enters and in which no single event counts for more than another
    gains: (n,) weighted squared error removed on the held-out side, per joint
    """

    slope: float
    z: float
    p_value: float
    before: Array
    after: Array
    worse: tuple[int, ...]
    cluster_t: float
    gains: Array

    @property
    def gain(self) -> float:
        """Weighted squared error removed on the held-out side."""
        return float(np.sum(self.gains))


@dataclass(frozen=True)
class ModelUncertainty:
    """How uncertain the present model is: joint -> its columns (m_j, p) on the held-out side, and
    the covariance (p, p) of their coefficients under the noise as it is.

    What a coefficient is off by moves with the arm, as a candidate does: no spectrum of the
    residual knows that the two go together.
    """

    columns: PerJoint
    covariance: Array

    def along(self, change: PerJoint) -> Array:
        """(p,): how the sum of error · change moves with each coefficient."""
        return np.asarray(sum(self.columns[j].T @ p for j, p in change.items()))

    def variance(self, along: Array) -> float:
        """Of such a sum."""
        return max(float(along @ self.covariance @ along), 0.0)


def judge(
    side: Side,
    r0: PerJoint,
    change: PerJoint,
    doubt: ModelUncertainty | None = None,
    ground: Mapping[int, NDArray[np.bool_]] | None = None,
    of_itself: bool = False,
) -> Evidence:
    """r0, change: joint -> (m_j,) N·m on the held-out side; doubt: of the model that left r0;
    ground: joint -> (m_j,) the samples of which the change has something to say (all). What is
    missing from the model is no noise only because the change does not speak there. of_itself: the
    change was made of other stretches of this residual; slow noise foretells its neighbours, and
    what that explains of it is noise still.

    Joints are weighted with their held-out error as it is, not with what the fit left: a joint
    that the fit flatters would otherwise outvote all others.
    """
    n = side.n
    sigma = spread(r0)
    product = variance = unsure = power = 0.0
    blocks: dict[tuple[int, int], Array] = {}
    before, after = np.zeros(n), np.zeros(n)
    harmed: dict[int, float] = {}
    gains = np.zeros(n)
    r0_runs = side.scatter(r0)
    p_runs = side.scatter(change)
    ground = ground or {}
    heard = side.scatter({j: np.ones(len(r)) * ground.get(j, True) for j, r in r0.items()})
    for j in range(n):
        before[j] = rms(r0[j])
        after[j] = before[j]
        if j not in change or not np.any(change[j]):
            continue
        p, r = change[j], r0[j]
        after[j] = rms(r - p)
        weight = 1.0 / sigma[j] ** 2
        loss = 2 * p @ r - p @ p
        gains[j] = weight * loss
        loss_variance = 0.0
        for k, run in enumerate(side.runs):
            keep = heard[k][:, j] > 0
            pr, rr = p_runs[k][:, j], r0_runs[k][:, j]
            noise = np.where(keep, rr if of_itself else rr - pr, 0.0)
            one, scattered = variance_of_sum(pr, noise, keep, run.rate, moved(side, k, j))
            variance += weight**2 * one
            unsure += weight**4 * scattered
            loss_variance += 4 * one
            product += weight * float(pr @ rr)
            power += weight * float(pr @ pr)
            length = max(1, int(BLOCK_SECONDS * run.rate))
            for start in range(0, len(pr), length):
                cut = slice(start, start + length)
                here = np.array([pr[cut] @ rr[cut], pr[cut] @ pr[cut], rr[cut] @ rr[cut]])
                blocks[k, start] = blocks.get((k, start), np.zeros(3)) + weight * here
        if doubt is not None:
            loss_variance += 4 * doubt.variance(doubt.along({j: p}))
        significant = loss < -HARM_SIGNIFICANT * np.sqrt(max(loss_variance, 1e-300))
        if significant and after[j] > (1.0 + MATERIAL_HARM) * before[j]:
            harmed[j] = -weight * loss
    if doubt is not None:
        weighted = {j: change[j] / sigma[j] ** 2 for j in change}
        variance += doubt.variance(doubt.along(weighted))
    alike = np.array([b[0] / np.sqrt(b[1] * b[2]) for b in blocks.values() if b[1] * b[2] > 0])
    scatter = float(np.sqrt(np.sum(alike**2)))
    z = product / np.sqrt(variance) if variance > 0 else 0.0
    return Evidence(
        slope=product / power if power > 0 else 0.0,
        z=float(z),
        p_value=float(scipy.stats.t.sf(z, 2.0 * variance**2 / unsure) if unsure > 0 else 0.5),
        before=before,
        after=after,
        worse=tuple(j for j, harm in harmed.items() if harm > SHARE_OF_GAIN * gains.sum()),
        cluster_t=float(np.sum(alike) / scatter) if scatter > 0 else 0.0,
        gains=gains,
    )


def spread(residual: PerJoint) -> Array:
    """(n,) RMS per joint, N·m."""
    return np.array([max(rms(r), 1e-12) for _, r in sorted(residual.items())])


def fit_side_power(side: Side, residual: PerJoint, change: PerJoint) -> float:
    """How far a candidate stands out on the side it was fitted to: the projection of the residual
    on the change it makes, squared over its variance under the noise. χ² with as many degrees of
    freedom as the candidate has parameters where there is only noise. residual, change: weighted.
    """
    product = variance = 0.0
    r_runs, p_runs = side.scatter(residual), side.scatter(change)
    for j in range(side.n):
        for k, run in enumerate(side.runs):
            p, r, keep = p_runs[k][:, j], r_runs[k][:, j], side.keep[k][:, j]
            if not np.any(p):
                continue
            product += float(p @ r)
            variance += quadratic_form(
                p, np.where(keep, r - p, 0.0), keep, run.rate, moved(side, k, j)
            )
    z = product / np.sqrt(variance) if variance > 0 else 0.0
    return float(max(z, 0.0) ** 2)


def rivalry(side: Side, r0: PerJoint, a: PerJoint, b: PerJoint) -> tuple[float, float]:
    """(overlap, z) of two predicted changes of one residual.

    overlap: cosine between them in whitened units; z: by how many standard errors a explains
    more than b. A high overlap with a small |z| means that this data cannot tell them apart.
    """
    dot = power_a = power_b = difference = variance = 0.0
    sigma = spread(r0)
    a_runs, b_runs, r_runs = side.scatter(a), side.scatter(b), side.scatter(r0)
    for j in range(side.n):
        weight = 1.0 / sigma[j] ** 2
        for k, run in enumerate(side.runs):
            pa, pb, r = a_runs[k][:, j], b_runs[k][:, j], r_runs[k][:, j]
            dot += weight * float(pa @ pb)
            power_a += weight * float(pa @ pa)
            power_b += weight * float(pb @ pb)
            difference += weight * float(2 * (pa - pb) @ r - pa @ pa + pb @ pb)
            keep = side.keep[k][:, j]
            noise = np.where(keep, r - pa, 0.0)
            variance += (
                4 * weight**2 * quadratic_form(pa - pb, noise, keep, run.rate, moved(side, k, j))
            )
    overlap = dot / np.sqrt(max(power_a * power_b, 1e-300))
    return float(overlap), float(difference / np.sqrt(max(variance, 1e-300)))


def moved(side: Side, run: int, joint: int) -> GoesWithMotion:
    """What the motion of a run may leave in a joint's residual, worked out once a side."""
    known = side.kept_by_evidence
    if (run, joint) not in known:
        motion = side.simple_motion(run, joint)
        known[run, joint] = GoesWithMotion.of(motion, side.keep[run][:, joint], padded(len(motion)))
    return known[run, joint]


def padded(samples: int) -> int:
    """Length of a transform in which correlations do not wrap around."""
    return int(scipy.fft.next_fast_len(2 * samples, real=True))


def quadratic_form(
    signal: Array,
    noise: Array,
    keep: NDArray[np.bool_],
    rate: float,
    moved: GoesWithMotion | None = None,
) -> float:
    """Var(Σ signal·noise), see ``variance_of_sum``."""
    return variance_of_sum(signal, noise, keep, rate, moved)[0]


def variance_of_sum(
    signal: Array,
    noise: Array,
    keep: NDArray[np.bool_],
    rate: float,
    moved: GoesWithMotion | None = None,
) -> tuple[float, float]:
    """Var(Σ signal·noise) = Σ_f |P(f)|²·S(f) for stationary noise with the smoothed spectrum S of
    the given residual, as slow as it may be, and the variance of that estimate (slow noise has few
    ordinates in its periodogram, each scattered as χ² of two). Gaps (keep False) are missing, not
    silent. moved: what the motion may leave there, which is no drift."""
    share = float(np.mean(keep))
    if share <= 0:
        return 0.0, 0.0
    length, scale = padded(len(signal)), 1.0 / np.sqrt(len(noise) * share)
    spectrum = scipy.fft.rfft(noise, length) * scale
    slower, apart, expected = drift(spectrum, length, len(signal), moved)
    power = np.abs(scipy.fft.rfft(signal, length)) ** 2
    power[1 : (length + 1) // 2] *= 2.0
    half = max(3, round(SMOOTHING_HZ * length / rate) | 1) // 2
    seen = _averaged(expected, half) / _averaged(np.ones(len(expected)), half)
    seen = np.maximum(seen, 1.0 / (2 * half + 1))
    # smoothing the signal's power instead of the periodogram gives the same sum
    noisy = _averaged(power * slower / seen, half) / slower * apart
    parts = (noisy + _averaged(power, half) * (1.0 - apart)) * np.abs(spectrum) ** 2 / length
    oversampled = length / len(signal)
    return float(np.sum(parts)), float(0.5 * oversampled * np.sum(parts**2))


def _averaged(power: Array, half: int) -> Array:
    """Over so many neighbours to either side, folded back at both ends."""
    smooth = np.convolve(power, np.full(2 * half + 1, 1.0 / (2 * half + 1)))
    folded = smooth[half:-half]
    folded[1 : half + 1] += smooth[:half][::-1]
    folded[-half - 1 : -1] += smooth[-half:][::-1]
    return folded
