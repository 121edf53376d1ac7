"""The one judgement of a model on runs; every command, plot, page and report asks here."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject, plain
from pa10d.common.words import joint_words
from pa10d.judgement.band import common_band, in_band
from pa10d.judgement.noise import NoiseFloor, noise_floor
from pa10d.judgement.one_floor import (
    beside_its_own,
    least_floor,
    of_own_runs,
    or_of_own_runs,
    through,
)
from pa10d.judgement.residuals import RunResidual, hidden_in, run_residual
from pa10d.judgement.scores import scores
from pa10d.measurement.recording import Recording
from pa10d.model import TorqueModel

Array = NDArray[np.float64]

MASK = "in motion, clear of reversals"
"""Which samples count. At a standstill, and where the filter still sees one, friction is anything
between plus and minus stiction: an error there says nothing about the model."""


MATERIAL = 1.2
"""Times the noise floor: policy and no statistics. An error of no more is worth no experiment."""

MOST = 900_000
"""Samples in all by which a model is judged: half an hour at 500 Hz. All of them have to be in
memory, in some ten channels per joint."""


@dataclass(frozen=True)
class Judgement:
    """rms (n,) N·m of one model, both sides behind ``cutoff`` Hz, over the samples of ``mask``;
    hidden: joints (0-based) whose torque is known nowhere, whose rms says nothing."""

    model: str
    runs: tuple[str, ...]
    cutoff: float
    rms: Array
    floor: NoiseFloor
    mask: str = MASK
    hidden: tuple[int, ...] = ()

    @property
    def ratio(self) -> Array:
        """(n,): error over noise floor; nan where the floor is not known."""
        return self.rms / self.floor.values

    def document(self) -> JsonObject:
        """As JSON."""
        return {
            "runs": list(self.runs),
            "cutoff_hz": self.cutoff,
            "mask": self.mask,
            "rms": plain(self.rms),
            **self.floor.document(),
        }


def judge(
    model: TorqueModel, recordings: Sequence[Recording], cutoff: float | None = None
) -> Judgement:
    """cutoff: Hz; default: the model's own band."""
    return judge_alike([model], recordings, cutoff)[0]


def judge_alike(
    models: Sequence[TorqueModel],
    recordings: Sequence[Recording],
    cutoff: float | None = None,
    beside: Sequence[TorqueModel] = (),
) -> list[Judgement]:
    """Several models on the same runs in one band (default: the narrowest of their own) with one
    floor, also through the models ``beside``; of very long ones by the middle of each, which the
    mask says."""
    if not recordings:
        raise UserError("nothing to judge by: expected at least one run")
    cutoff = common_band(models) if cutoff is None else cutoff
    seen = [in_band(model, cutoff) for model in models]
    mask = (
        MASK
        if (most := longest(MOST, recordings)) is None
        else (f"{MASK}, of each run no more than its {most} middle samples")
    )
    recordings = no_more_than(MOST, recordings)
    found = [judged(m.name, [run_residual(m, run) for run in recordings], mask) for m in seen]
    for other in beside:
        residuals = through(other, recordings, cutoff)
        found += [judged(other.name, residuals, mask)] if residuals else []
    known = of_own_runs([*models, *beside], cutoff)
    return [with_known_floor(one, known) for one in with_one_floor(found)[: len(models)]]


def with_one_floor(found: Sequence[Judgement]) -> list[Judgement]:
    """Judgements on the same runs in one band, all with the least floor that any of them saw, and
    what each makes of the angles' noise."""
    floor = least_floor([one.floor for one in found])
    return [replace(one, floor=beside_its_own(floor, one.floor)) for one in found]


def with_known_floor(one: Judgement, known: Array | None) -> Judgement:
    """With the noise of the model's own runs, (n,) N·m, where these runs do not show theirs."""
    return replace(one, floor=or_of_own_runs(one.floor, known, one.rms))


def longest(most: int, recordings: Sequence[Recording]) -> int | None:
    """Samples that each run may have where all together are to have no more than ``most``: runs
    that have fewer leave theirs to the others. None where there are no more."""
    lengths = sorted(len(one.t) for one in recordings)
    if sum(lengths) <= most:
        return None
    for k, samples in enumerate(lengths):
        share = most // (len(lengths) - k)
        if samples > share:
            return share
        most -= samples
    raise AssertionError("unreachable: all lengths together are more than most")


def no_more_than(most: int, recordings: Sequence[Recording]) -> Sequence[Recording]:
    """The runs; where they have more samples in all, the middle of the longest of them."""
    share = longest(most, recordings)
    if share is None:
        return recordings
    out = []
    for one in recordings:
        spare = max(0, len(one.t) - share)
        out.append(one.part(spare // 2, spare // 2 + share, "") if spare else one)
    return out


def mask_of(runs: Sequence[RunResidual], mask: str = MASK) -> str:
    """Which samples count, in words, where models with bristles leave out how they were bent, and
    those in which joints share surfaces leave out where these stick."""
    bent = sorted({joint for run in runs for joint in run.bent})
    if bent:
        whose = "its" if len(bent) == 1 else "their"
        mask += f", {joint_words(bent)} once {whose} bristles have slid"
    sharing = sorted({joint for run in runs for joint in run.sharing})
    if sharing:
        mask += f", {joint_words(sharing)} where what they share slips"
    return mask


def first_and_last(first: Judgement, last: Judgement) -> str:
    """Which samples count for the last of several versions, in words, and for those before it,
    which lack what leaves some of them out."""
    if first.mask == last.mask:
        return last.mask
    return f"{last.mask} (before that was found: {first.mask})"


def judged(model: str, runs: Sequence[RunResidual], mask: str = MASK) -> Judgement:
    """The same of runs that a model was held against already."""
    cutoff = runs[0].equation.lowpass.cutoff
    names = tuple(run.name for run in runs)
    return Judgement(
        model,
        names,
        cutoff,
        scores(runs).rms,
        noise_floor(runs),
        mask_of(runs, mask),
        tuple(hidden_in(runs)),
    )
