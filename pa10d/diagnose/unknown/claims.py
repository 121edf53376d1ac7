"""What is claimed of a joint's error where no effect explains it."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.common.words import listed
from pa10d.diagnose.constants import (
    BEYOND_NOISE,
    BEYOND_NOISE_LEVEL,
    BEYOND_SLOW_NOISE,
    CLAIMED_SHARE,
    COMES_AGAIN_LEVEL,
    MATERIAL_REST,
)
from pa10d.diagnose.unknown.between_runs import Apart
from pa10d.diagnose.unknown.common_cause import InCommon
from pa10d.diagnose.unknown.geometry import OtherGeometry
from pa10d.diagnose.unknown.humming import Hum
from pa10d.diagnose.unknown.ringing import SwingsOn
from pa10d.diagnose.unknown.rubbing import OtherFriction
from pa10d.diagnose.unknown.stepping import StepInTime
from pa10d.diagnose.unknown.structure import Structure
from pa10d.judgement import Judgement, Reversing, Turning
from pa10d.judgement.noise import REPEATS
from pa10d.judgement.repeatable import Repeatable

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Unnamed:
    """Structure of which no map says what it depends on: share of the joint's squared error that
    comes again with the motion, that motion predicts (of the fit side alone, where the held-out
    side moves elsewhere), that is gone in the middle of its strokes, that turns round with the
    joint, that is beyond any noise the data show, that depends on torque as it is read, that is one
    line in time at so many hertz, that motion sets swinging at so many, that is gone where the
    joint may change at so many seconds of these runs (empty: of every run), or that a law takes at
    the end of what its shape may be, in words, or that other joints tell of a base that sways by so
    many degrees or of stamps that scatter; best_from: what foretells it, in words; RMS N·m of that
    share."""

    joint: int
    share: float
    rms: float
    p_value: float
    witness: Literal[
        "again",
        "motion",
        "elsewhere",
        "turning",
        "reversing",
        "size",
        "reading",
        "hum",
        "ring",
        "step",
        "law",
        "unseen",
        "sway",
        "stamps",
    ]
    variables: tuple[str, ...] = ()
    hertz: float = float("nan")
    seconds: float = float("nan")
    runs: tuple[str, ...] = ()
    law: str = ""
    best_from: str = ""
    degrees: float = float("nan")

    @classmethod
    def of_hum(cls, hum: Hum) -> Unnamed:
        """A line in time."""
        return cls(hum.joint, hum.share, hum.rms, hum.p_value, "hum", hertz=hum.hertz)

    @classmethod
    def of_step(cls, step: StepInTime) -> Unnamed:
        """A change at one moment."""
        at, runs = step.seconds, step.runs
        return cls(step.joint, step.share, step.rms, step.p_value, "step", seconds=at, runs=runs)

    @property
    def step_words(self) -> str:
        """``gone if its friction or offset changes at t = 6 s of every run``."""
        where = listed(self.runs) or "every run"
        return f"gone if its friction or offset changes at t = {self.seconds:.3g} s of {where}"

    @classmethod
    def of_common(cls, one: InCommon) -> Unnamed:
        """What other joints tell of."""
        angle = float(np.degrees(one.size))
        return cls(one.joint, one.share, one.rms, one.p_value, one.cause, degrees=angle)

    @classmethod
    def of_ring(cls, ring: SwingsOn) -> Unnamed:
        """What motion sets swinging."""
        return cls(ring.joint, ring.share, ring.rms, ring.p_value, "ring", hertz=ring.hertz)


Unexplained = Structure | Unnamed | Apart | OtherGeometry | OtherFriction


def material(
    judged: Judgement, maps: Sequence[Structure]
) -> tuple[list[Structure], list[Structure]]:
    """Maps that are worth a claim, and slight ones: of a joint that stands at its noise floor
    already, and whose error without what the map says would hardly be smaller. Coarse encoders and
    the servo that answers to them leave such traces of the motion in an error that is noise."""
    least = 1.0 - 1.0 / MATERIAL_REST**2
    worth: list[Structure] = []
    slight: list[Structure] = []
    for m in maps:
        little = judged.ratio[m.joint] < MATERIAL_REST and m.share < least
        (slight if little else worth).append(m)
    return worth, slight


def unnamed(
    judged: Judgement,
    again: Sequence[Repeatable | None],
    known: Sequence[Unexplained],
    doubt: Array,
    by_size: bool = True,
    turned: Sequence[Turning | None] = (),
    reversed_: Sequence[Reversing | None] = (),
    silent: Collection[int] = (),
) -> list[Unnamed]:
    """Joints for which no map was found, and whose error, materially above the floor, comes again,
    is larger after reversals or turns round with the joint, or (by_size) is larger than noise can
    be. doubt (n,) N·m: what the uncertainty of the model's own coefficients may leave; that comes
    again, too, and is nothing missing; silent: joints of which no sample counts."""
    floor, rms = judged.floor.values, judged.rms
    named = {*(s.joint for s in known), *silent}
    out = []
    for j, seen in enumerate(again):
        if j in named:
            continue
        if seen is not None and comes_again(seen, len(again)):
            if rms[j] > np.hypot(MATERIAL_REST * floor[j], doubt[j]):
                size = float(rms[j]) * float(np.sqrt(min(seen.share, 1.0)))
                out.append(Unnamed(j, seen.share, size, seen.p_value, "again"))
        elif (after := _sure(turned, j)) is not None:
            if rms[j] > np.hypot(MATERIAL_REST * floor[j], doubt[j]):
                size = float(rms[j]) * float(np.sqrt(after.share))
                out.append(Unnamed(j, after.share, size, after.p_value, "turning"))
        elif (sided := _sure(reversed_, j)) is not None:
            if rms[j] > np.hypot(MATERIAL_REST * floor[j], doubt[j]):
                size = float(rms[j]) * float(np.sqrt(sided.share))
                out.append(Unnamed(j, sided.share, size, sided.p_value, "reversing"))
        elif by_size and rms[j] > np.hypot(_largest_noise(judged, j), doubt[j]):
            share = 1.0 - (floor[j] / rms[j]) ** 2
            size = float(rms[j]) * float(np.sqrt(share))
            out.append(Unnamed(j, float(share), size, BEYOND_NOISE_LEVEL / len(again), "size"))
    return out


def doubtful(judged: Judgement, fitted: Array, doubt: Array) -> Array:
    """(n,) N·m: the doubt of the model's coefficients, where it can be why a joint keeps an error.
    Of one whose error on the fit side, to which they were fitted, is larger than noise can be
    (fitted, (n,) N·m), it is not."""
    most = np.array([_largest_noise(judged, j) for j in range(len(fitted))])
    return np.where(fitted > most, 0.0, doubt)


def _sure(heard: Sequence[Turning | Reversing | None], j: int) -> Turning | Reversing | None:
    """What says that a joint's error knows of reversals more than noise would by accident."""
    seen = heard[j] if heard else None
    sure = seen is not None and seen.p_value * len(heard) < COMES_AGAIN_LEVEL
    return seen if seen is not None and sure and seen.share > CLAIMED_SHARE else None


def _largest_noise(judged: Judgement, j: int) -> float:
    """N·m. Only its size speaks for such an error, so it has to be many times the floor, doubt
    of it included; more where slow noise was not seen, because no motion came again. Where noise
    grows towards the band, it may be as much stronger there as it then can be at most."""
    times = BEYOND_NOISE if judged.floor.methods[j] == REPEATS else BEYOND_SLOW_NOISE
    times = max(times, float(judged.floor.slow[j]))
    sure = scipy.stats.norm.isf(BEYOND_NOISE_LEVEL / len(judged.rms))
    return times * float(judged.floor.values[j] + sure * judged.floor.errors[j])


def comes_again(seen: Repeatable, joints: int) -> bool:
    """Is it no accident, among so many joints, that two passes of a motion leave alike errors?"""
    return seen.p_value * joints < COMES_AGAIN_LEVEL and seen.share > CLAIMED_SHARE
