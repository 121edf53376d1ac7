"""Who is asked: every effect at every joint where it may be missing, or what somebody names."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import combinations

from pa10d.common.errors import UserError
from pa10d.common.words import from_one
from pa10d.diagnose.regression.side import Side
from pa10d.diagnose.regression.state import Suspects
from pa10d.effects import Effect, all_effects, effect
from pa10d.model import TorqueModel


def suspects(frozen: bool, n: int) -> list[tuple[Effect, tuple[int, ...]]]:
    """All pairs of effect and joints: what may be missing, or (frozen) what may have changed."""
    out: list[tuple[Effect, tuple[int, ...]]] = []
    for kind in all_effects().values():
        changed = kind.question == "changed" or kind.also_changes
        missing = kind.question == "missing" or kind.seen_by_shared_bodies
        if not (changed if frozen else missing):
            continue
        out += [(kind, joints) for joints in places(kind, n)]
    return out


def heard(suspects: Suspects, held: Side) -> Suspects:
    """Without those of joints of which no sample counts."""
    return [(kind, joints) for kind, joints in suspects if not {*joints} & held.silent.keys()]


def places(kind: Effect, n: int) -> Iterable[tuple[int, ...]]:
    """The joints an effect may sit on."""
    if kind.scope == "robot":
        return [()]
    if kind.scope == "pair":
        return list(combinations(range(n), 2))
    return [(j,) for j in range(n)]


def suspicion(only: tuple[str, Sequence[int]], n: int) -> Suspects:
    """One effect on the given joints (0-based) of ``n``, or wherever it may sit."""
    kind, joints = effect(only[0]), list(only[1])
    if kind.question == "chosen":
        raise UserError(f"{kind.id}: explains nothing, so it is no suspect; expected an effect")
    for j in joints:
        if not 0 <= j < n:
            raise UserError(f"joint {j + 1}: expected {from_one(n)}")
    if kind.scope == "robot" or not joints:
        return [(kind, place) for place in places(kind, n)]
    if kind.scope == "pair":
        if len(joints) != 2 or joints[0] == joints[1]:
            raise UserError(f"{kind.id}: acts on a pair, expected two different joints")
        return [(kind, (min(joints), max(joints)))]
    return [(kind, (j,)) for j in joints]


def lacking(model: TorqueModel, effect_id: str, joints: Sequence[int]) -> Suspects:
    """Where the effect can be added: a second one of the same columns would take its torque from
    the first. joints: 0-based; empty: wherever the model has none yet. UserError where it has it.
    """
    asked = suspicion((effect_id, joints), model.robot.n)
    present = {(t.effect_id, t.joints) for t in model.terms}
    once = [(kind, at) for kind, at in asked if not (kind.repeatable or kind.one_of_each)]
    there = [one for one in once if (one[0].id, one[1]) in present]
    if there and (joints or len(there) == len(asked)):
        named = ", ".join(label(kind, at) for kind, at in there)
        raise UserError(
            f"{named}: model '{model.name}' has it already; expected an effect that it lacks there"
        )
    return [one for one in asked if one not in there]


def label(kind: Effect, joints: Sequence[int]) -> str:
    """As it is called in messages: "stribeck J2"; joints: 0-based."""
    return f"{kind.id} J{','.join(str(j + 1) for j in joints)}" if joints else kind.id
