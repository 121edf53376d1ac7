"""The cut-off of the equation, chosen from the data.

Beyond some frequency the measured torque no longer follows the motion: what is left is noise of
the torque sensor, and, growing with the fourth power of frequency, noise of the encoder that two
differentiations and the inertia turn into torque. A first fit with a wide band tells for every
joint the frequency at which the coherence of measured and modelled torque falls below one half
(as much noise as signal). The cut-off is MARGIN times the joints' median, because the filter
should not bend what is still signal; but no higher than where the encoder's noise, integrated
over the band, reaches a quarter of the torque sensor's, no higher than a twentieth of the sampling
rate, and no higher than any model is judged. Within the first two it is wide enough to leave half
of the motion: a narrow filter remembers ends, rests and reversals for long, and short runs of fast
joints have little else (see ``pa10d.identify.band``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.identify.band import wide_enough
from pa10d.judgement.band import HIGHEST_HZ, SHORT_MOTION
from pa10d.measurement.recording import Recording
from pa10d.model import TorqueModel
from pa10d.regression.equation import prepare

Array = NDArray[np.float64]

MARGIN = 2.0
SHARE = 0.05  # of the sampling rate: 20 samples a period, or held torques and signs look coarse
PROBE, PROBE_SHARE = 40.0, 0.2  # Hz and share of the sampling rate of the first fit
SECONDS = 4.0  # of one spectral segment
LONGEST = 60_000  # samples of a run that are looked at
ENCODER_SHARE = 0.25
FEWEST_PERIODS = 16.0  # of the cut-off in the shortest run, half of which the ends take


@dataclass(frozen=True)
class Cutoff:
    """hertz: the choice; signal (n,) Hz where each joint's torque falls to the noise; encoder (n,)
    Hz beyond which its encoder would add too much; limited_by: what decided."""

    hertz: float
    signal: Array
    encoder: Array
    limited_by: str


def probe_cutoff(recordings: Sequence[Recording]) -> float:
    """Hz of the wide band of the first fit."""
    return min(PROBE, PROBE_SHARE * min(r.rate for r in recordings))


def choose_cutoff(model: TorqueModel, recordings: Sequence[Recording]) -> Cutoff:
    """From a model that was fitted with a wide band."""
    coarse = SHARE * min(r.rate for r in recordings)
    highest = min(coarse, HIGHEST_HZ)
    spectra = [_Spectra(model, r) for r in recordings]
    widest = PROBE_SHARE * min(r.rate for r in recordings)
    signal = np.array([_falls(spectra, j, widest) for j in range(model.robot.n)])
    encoder = np.array([_encoder_limit(spectra, j, widest) for j in range(model.robot.n)])
    wanted, allowed = MARGIN * float(np.median(signal)), float(np.median(encoder))
    shortest = min(r.duration for r in recordings)
    lowest = min(FEWEST_PERIODS / shortest, highest)
    found = float(np.clip(min(wanted, allowed), lowest, highest))
    chosen = wide_enough(recordings, found, min(allowed, coarse))
    digits = 1 - int(np.floor(np.log10(chosen)))
    reason = "torque falls to the noise" if wanted <= allowed else "encoder noise"
    if min(wanted, allowed) > highest:
        reason = "band of the motion" if highest == HIGHEST_HZ else "sampling rate"
    if chosen > found:
        reason = SHORT_MOTION
    return Cutoff(round(chosen, digits), signal, encoder, reason)


class _Spectra:
    """Densities of one run: measured, modelled and rigid torque, and the cross density."""

    def __init__(self, model: TorqueModel, recording: Recording) -> None:
        spare = max(0, len(recording.t) - LONGEST) // 2
        part = recording.part(spare, len(recording.t) - spare, "")
        run = prepare(part, model.robot, model.cutoff, model.shift, channel=model.channel)
        context = model.contextualise(run.context)
        modelled = model.predict(run.context)
        length = min(len(part.t), int(SECONDS * part.rate))
        options = {"fs": part.rate, "nperseg": length, "axis": 0}
        self.f, cross = scipy.signal.csd(run.raw_tau, modelled, **options)
        self.cross = cross.real
        self.measured = scipy.signal.welch(run.raw_tau, **options)[1]
        self.modelled = scipy.signal.welch(modelled, **options)[1]
        self.rigid = scipy.signal.welch(context.load, **options)[1]

    def band(self, density: Array, low: float, high: float) -> Array:
        """Sum of a density over a band; at least one frequency counts."""
        k = (self.f >= low) & (self.f < high)
        if not k.any():
            k[np.argmin(np.abs(self.f - low))] = True
        return np.asarray(density[k].sum(axis=0))


def _falls(spectra: Sequence[_Spectra], joint: int, highest: float) -> float:
    """Hz: lower edge of the first third-octave, above the strongest one, from which on (two in a
    row) less than half of the torque is coherent."""
    edges = 0.25 * 2.0 ** (np.arange(int(3 * np.log2(highest / 0.25)) + 2) / 3)
    power, coherent = [], []
    for low, high in pairwise(edges):
        cross, measured, modelled = (
            sum(float(s.band(getattr(s, which), low, high)[joint]) for s in spectra)
            for which in ("cross", "measured", "modelled")
        )
        power.append(measured)
        coherent.append(max(cross, 0.0) ** 2 / max(measured * modelled, 1e-300))
    first = int(np.argmax(power))
    noise = [c < 0.5 for c in coherent]
    for k in range(first, len(noise) - 1):
        if noise[k] and noise[k + 1]:
            return float(edges[k])
    return highest


def _encoder_limit(spectra: Sequence[_Spectra], joint: int, highest: float) -> float:
    """Hz: highest cut-off for which ∫ a·f⁴ df stays below a quarter of the torque's noise, with a
    from the rigid torque's spectrum above the motion and the noise from the measured torque's."""
    limits = []
    for s in spectra:
        top = min(100.0, 0.35 * 2 * s.f[-1])
        high = (s.f > 0.4 * top) & (s.f < top)
        growth = float(np.median(s.rigid[high, joint] / s.f[high] ** 4))
        noise = float(np.median(s.measured[high, joint]))
        limits.append((5 * ENCODER_SHARE * noise / max(growth, 1e-300)) ** 0.25)
    return float(min(np.median(limits), highest))
