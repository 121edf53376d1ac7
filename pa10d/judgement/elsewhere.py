"""Is a new version worse than its parent where that was fitted, on motion the new fit has not seen?

A fit to slow motion knows little of bodies, one to few poses little of gravity. What it changes
there shows on other motion, first of all on the runs that the parent came from.
"""

from __future__ import annotations

from collections.abc import Sequence

from pa10d.common.words import rounded
from pa10d.judgement.band import common_band
from pa10d.judgement.judge import judged
from pa10d.judgement.one_floor import through
from pa10d.judgement.worse import worse
from pa10d.measurement.recording import Recording
from pa10d.model import TorqueModel


def worse_elsewhere(
    parent: TorqueModel, version: TorqueModel, runs: Sequence[Recording]
) -> list[str]:
    """A line per joint (none: no joint) whose error on these runs of the parent rose; what a run
    does not hold of what either needs says nothing."""
    cutoff = common_band([parent, version])
    before, after = through(parent, runs, cutoff), through(version, runs, cutoff)
    if not before or not after:
        return []
    was, now = judged(parent.name, before), judged(version.name, after)
    names = ", ".join(run.name for run in runs)
    return [
        f"joint {j + 1}: on {names}, which {parent.name} was fitted to, its error rises from "
        f"{rounded(was.rms[j], 3)} to {rounded(now.rms[j], 3)} "
        f"{parent.robot.torque_unit(j)}; where the model is to hold there too, fit to "
        "those runs as well"
        for j in worse(before, after)
    ]
