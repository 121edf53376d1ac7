"""What changed, beside what the model never had.

What a model always lacked shows more in one motion than in another, and looks like a change there.
Where a change is claimed on a joint on which the model leaves more than noise of its own data, that
data is asked first what is missing; the change is sought beside that.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace

import numpy as np

from pa10d.common.words import listed
from pa10d.diagnose.constants import MATERIAL_REST
from pa10d.diagnose.outcome.diagnosis import Diagnosis
from pa10d.diagnose.procedure import diagnose
from pa10d.measurement.recording import Recording
from pa10d.model import Term, TorqueModel

Progress = Callable[[float, str], None]
Cancel = Callable[[], bool]


def what_changed(
    model: TorqueModel,
    fit: Sequence[Recording],
    validate: Sequence[Recording] = (),
    own: Sequence[Recording] = (),
    *,
    progress: Progress | None = None,
    cancel: Cancel | None = None,
) -> Diagnosis:
    """own: the runs that the model was identified from, as far as they are at hand."""
    found = diagnose(
        model, fit, validate, frozen=True, progress=_part(progress, 0.0, 0.4), cancel=cancel
    )
    if not own or not _claims_where_it_lacks(found, model):
        return found
    lacking = diagnose(model, own, progress=_part(progress, 0.4, 0.8), cancel=cancel)
    if not lacking.findings:
        return found
    named = listed([f.term.label for f in lacking.findings])
    runs = listed(sorted(run.name for run in own))
    told = (
        f"{model.name} lacks {named} on the runs that it was identified from ({runs}); what "
        "changed was sought beside that: add it to the model"
    )
    whole = replace(lacking.kept, name=model.name)
    again = diagnose(
        whole, fit, validate, frozen=True, progress=_part(progress, 0.8, 1.0), cancel=cancel
    )
    lacked = {j for f in lacking.findings for j in _concerned(f.term, model)}
    if not _explains_more(again, found, lacked) or _loses(again, found, lacked):
        return found
    return replace(
        again, as_given=found.as_given, beside=told, identified_from=found.identified_from
    )


def _explains_more(again: Diagnosis, found: Diagnosis, lacked: Collection[int]) -> bool:
    """Does what was lacking leave less of the new data, too, before any change is sought? Not so
    friction that warmed up from cold where the new runs began warm."""
    joints = sorted(lacked)
    ratio = again.as_given.rms[joints] / found.as_given.rms[joints]
    return bool(np.mean(ratio**2) < 1.0)


def _loses(again: Diagnosis, found: Diagnosis, lacked: Collection[int]) -> bool:
    """Is a change gone, and nothing said of its joints, where nothing was lacking? What was added
    for other joints has widened the doubt of all, and the change lies within it."""
    told = {j for f in again.findings for j in f.term.joints}
    own = (set(f.term.joints) for f in found.findings)
    return any(joints and not joints & {*lacked, *told} for joints in own)


def _concerned(term: Term, model: TorqueModel) -> Sequence[int]:
    return term.joints or range(model.robot.n)


def _claims_where_it_lacks(found: Diagnosis, model: TorqueModel) -> bool:
    joints = {u.joint for u in found.unexplained}
    for finding in found.findings:
        joints |= {*_concerned(finding.term, model)}
    lacks = model.noise > MATERIAL_REST * found.noise_floor
    return bool(np.any(lacks[sorted(joints)]))


def _part(progress: Progress | None, begin: float, end: float) -> Progress | None:
    if progress is None:
        return None
    return lambda share, what: progress(begin + (end - begin) * share, what)
