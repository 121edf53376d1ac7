"""All that is known of what one joint keeps: what its line is written from."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pa10d.compare.places import Place
from pa10d.diagnose.constants import AT_RANDOM, CLAIMED_SHARE, MATERIAL_REST, MUCH_WORSE
from pa10d.diagnose.unknown.among_knocks import AmongKnocks
from pa10d.diagnose.unknown.between_runs import Apart
from pa10d.diagnose.unknown.beyond import Beyond
from pa10d.diagnose.unknown.claims import Unexplained, Unnamed, comes_again
from pa10d.diagnose.unknown.geometry import OtherGeometry
from pa10d.diagnose.unknown.goes_with import GoesWith
from pa10d.diagnose.unknown.rubbing import OtherFriction
from pa10d.diagnose.unknown.structure import Structure
from pa10d.judgement import Judgement
from pa10d.judgement.repeatable import Repeatable
from pa10d.model import Term

Array = NDArray[np.float64]


@dataclass(frozen=True)
class KnownBesides:
    """What a search knows besides its claims; joints from 0, arrays (n,), each empty where nobody
    asked.

    found: terms of all findings
    searched: more than one suspicion was looked for
    slight: maps that are significant and too small for a claim
    doubt: N·m, what the uncertainty of the model's own coefficients may leave
    beyond: per joint where on the held-out side its error lies, if the fit side has not been there
    gains: by joint, such as sway and explain more than its map or findings do
    stand_out: parts of the motion in which errors are larger, the gravest first, where noise as
    slow as gravity may be, too
    silent: joints of which no sample counts, and why
    undetermined: joints of which the fitted runs leave open as much as they keep, for the motion
    held out, and how many times the floor they keep on the fitted runs
    faster: in words, what the band does not let through
    beside: whose rest a joint's own goes with
    knocked: in words, of those whose error lies in a few moments of the runs
    outdone: effects that would take such a share of it, of which a map leaves much less
    dead_bands: N·m up to which its torque reads nothing, and the share that is gone with that
    knocks: what lies in those of a gap that was found, and what is kept elsewhere
    most_noise: N·m RMS, as much as is noise at most on the runs that the model was fitted to

    Of a model that stays as it was:
    usual: N·m, what it may leave though nothing changed; lacked: what it left on its own data
    as_given: N·m, what it leaves unmoved; moved: joints on which it leaves so little for being so
    alone: in words, what one change takes of what it leaves unmoved
    """

    found: Sequence[Term] = ()
    searched: bool = True
    slight: Sequence[Structure] = ()
    doubt: Array | None = None
    beyond: Sequence[Beyond | None] = ()
    gains: Mapping[int, Structure] = field(default_factory=dict)
    stand_out: Sequence[Place] = ()
    silent: Mapping[int, str] = field(default_factory=dict)
    undetermined: Mapping[int, float] = field(default_factory=dict)
    faster: Mapping[int, str] = field(default_factory=dict)
    beside: Mapping[int, GoesWith] = field(default_factory=dict)
    knocked: Mapping[int, str] = field(default_factory=dict)
    outdone: Mapping[int, tuple[tuple[str, ...], float]] = field(default_factory=dict)
    dead_bands: Mapping[int, tuple[float, float]] = field(default_factory=dict)
    knocks: Mapping[int, AmongKnocks] = field(default_factory=dict)
    most_noise: Array | None = None
    usual: Array | None = None
    lacked: Array | None = None
    as_given: Array | None = None
    moved: Collection[int] = ()
    alone: Mapping[int, str] = field(default_factory=dict)


@dataclass(frozen=True)
class OfJoint:
    """One joint (0-based) of an arm after all that was found.

    unit: of its torque or force; left: what is claimed of it; others: what is claimed of other
    joints; seen: how far its error comes again with the motion, None where no motion comes again
    """

    joint: int
    unit: str
    judged: Judgement
    left: Unexplained | None
    others: tuple[Unexplained, ...]
    seen: Repeatable | None
    known: KnownBesides

    @property
    def rms(self) -> float:
        """N·m held out."""
        return float(self.judged.rms[self.joint])

    @property
    def floor(self) -> float:
        """N·m; nan where this data does not show it."""
        return float(self.judged.floor.values[self.joint])

    @property
    def source(self) -> str | None:
        """How the floor was found."""
        return self.judged.floor.methods[self.joint]

    @property
    def ratio(self) -> float:
        """Error over noise floor; nan where that is not known."""
        return self.rms / self.floor if self.floor > 0 else float("nan")

    @property
    def material(self) -> bool | None:
        """Does it keep more than noise? None: the floor is not known."""
        if self.left is not None:
            return True
        ratio = float(self.judged.ratio[self.joint])
        return bool(ratio > MATERIAL_REST) if np.isfinite(ratio) else None

    @property
    def repeats(self) -> bool | None:
        """Does it come again with the motion? None: no motion comes again, or too little of it."""
        if self.seen is None:
            return None
        if comes_again(self.seen, len(self.judged.rms)):
            return True
        return False if self.seen.p_value > AT_RANDOM or self.seen.share < CLAIMED_SHARE else None

    @property
    def size_alone(self) -> bool:
        """Nothing but its size speaks for it, if anything does."""
        return self.left is None or (isinstance(self.left, Unnamed) and self.left.witness == "size")

    @property
    def place(self) -> Place | None:
        """The part of the motion in which its error is largest."""
        return next((p for p in self.known.stand_out if p.joint == self.joint), None)

    @property
    def beyond(self) -> Beyond | None:
        """Where its error lies, if that is where the fit side has not been."""
        return self.known.beyond[self.joint] if self.known.beyond else None

    @property
    def knocked(self) -> str:
        """Where in time its error lies, in words, if it lies in a few moments."""
        return self.known.knocked.get(self.joint, "")

    @property
    def springs(self) -> list[int]:
        """Joints (0-based) in which a spring was found: what swings on may be that one."""
        return [t.joints[0] for t in self.known.found if t.effect.series_spring]

    @property
    def on_found(self) -> bool:
        """Was something found on it?"""
        return any(self.joint in t.joints for t in self.known.found)

    @property
    def most_noise(self) -> float:
        """N·m RMS; inf where not known."""
        most = self.known.most_noise
        return float("inf") if most is None else float(most[self.joint])

    @property
    def told(self) -> bool:
        """Is more than a dependence said of it, that stands whatever its model lacked before?"""
        return isinstance(self.left, Apart | OtherGeometry | OtherFriction) or bool(self.knocked)

    @property
    def as_before(self) -> bool:
        """Of a model that stays as it was: does it keep no more than that may leave unchanged?"""
        usual = self.known.usual
        if usual is None or self.material is False or self.joint in self.known.moved:
            return False
        return bool(self.rms <= usual[self.joint])

    @property
    def trace(self) -> Structure | None:
        """A map that is too little for a claim."""
        if self.left is not None or self.as_before:
            return None
        return next((one for one in reversed(self.known.slight) if one.joint == self.joint), None)

    @property
    def lacked(self) -> float:
        """N·m that the model left on the data that it was identified from."""
        return self.rms if self.known.lacked is None else float(self.known.lacked[self.joint])

    @property
    def left_unmoved(self) -> float | None:
        """N·m that a frozen model leaves as it was, where being moved made that much more."""
        given = self.known.as_given
        worse = given is not None and self.rms > (1.0 + MUCH_WORSE) * given[self.joint]
        return float(given[self.joint]) if given is not None and worse else None
