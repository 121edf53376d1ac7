"""An effect that somebody asks for, fitted into a model: whichever question it answers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from pa10d.common.errors import UserError
from pa10d.diagnose.asked.one_effect import add
from pa10d.diagnose.asked.smooth import add_map, asked
from pa10d.diagnose.procedure import diagnose
from pa10d.diagnose.search.suspects import lacking, suspicion
from pa10d.effects import all_effects
from pa10d.effects.smooth_map import SmoothMap
from pa10d.measurement.recording import Recording
from pa10d.model import TorqueModel

Progress = Callable[[float, str], None]


def add_asked(
    model: TorqueModel,
    effect: str,
    joints: Sequence[int],
    fit: Sequence[Recording],
    *,
    name: str,
    over: Sequence[str] = (),
    progress: Progress | None = None,
) -> tuple[TorqueModel, list[str]]:
    """A new version and what to warn of. joints: 0-based; empty: wherever it may sit.

    over: quantities of a smooth map, such as the ``depends_on`` of an ``unexplained`` entry.
    What only a comparison with an earlier model shows (a payload, a tilted base …) is added to the
    model as it was: a refit would take it for a trait of the arm. In the model's own runs nothing
    has changed since; there, what joints contradict each other in is fitted along with the rest.
    """
    refuse_slips(model, effect, joints, over)
    if effect == SmoothMap.id:
        mapped = add_map(model, joints, over, fit, name=name, progress=progress)
        return mapped.model, mapped.warnings
    kind = all_effects().get(effect)
    own = {run.name for run in fit} <= set(model.runs)
    if kind and kind.question == "changed" and not (own and kind.seen_by_shared_bodies):
        return _changed(model, effect, joints, fit, name, progress), []
    return add(model, effect, joints, fit, name=name, progress=progress)


def refuse_slips(
    model: TorqueModel, effect: str, joints: Sequence[int], over: Sequence[str]
) -> None:
    """UserError where an effect, a joint or a quantity is none of this model."""
    if over and effect != SmoothMap.id:
        raise UserError(f"--over: given with {effect}; expected it with {SmoothMap.id} only")
    if effect == SmoothMap.id:
        asked(model, joints, over)
        return
    suspicion((effect, joints), model.robot.n)
    if all_effects()[effect].question != "changed":  # what has changed once may change again
        lacking(model, effect, joints)


def _changed(
    model: TorqueModel,
    effect: str,
    joints: Sequence[int],
    fit: Sequence[Recording],
    name: str,
    progress: Progress | None,
) -> TorqueModel:
    found = diagnose(model, fit, frozen=True, only=(effect, joints), progress=progress)
    if not found.findings:
        raise UserError(
            f"{effect}: these runs do not show it against model '{model.name}' as it is; expected "
            "runs of the arm after the change, and a model identified before it"
        )
    return replace(found.versions[-1], name=name)
