"""Real robots' recordings, with one known effect put into their torque: it is named all the same.

The laws are written here from the measured motion (Lorentz' bell for Stribeck, v·|v| for drag, …),
not taken from the library; the robots' own effects and their noise stay as they are.
"""

from __future__ import annotations

import importlib
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
import scipy.signal

from pa10d.diagnose.procedure import diagnose
from pa10d.measurement.recording import Recording
from pa10d.model.notes import CutoffNote

sys.path.append(str(Path(__file__).parents[2] / "scripts"))
bench_real = importlib.import_module("bench_real")

SIZE = 1.5  # RMS of what textbook friction cannot absorb, times the model's error on that joint


@dataclass(frozen=True)
class Scale:
    """Of the motion to fit: rad, rad, rad/s."""

    middle: float
    span: float
    fast: float


@dataclass(frozen=True)
class Motion:
    """Of the joint that gets the effect, and the next one's speed."""

    q: np.ndarray
    v: np.ndarray
    other: np.ndarray
    torque: np.ndarray

    @property
    def scale(self) -> Scale:
        fast = float(np.quantile(np.abs(self.v), 0.98))
        return Scale(float(np.median(self.q)), float(np.ptp(self.q)), fast)


def sign(v: np.ndarray, s: Scale) -> np.ndarray:
    return np.tanh(v / (0.005 * s.fast))


def worn_spot(m: Motion, s: Scale) -> np.ndarray:
    return sign(m.v, s) * np.exp(-0.5 * ((m.q - s.middle) / (0.1 * s.span)) ** 2)


def stop(m: Motion, s: Scale) -> np.ndarray:
    return np.maximum(m.q - s.middle - 0.2 * s.span, 0.0)


def load(m: Motion, s: Scale) -> np.ndarray:
    return sign(m.v, s) * np.abs(m.torque)


def drag(m: Motion, s: Scale) -> np.ndarray:
    return m.v * np.abs(m.v)


def elastic(m: Motion, s: Scale) -> np.ndarray:
    return m.q - s.middle


def slow(m: Motion, s: Scale) -> np.ndarray:
    return sign(m.v, s) / (1.0 + (m.v / (0.08 * s.fast)) ** 2)


def swing(m: Motion, s: Scale) -> np.ndarray:
    return np.cos(36.0 * m.q + 1.0)


def pair(m: Motion, s: Scale) -> np.ndarray:
    return sign(m.v + m.other, s)


CASES = [
    ("panda", 6, "load_friction", load),
    ("panda", 3, "torque_ripple", swing),
    ("panda", 7, "contact", stop),
    ("kuka_lwr4", 1, "position_friction", worn_spot),
    ("kuka_lwr4", 1, "contact", stop),
    ("kuka_lwr4", 7, "nonlinear_viscous", drag),
    ("ur10", 2, "nonlinear_viscous", drag),
    ("kuka_lwr4", 7, "spring", elastic),
    ("ur10", 5, "stribeck", slow),
    ("ur10", 6, "position_friction", worn_spot),
    ("ur10", 3, "contact", stop),
    ("kr300", 1, "spring", elastic),
    ("kr300", 2, "position_friction", worn_spot),
    ("kr300", 5, "coupling_friction", pair),
]


def motion(run: Recording, joint: int, cutoff: float) -> Motion:
    sos = scipy.signal.butter(2, min(0.9, 4.0 * cutoff / run.rate), output="sos")
    v = np.gradient(scipy.signal.sosfiltfilt(sos, run.q, axis=0), run.t, axis=0)
    own, other = v[:, joint], v[:, (joint + 1) % run.joints]
    return Motion(run.q[:, joint], own, other, run.tau[:, joint])


def rms_beside_friction(torque: np.ndarray, m: Motion, s: Scale) -> float:
    friction = np.column_stack([m.v, sign(m.v, s)])
    left = torque - friction @ np.linalg.lstsq(friction, torque, rcond=None)[0]
    return float(np.sqrt(np.mean(left**2)))


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "joint", "expected", "law"), CASES, ids=[f"{c[0]}-{c[2]}-J{c[1]}" for c in CASES]
)
def test_what_is_put_into_a_real_recording_is_named(shared_data, name, joint, expected, law):
    case, j = bench_real.case(name), joint - 1
    joints = (j, j + 1) if expected == "coupling_friction" else (j,)
    cutoff = case.given.cutoff
    plain = case.identify()
    error = case.rms(plain)[j]
    first = motion(case.train[0], j, cutoff)
    scale = first.scale
    size = SIZE * error / rms_beside_friction(law(first, scale), first, scale)

    def spoilt(run: Recording) -> Recording:
        tau = run.tau.copy()
        tau[:, joints] += size * law(motion(run, j, cutoff), scale)[:, None]
        return replace(run, tau=tau)

    case = replace(case, train=[spoilt(r) for r in case.train], valid=spoilt(case.valid))
    textbook = case.identify()
    asked = replace(
        textbook, notes=replace(textbook.notes, cutoff=CutoffNote(textbook.cutoff, "user"))
    )
    found = diagnose(asked, case.train, [case.valid])
    places = [(f.term.effect_id, f.term.joints) for f in found.findings]
    assert (expected, joints) in places
    after = found.findings[-1].rms_after[j]
    assert after < 0.9 * found.rms[j]
    assert after < 1.15 * error  # what the textbook left before anything was put in
