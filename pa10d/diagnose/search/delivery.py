"""What a search promised of a new version, and what that version achieves as it is stored."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import NDArray

from pa10d.common.words import rounded
from pa10d.diagnose.constants import MUCH_WORSE
from pa10d.judgement import RunResidual, judged, worse
from pa10d.model import Delivery, TorqueModel

Array = NDArray[np.float64]


def delivery(
    promised: Array,
    before: Sequence[RunResidual],
    after: Sequence[RunResidual],
    silent: Collection[int] = (),
) -> Delivery:
    """Of a new version. before, after: the held-out side as the given model saw it, before anything
    was refitted, and as the new version does; promised: (n,) N·m; silent: joints of
    which nothing can be promised."""
    old, new = judged("before", before), judged("after", after)
    promised = np.where(np.isin(np.arange(len(promised)), list(silent)), new.rms, promised)
    return Delivery(
        before=tuple(old.rms.tolist()),
        promised=tuple(promised.tolist()),
        achieved=tuple(new.rms.tolist()),
        worse=tuple(j + 1 for j in worse(before, after)),
        cutoff_hz=new.cutoff,
        mask=new.mask,
    )


def delivered(model: TorqueModel) -> Delivery:
    """What the model's note says of it."""
    return model.notes.delivery or Delivery()


def warnings(model: TorqueModel, beside: bool = False) -> list[str]:
    """One line per joint that became worse, surely or by much; beside: than with what its parent
    lacked, which was given to it first."""
    found = delivered(model)
    if found.before is None or found.achieved is None:
        return []
    lines = []
    for j, (was, now) in enumerate(zip(found.before, found.achieved, strict=True)):
        surely = j + 1 in (found.worse or ())
        doubt = "" if surely else "; that may be chance"
        if surely or now > (1.0 + MUCH_WORSE) * was > 0.0:
            lines.append(
                f"joint {j + 1}: its error rises from {rounded(was, 3)} to {rounded(now, 3)} "
                f"{model.robot.torque_unit(j)} against {model.parent or 'the model as given'}"
                f"{' with what it lacked' if beside else ''}, which stays as it is{doubt}"
            )
    return lines
