"""What a search promised of a new version, and what that version achieves as it is stored."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pa10d.judgement import RunResidual, judged, worse
from pa10d.model import TorqueModel

Array = NDArray[np.float64]


def delivery(
    promised: Array, before: Sequence[RunResidual], after: Sequence[RunResidual]
) -> dict[str, Any]:
    """A note for the new version, all on the same held-out samples in one band.

    promised: (n,) N·m by which the search judged; before, after: the held-out side as the given
    model saw it, before anything was refitted, and as the new version does
    """
    old, new = judged("before", before), judged("after", after)
    return {
        "before": old.rms.tolist(),
        "promised": promised.tolist(),
        "achieved": new.rms.tolist(),
        "worse": [j + 1 for j in worse(before, after)],
        "cutoff_hz": new.cutoff,
        "mask": new.mask,
    }


def delivered(model: TorqueModel) -> dict[str, Any]:
    """The note as a document has it: ``promised`` and ``achieved``, (n,) N·m each, ``before`` (of
    the model it was made from, as that one is) and ``worse`` (joints from 1)."""
    note = model.notes.get("delivery", {})
    keys = ("before", "promised", "achieved", "worse", "cutoff_hz", "mask")
    return {key: note.get(key) for key in keys}


def warnings(model: TorqueModel) -> list[str]:
    """One line per joint that became worse."""
    found = delivered(model)
    return [
        f"joint {j}: its error rises from {found['before'][j - 1]:.3g} to "
        f"{found['achieved'][j - 1]:.3g} {model.robot.torque_unit(j - 1)} against "
        f"{model.parent or 'the model as given'}, which stays as it is"
        for j in found["worse"] or ()
    ]
