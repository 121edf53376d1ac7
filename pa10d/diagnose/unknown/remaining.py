"""What is left of every joint's error, and what this data can say about it. Always a line each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pa10d.common.jsonable import JsonObject, plain
from pa10d.diagnose.unknown.claims import Unexplained
from pa10d.diagnose.unknown.of_joint import KnownBesides, OfJoint
from pa10d.diagnose.unknown.said_of_joint import said_of_joint
from pa10d.judgement import Judgement
from pa10d.judgement.repeatable import Repeatable


@dataclass(frozen=True)
class Remaining:
    """One joint (0-based) after all that was found. rms, floor: N·m, floor nan where not known;
    source: how the floor was found; repeatable: does it come again with the motion (None: no
    motion comes again, or too little of it)."""

    joint: int
    rms: float
    floor: float
    source: str | None
    significant: bool
    material: bool | None
    repeatable: bool | None
    depends_on: tuple[str, ...]
    sentence: str

    @property
    def ratio(self) -> float:
        """Error over noise floor; nan where the floor is not known."""
        return self.rms / self.floor if self.floor > 0 else float("nan")

    def document(self) -> JsonObject:
        """As JSON; null: not known."""
        return {
            "joint": self.joint + 1,
            "rms": self.rms,
            "floor": plain(self.floor),
            "floor_source": self.source,
            "ratio": plain(self.ratio),
            "significant": self.significant,
            "material": self.material,
            "repeatable": self.repeatable,
            "depends_on": list(self.depends_on),
            "sentence": self.sentence,
        }


def remaining(
    judged: Judgement,
    again: Sequence[Repeatable | None],
    unexplained: Sequence[Unexplained],
    units: Sequence[str],
    known: KnownBesides | None = None,
) -> tuple[Remaining, ...]:
    """A line per joint; judged: of the model with all findings, on the held-out side; again: what
    comes again of it; unexplained: what is claimed; units: of each joint's torque or force."""
    known = known or KnownBesides()
    claimed = {one.joint: one for one in unexplained}
    return tuple(
        _not_judged(j, float(judged.rms[j]), known.silent[j])
        if j in known.silent
        else _line(
            OfJoint(
                joint=j,
                unit=units[j],
                judged=judged,
                left=claimed.get(j),
                others=tuple(one for one in unexplained if one.joint != j),
                seen=seen,
                known=known,
            )
        )
        for j, seen in enumerate(again)
    )


def _line(one: OfJoint) -> Remaining:
    return Remaining(
        joint=one.joint,
        rms=one.rms,
        floor=one.floor,
        source=one.source,
        significant=one.left is not None or one.trace is not None,
        material=one.material,
        repeatable=one.repeats,
        depends_on=() if one.left is None else one.left.variables,
        sentence=said_of_joint(one),
    )


def _not_judged(joint: int, rms: float, why: str) -> Remaining:
    text = f"Nothing was looked for on joint {joint + 1}: {why}."
    return Remaining(joint, rms, float("nan"), None, False, None, None, (), text)
