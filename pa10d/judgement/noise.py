"""The error that a perfect model would leave: measurement noise within the band of the fit.

Three ways to see it. Where a motion comes again, the difference of the passes is noise and
nothing else. Where a joint stands still, its torque's wavering is. And above the cut-off, where
little motion reaches, the spectrum of torque or error (whichever is smaller there: one still has
motion in it, the other the noise of twice differentiated angles), without what torque shares with
the angle (a servo's answer to its encoder's noise, which grows with frequency), is: white noise of
that strength, behind such smoothing as it shows, would leave so much below (``extrapolated``). The
last two are lower bounds (noise may be stronger in motion, or at low frequencies), so the larger
is taken where no motion comes again, and what the angles' noise makes of the torque (``encoder``)
is added; but not a standstill whose torque wavers more than the error in motion, because then it is
creep or braking. And never more than the error itself: friction that jumps at a reversal reaches
above any cut-off.

A spectrum whose smoothing cannot be told shows no noise of the band: one that falls on and on, or
one whose steps are coarser than what wavers. Then the floor is not known. The torques of one robot
come through one kind of electronics: where the noise of most looks (a joint in a run) may roll off
within the band, that of the others is not believed either. And a joint stands still only with all
others: what they load it with, static friction takes off it, and nobody knows how much.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.common.jsonable import JsonObject, plain
from pa10d.judgement.extrapolated import Extrapolated, Look, extrapolated, looked_at
from pa10d.judgement.repeats import differences
from pa10d.judgement.residuals import RunResidual
from pa10d.judgement.scores import moving, scores
from pa10d.measurement.spans import spans
from pa10d.regression.equation import motion_band

Array = NDArray[np.float64]

REPEATS, STANDSTILL, ABOVE = "repeated motion", "standstill", "high frequencies"
ANGLES = "the angles' noise"
FEWEST = 50  # samples of a difference
REST = 1.0  # s of standstill, at least
WINDOW = 6.0  # periods of the cut-off: of one look at a joint at rest
STILL = 1e-3  # of a joint's range: it may move this much and still stand
SECONDS = 1.0  # of one segment of the spectrum
ENOUGH = 4  # segments that speak for a run
BAND = (1.5, 4.0)  # cut-offs between which the error's spectrum is taken as the noise's
NEARLY_WHITE = 0.5  # half-way from the flat spectrum of white noise to a random walk's 1/f²
TOP = 0.45  # of the sampling rate: up to where the spectrum is looked at
WIDEST = 1.0  # relative standard error of a variance, from which on it may as well be nothing
ANSWERED = 0.5  # of a torque's power, below which most of it is a servo's answer to its encoder
ALL = 1.2  # times what the angles' noise makes: an error of no more is that, whatever else there is
COARSE = 4.0  # times the power of rounding below which a spectrum is that of the rounding


@dataclass(frozen=True)
class NoiseFloor:
    """values (n,) N·m, RMS behind the equation's low-pass, nan where this data does not tell;
    methods (n): how each was found, None where it was not; errors (n,): standard errors, N·m;
    slow (n,): how many times as much noise there may be within the band, if it goes on growing
    towards rest as it does above (1: slow noise was seen with it, as motion came again, or the
    spectrum is as flat as that of noise that has none; inf: nobody can tell)"""

    values: Array
    methods: tuple[str | None, ...]
    errors: Array
    slow: Array

    @property
    def hardly_known(self) -> NDArray[np.bool_]:
        """(n,) True where it may as well be nothing: its error is as large as itself. How sure that
        of the model's own runs was nobody noted; a motion that comes again shows it for certain."""
        again = np.array([method == REPEATS for method in self.methods])
        with np.errstate(invalid="ignore"):
            return np.asarray(self.errors >= self.values) & (self.values > 0.0) & ~again

    def document(self) -> JsonObject:
        """As JSON; null: not known from this data."""
        return {
            "noise_floor": plain(self.values),
            "noise_floor_from": list(self.methods),
            "noise_floor_std_error": plain(self.errors),
        }


@dataclass(frozen=True)
class _Seen:
    """A variance (N·m)², from how many looks, and how much these scatter about it (relative).
    fall: of the spectrum with frequency; 0 is flat, 1 as 1/f² (nan: it cannot be seen)."""

    variance: float
    looks: int
    scatter: float
    fall: float = float("nan")

    @property
    def error(self) -> float:
        """Relative, of the variance."""
        return self.scatter / float(np.sqrt(max(self.looks, 1)))


NOTHING = _Seen(0.0, 0, 0.0)
ROLLED_OFF = _Seen(0.0, 0, 0.0, fall=float("inf"))
UNKNOWN = float("nan"), None, float("nan"), float("inf")


def noise_floor(runs: Sequence[RunResidual]) -> NoiseFloor:
    """Of several runs together, per joint the best way that they allow."""
    runs = list(runs)
    passes = differences(runs)
    above = _above(runs, len(passes))
    looks = [part for parts in above for part in parts]
    smoothed = looks.count(ROLLED_OFF) > len(looks) / 2
    found = [
        _floor(runs, j, passes[j], NOTHING if smoothed else _pooled(parts))
        if any(j not in run.rested for run in runs)
        else UNKNOWN
        for j, parts in enumerate(above)
    ]
    values, methods, errors, slow = zip(*found, strict=True)
    return NoiseFloor(np.array(values), tuple(methods), np.array(errors), np.array(slow))


def _floor(
    runs: list[RunResidual], joint: int, passes: list[Array], above: _Seen
) -> tuple[float, str | None, float, float]:
    together = np.concatenate(passes) if passes else np.empty(0)
    if len(together) >= FEWEST:
        value = float(np.sqrt(np.mean(together**2)))
        return value, REPEATS, value / np.sqrt(2.0 * max(_independent(passes), 1.0)), 1.0
    used = moving(runs, joint)
    rest, left = _pooled([_at_rest(run, joint) for run in used]), float(scores(used).rms[joint])
    if not rest.looks or rest.variance >= left**2 or rest.variance <= 0.0:
        rest = NOTHING
    best = rest if rest.variance > above.variance else above
    made, doubt = made_by_angles(used, joint)
    if not best.looks:
        known = made * ALL > left  # else nobody knows what the torque's own noise adds
        return (min(made, left), ANGLES, doubt, float("inf")) if known else UNKNOWN
    own = float(np.sqrt(best.variance))
    found = float(np.hypot(own, made))
    value = min(found, left)
    unsure = float(np.hypot(0.5 * own**2 * best.error, made * doubt)) / found
    error = max(unsure, found - value)
    method = ANGLES if made > own else STANDSTILL if best is rest else ABOVE
    return value, method, error, _slow(used, above)


def made_by_angles(runs: Sequence[RunResidual], joint: int) -> tuple[float, float]:
    """N·m RMS that noise of the angles makes of several runs together, and its standard error."""
    counts = np.array([run.judged[:, joint].sum() for run in runs], dtype=float)
    values, errors = np.array([[part[joint] for part in run.of_angles] for run in runs]).T
    share = counts / max(float(counts.sum()), 1.0)
    value = float(np.sqrt(share @ values**2))
    return value, float(share @ (values * errors)) / value if value > 0.0 else 0.0


def _slow(runs: list[RunResidual], above: _Seen) -> float:
    """How many times as strong (RMS) as its level at the far end of what was seen above the band
    noise is within, that grows from there as a random walk does (1/f²), the slowest noise that
    sensors are known for, down to one period of the run. A spectrum that falls off faster is that
    of a motion and of what friction's jumps leave of it, and no reason to allow noise more."""
    if not above.looks or not np.isfinite(above.fall):
        return float("inf")
    if above.fall < NEARLY_WHITE:
        return 1.0
    periods = max(r.equation.lowpass.cutoff * len(r.error) / r.equation.rate for r in runs)
    return float(BAND[1] * np.sqrt(max(periods, 1.0) - 1.0))


def _independent(passes: list[Array]) -> float:
    """How many independent samples these differences are worth (Bartlett)."""
    worth = 0.0
    for x in passes:
        size = scipy.fft.next_fast_len(2 * len(x), real=True)
        gamma = scipy.fft.irfft(np.abs(scipy.fft.rfft(x, size)) ** 2, size)[: len(x) // 4 + 1]
        rho = gamma / max(float(gamma[0]), 1e-300)
        worth += len(x) / (1.0 + 2.0 * float(np.sum(rho[1:] ** 2)))
    return worth


def _above(runs: list[RunResidual], joints: int) -> list[list[_Seen]]:
    """Per joint, of each run in which it moves: the variance behind the low-pass of the noise whose
    spectrum error or torque have above it."""
    spectra = [[_spectrum(run, j) for run in moving(runs, j)] for j in range(joints)]
    told: dict[int, Extrapolated | None] = {}
    rates = {s.rate for of_joint in spectra for s in of_joint if s is not None}
    for rate in rates:
        of_rate = [s for of_joint in spectra for s in of_joint if s is not None and s.rate == rate]
        found = extrapolated([s.look for s in of_rate])
        told |= {id(s): one for s, one in zip(of_rate, found, strict=True)}
    return [[NOTHING if s is None else s.seen(told[id(s)]) for s in of_j] for of_j in spectra]


@dataclass(frozen=True)
class _Spectrum:
    """What one joint shows above the band in one run, at rate Hz; segments: how many looks it is,
    fall: as of ``_Seen``."""

    look: Look
    rate: float
    segments: int
    fall: float

    def seen(self, found: Extrapolated | None) -> _Seen:
        """What that says of the noise within the band."""
        if found is None:
            return ROLLED_OFF
        if found.error > WIDEST:
            return NOTHING
        scatter = found.error * float(np.sqrt(self.segments))
        return _Seen(found.variance, self.segments, scatter, self.fall)


def _spectrum(run: RunResidual, joint: int) -> _Spectrum | None:
    """None where its steps are coarser than what wavers."""
    lowpass, torque = run.equation.lowpass, run.equation.raw_tau[:, joint]
    segments = _segments(run, joint)
    f, power, whole = _periodograms(
        np.array([[x[s] for s in segments] for x in (run.raw_error[:, joint], torque)]),
        np.array([run.seen.q[s] for s in segments]).transpose(2, 0, 1)[joint],
        lowpass.rate,
    )
    top = min(BAND[1] * lowpass.cutoff, 0.4 * lowpass.rate)
    low = min(BAND[0] * lowpass.cutoff, 0.5 * top)
    above, near = (f >= low) & (f <= TOP * lowpass.rate), (f >= low) & (f <= top)
    seen = above & (f <= motion_band(lowpass.rate, lowpass.cutoff))
    if power[1][:, seen].mean() < ANSWERED * whole[:, seen].mean():
        above = seen  # beyond that the angle was filtered, and nothing shows what it shares
    weaker = min(power, key=lambda p: float(np.median(p[:, near].mean(axis=1))))
    wavering = float(np.median(weaker[:, above].mean(axis=1))) * 0.5 * lowpass.rate
    if wavering < COARSE * _step(torque) ** 2 / 12.0:
        return None
    length = segments[0].stop - segments[0].start
    look = looked_at(power, length, above, lowpass, _repeated(torque))
    return _Spectrum(look, lowpass.rate, len(segments), _fall(f[near], weaker[:, near]))


def _periodograms(
    signals: Array, angle: Array, rate: float
) -> tuple[NDArray[np.float64], Array, Array]:
    """f Hz; densities of signals (signals, segments, N), in place of the last one's of what it does
    not share with the angle (segments, N), where it shares motion, or a servo's answer to its
    encoder's noise; and the last one's own."""
    window = scipy.signal.get_window("hann", signals.shape[-1])
    whole = np.concatenate([signals, angle[None]])
    x = scipy.fft.rfft(scipy.signal.detrend(whole, type="linear") * window, axis=-1)
    power = 2.0 * np.abs(x) ** 2 / (rate * float(window @ window))
    count = len(angle)
    cross = np.abs((x[-2] * x[-1].conj()).mean(axis=0)) ** 2
    both = (np.abs(x[-2]) ** 2).mean(axis=0) * (np.abs(x[-1]) ** 2).mean(axis=0)
    shared = np.clip(cross / np.maximum(both, 1e-300), 0.0, 1.0)
    alone = power[-2] * (1.0 - shared) * count / max(count - 1, 1)
    return (
        scipy.fft.rfftfreq(signals.shape[-1], 1.0 / rate),
        np.stack([*power[:-2], alone]),
        power[-2],
    )


def _repeated(torque: Array) -> float:
    """How often each value comes, one after the other, on average."""
    return len(torque) / (1.0 + np.count_nonzero(np.diff(torque)))


def _fall(f: Array, power: Array) -> float:
    """The lower half of a band (in octaves) against the upper one; power (segments, f). Of 1/f² the
    ratio of the halves is that of the band's edges."""
    lower = f < np.sqrt(f[0] * f[-1]) if len(f) else np.zeros(0, dtype=bool)
    if not lower.any() or f[0] <= 0.0:
        return float("nan")
    ratio = power[:, lower].mean() / max(float(power[:, ~lower].mean()), 1e-300)
    return float(np.log(max(ratio, 1e-300)) / np.log(f[-1] / f[0]))


def _segments(run: RunResidual, joint: int) -> list[slice]:
    """Stretches of raw samples to take a spectrum of: clear of reversals, whose jolt reaches above
    any cut-off, where there are enough; else in motion; else all."""
    rate = run.equation.lowpass.rate
    for seconds, mask in (
        (0.5 * SECONDS, run.raw_judged[:, joint]),
        (SECONDS, run.raw_counts[:, joint]),
        (SECONDS, np.ones(len(run.raw_error), dtype=bool)),
    ):
        length = min(len(mask), max(32, int(seconds * rate)))
        starts = range(0, len(mask) - length + 1, length)
        found = [slice(s, s + length) for s in starts if mask[s : s + length].all()]
        if len(found) >= ENOUGH or (found and mask.all()):
            return found
    return found


def _step(torque: Array) -> float:
    """N·m: the step in which a torque (N,) is reported; 0 where it takes any value."""
    levels = np.unique(torque)
    if len(levels) < 2 or len(levels) > 0.5 * len(torque):
        return 0.0
    return float(np.median(np.diff(levels)))


def _at_rest(run: RunResidual, joint: int) -> _Seen:
    """Variance of the filtered torque about straight lines while the joint stands still, the
    median over short windows.

    A servo that hunts within stiction winds its torque up and lets it go: within a window the
    winding is a line, and the median does not see the letting go.
    """
    settle = run.equation.lowpass.settle
    q = run.decimated(run.seen.q)[:, joint]
    reach = STILL * float(np.ptp(q))
    still = np.asarray(~run.equation.moving.any(axis=1))
    length = max(8, round(WINDOW * run.equation.rate / run.equation.lowpass.cutoff))
    variances = []
    for start, stop in spans(still):
        start, stop = start + settle, stop - settle  # the filter still sees the motion there
        if stop - start < REST * run.equation.rate or np.ptp(q[start:stop]) > reach:
            continue
        for begin in range(start, stop - length + 1, length):
            rest = scipy.signal.detrend(run.measured[begin : begin + length, joint])
            variances.append(float(np.mean(rest**2)))
    if not variances:
        return NOTHING
    # a line takes two of the 2·WINDOW independent values that a window has in the band
    share = 1.0 - 1.0 / WINDOW
    level = float(np.median(variances))
    scatter = float(np.std(variances)) / max(level, 1e-300)
    return _Seen(level / share, len(variances), scatter)


def _pooled(parts: list[_Seen]) -> _Seen:
    """Of several runs: each as often as it was looked at."""
    looks = sum(part.looks for part in parts)
    if not looks:
        return NOTHING
    variance = sum(part.variance * part.looks for part in parts) / looks
    scatter = sum(part.scatter * part.looks for part in parts) / looks
    return _Seen(variance, looks, scatter, float(np.max([p.fall for p in parts if p.looks])))
