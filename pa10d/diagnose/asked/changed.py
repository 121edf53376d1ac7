"""What changed, beside what the model never had.

What a model always lacked shows more in one motion than in another, and looks like a change there.
Where a change is claimed on a joint on which the model leaves more than noise of its own data, that
data is asked first what is missing; the change is sought beside that.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace

import numpy as np

from pa10d.common.words import listed, rounded
from pa10d.diagnose.constants import MATERIAL_GAIN, MATERIAL_REST
from pa10d.diagnose.outcome.diagnosis import Diagnosis, Finding
from pa10d.diagnose.outcome.words import helped_most
from pa10d.diagnose.procedure import diagnose
from pa10d.judgement import run_residual
from pa10d.judgement.scores import scores
from pa10d.measurement.recording import Recording
from pa10d.model import Term, TorqueModel

WAS_THERE = (
    " No change: on the runs that the model was identified from, joint {joint} keeps {after} "
    "{unit} with it and {before} without."
)
NOT_SHOWN = (
    " Whether it came since, the runs that the model was identified from do not tell: they hardly "
    "show it in joint {joint}, which keeps {after} {unit} with it and {before} without."
)
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
    if not own or not found.findings:
        return found
    return _as_own_runs_have_it(
        *_beside_what_lacked(found, model, fit, validate, own, progress, cancel), own
    )


def _beside_what_lacked(
    found: Diagnosis,
    model: TorqueModel,
    fit: Sequence[Recording],
    validate: Sequence[Recording],
    own: Sequence[Recording],
    progress: Progress | None,
    cancel: Cancel | None,
) -> tuple[Diagnosis, TorqueModel]:
    """Asked again with what the model lacks of its own data, where a change is claimed there and
    the new data has it, too; and of which model."""
    if not _claims_where_it_lacks(found, model):
        return found, model
    lacking = diagnose(model, own, progress=_part(progress, 0.4, 0.8), cancel=cancel)
    if not lacking.findings:
        return found, model
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
        return found, model
    first = found.as_given
    again = replace(again, as_given=first, beside=told, identified_from=found.identified_from)
    return again, whole


def _as_own_runs_have_it(
    found: Diagnosis, model: TorqueModel, own: Sequence[Recording]
) -> Diagnosis:
    """With a word on what takes as much of the runs that the model was identified from."""
    return replace(found, findings=tuple(_there_before(f, model, own) for f in found.findings))


def _there_before(finding: Finding, model: TorqueModel, own: Sequence[Recording]) -> Finding:
    """What came since would have shown on those runs, if they go where it acts; what was always
    lacking takes part of their error, too. Of effects that move one equation: what the bodies share
    makes up for others."""
    term = finding.term
    if term.effect.reaches_other_joints or term.effect.seen_by_shared_bodies:
        return finding
    whole = replace(model, terms=(*model.terms, term))
    without, beside = (scores([run_residual(m, run) for run in own]).rms for m in (model, whole))
    j = helped_most(term, finding.rms_before, finding.rms_after)[0]
    if beside[j] > (1.0 + MATERIAL_GAIN) * without[j]:
        return replace(finding, was_there=False)
    was_there = True if (1.0 + MATERIAL_GAIN) * beside[j] < without[j] else None
    text = (WAS_THERE if was_there else NOT_SHOWN).format(
        joint=j + 1,
        before=rounded(without[j], 3),
        after=rounded(beside[j], 3),
        unit=model.robot.torque_unit(j),
    )
    told = finding.sentence.replace(" now has ", " has ", 1).replace(" now have ", " have ", 1)
    return replace(finding, sentence=told + text, was_there=was_there)


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
