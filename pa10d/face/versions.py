"""New versions of a model: one effect added, or as many as the data prove."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pa10d.diagnose import procedure
from pa10d.diagnose.asked import adding
from pa10d.diagnose.search.delivery import delivered
from pa10d.face.answers import Diagnosis, Improvement
from pa10d.face.model import Model
from pa10d.face.questions import Cancel, Progress, heeding, recordings
from pa10d.face.run import Run


def add(
    model: Model,
    effect: str,
    joints: Sequence[int] = (),
    fit: Sequence[Run] = (),
    name: str | None = None,
    over: Sequence[str] = (),
    progress: Progress | None = None,
    cancel: Cancel | None = None,
) -> Model:
    """A new version with an effect fitted in, on each of the joints (from 1; a pair for effects of
    pairs; none: wherever it may sit). ``model`` stays as it is.

    The new version's ``warnings`` say where it is not significant. What only a comparison with an
    earlier model shows (a payload, a tilted base …) is added to the model as it was. over:
    quantities of a ``smooth_map``.
    """
    made, warnings = adding.add_asked(
        model.inner, effect, [j - 1 for j in joints], recordings(fit),
        name=name or f"{model.name}+{effect}", over=over, progress=heeding(progress, cancel),
    )  # fmt: skip
    notes = replace(made.notes, warnings=(*made.notes.warnings, *warnings))
    return Model(replace(made, parent=model.name, notes=notes))


def improve(
    model: Model,
    fit: Sequence[Run],
    validate: Sequence[Run] = (),
    name: str | None = None,
    progress: Progress | None = None,
    cancel: Cancel | None = None,
) -> Improvement:
    """Diagnose and add until nothing significant is left; every step is a version of its own."""
    found = procedure.diagnose(
        model.inner, recordings(fit), recordings(validate), progress=progress, cancel=cancel
    )
    last = name or f"{model.name}+"
    steps, parent = [model], model.name
    for number, version in enumerate(found.stored, 1):
        own = last if number == len(found.stored) else f"{last}.{number}"
        steps.append(Model(replace(version, name=own, parent=parent)))
        parent = own
    promised = found.findings[-1].rms_after if found.findings else found.rms
    diagnosis = Diagnosis(found, tuple(fit), tuple(validate))
    achieved = delivered(found.kept).achieved if found.stored else None
    left = found.left.rms if achieved is None else np.array(achieved)
    return Improvement(tuple(steps), promised, left, diagnosis)
