"""What an effect is: a torque that the rigid bodies do not explain, and all there is to say on it.

An effect's torque is linear in its coefficients and may depend on further *shape* parameters.
A subclass states its texts and computes its columns; everything else (fitting, judging,
documenting, storing) is the same for all of them.
"""

from __future__ import annotations

import inspect
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from pa10d.common.words import of_a_slide, rounded
from pa10d.dynamics import Robot
from pa10d.effects.context import Context
from pa10d.effects.sign import smooth_sign

__all__ = [
    "Array",
    "Coefficient",
    "Effect",
    "Example",
    "Shape",
    "ShapeParameter",
    "Value",
    "View",
    "smooth_sign",
    "speed_quantiles",
]

Array = NDArray[np.float64]
SURELY = 1.96  # standard errors by which a size is other than nothing (5 %, two-sided)
ROOM = 1e3  # times beyond the bounds of a logarithmic scale: no other unit, and never nothing
Shape = Mapping[str, float]
"""Values of an effect's shape parameters by name."""


@dataclass(frozen=True)
class Coefficient:
    """A linear parameter with its physical bounds; a nuisance is fitted but not reported. Of one
    that is whole at 1 (a share of what the shape alone says), what it is off by puts the shape
    in doubt, by as much of its value, and itself."""

    name: str
    unit: str
    lower: float = -np.inf
    upper: float = np.inf
    nuisance: bool = False
    whole_at_one: bool = False


@dataclass(frozen=True)
class ShapeParameter:
    """A nonlinear parameter: bounds, whether its scale is logarithmic or a mere choice, and how far
    the search steps at first, on that scale (a ratio's logarithm where it is logarithmic): about
    as far as neighbours among the effect's ``starts`` stand apart; a function of the shape where
    that depends on it."""

    name: str
    unit: str
    lower: float
    upper: float
    scale: Literal["linear", "log", "choice"] = "linear"
    smoothing: bool = False  # only rounds a corner; may lie at its bound
    optional: bool = False  # only some joints have it; absent from the shapes of others
    blur: float = 0.0  # standard deviation, relative, over which the columns average
    step: float | Callable[[Shape], float] | None = None
    usual: float | None = None  # a value that a law of the field has, though it be an end
    says: Mapping[float, str] = field(default_factory=dict, hash=False)  # a choice: what each means

    def step_at(self, shape: Shape) -> float:
        """How far a search that begins at this shape steps at first."""
        if self.step is None:
            return 0.7 if self.scale == "log" else 0.2
        return self.step(shape) if callable(self.step) else self.step

    def determined(self, value: float, error: float) -> bool:
        """Do the data tell it: more than that it is not negative, or lies within its range?"""
        if self.scale == "choice":
            return True
        if self.smoothing and error == 0.0:  # assumed: the data showed nothing of it
            return False
        if self.scale == "log":  # nothing at one of its ends, no end at the other
            return SURELY * error <= abs(value)
        within = 0.25 * (self.upper - self.lower)
        return bool(error <= (min(abs(value), within) if self.lower >= 0.0 else within))

    @property
    def spread(self) -> float:
        """The standard deviation of what it may be, where nothing else is known: a law's exponent
        lies within its bounds, whatever the data say of it."""
        return (self.upper - self.lower) / np.sqrt(12.0) if self.scale == "linear" else np.inf

    @property
    def of_law(self) -> bool:
        """Does it tell one of the field's laws from another, rather than size or place?"""
        return self.usual is not None

    @property
    def reach(self) -> tuple[float, float]:
        """What a stored value may be: the bounds, and well beyond them where it was measured, for
        an arm of another size and a law whose bounds were others once."""
        if self.scale == "choice":
            return self.lower, self.upper
        if self.scale == "log":
            return self.lower / ROOM, self.upper * ROOM
        span = self.upper - self.lower
        return (0.0 if self.lower >= 0.0 else self.lower - span), self.upper + span

    def at_edge(self, value: float) -> bool:
        """At the end of a logarithmic range, where the effect has turned into another one."""
        if self.scale != "log" or self.smoothing:
            return False
        return value < 1.05 * self.lower or value > 0.95 * self.upper


@dataclass(frozen=True)
class Value:
    """An estimate with its standard error, in the named unit.

    std_error: all that is known of its doubt: scatter between stretches of the data, what the model
    lacks, and (random: without it) what the torque constants may be off by, and by how much it is
    not what its law says
    determined: False where the data leave it open, and of what is beyond
    beyond: at or beyond the end of what it may be, and so no estimate of it
    by_gain: how far a torque constant that is off by all of its value moves it, where its unit does
    not say so
    means: of a choice, in words
    """

    value: float
    std_error: float
    unit: str
    random: float | None = None
    determined: bool = True
    by_gain: float = 0.0
    beyond: bool = False
    means: str = ""

    @property
    def std_error_random(self) -> float:
        """Without what the torque constants add, or that it is not what its law says."""
        return self.std_error if self.random is None else self.random

    def with_gain_error(self, share: float) -> Value:
        """Beside a torque constant that is known to ``share`` of its value: whatever is measured
        in torque or mass is as uncertain, and what else depends on it (``by_gain``)."""
        by_gain = self.value if any(unit in self.unit for unit in ("N", "kg")) else self.by_gain
        if share * by_gain == 0.0:
            return self
        whole = float(np.hypot(self.std_error, share * by_gain))
        return replace(self, std_error=whole, random=self.std_error)

    def whole_at(self, known: float) -> Value:
        """Of what a law says beforehand: by what it is off, something else than noise moved it."""
        whole = float(np.hypot(self.std_error, self.value - known))
        return replace(self, std_error=whole, random=self.std_error)

    def document(self) -> dict[str, object]:
        """As JSON: std_error is the whole, std_error_random without the torque constants; null:
        of a value that was assumed nobody knows how far it is off."""
        assumed = not self.determined and self.std_error == 0.0
        return {
            "value": self.value,
            "std_error": None if assumed else self.std_error,
            "std_error_random": None if assumed else self.std_error_random,
            "unit": self.unit,
            "determined": self.determined,
            **({"means": self.means} if self.means else {}),
        }

    def __abs__(self) -> Value:
        """As large, whichever way it goes."""
        return replace(self, value=abs(self.value))

    def __str__(self) -> str:
        """``0.113 ± 0.02 N·m``, a choice with what it means, or that the data leave it open."""
        if self.beyond:
            return "no estimate"
        if not self.determined:
            return "not determined"
        value = rounded(self.value, 4)
        if self.std_error > 0.0:  # a choice has none
            value += f" ± {rounded(self.std_error, 2)}"
        return f"{value}{self.unit_after}{self.meaning}"

    @property
    def unit_after(self) -> str:
        """As it stands behind a number: nothing where there is none."""
        return "" if self.unit == "1" else f" {self.unit}"

    @property
    def meaning(self) -> str:
        """As it stands behind a choice: nothing where it has none."""
        return f" ({self.means})" if self.means else ""

    def of_a_slide(self) -> Value:
        """The same where the joint does not turn but slide: newtons and metres."""
        return replace(self, unit=of_a_slide(self.unit))


@dataclass(frozen=True)
class View:
    """How a finding of the effect is drawn.

    against: the quantity whose plot shows it best, see ``pa10d.figures.views``; empty: none does,
        it is looked at over time
    along: torque is counted along the motion: friction of both directions falls on one curve
    near: the shape parameter that says how close to zero the effect acts, and how many to show
    over_time: its course over time comes first
    over_frequency: a spectrum in hertz tells it from others
    """

    against: str = ""
    along: bool = False
    near: tuple[str, float] | None = None
    over_time: bool = False
    over_frequency: bool = False


@dataclass(frozen=True)
class Example:
    """A typical case, drawn on the effect's page.

    coefficients, shape: of the case, in the units of the class
    against: the quantity whose plot shows the effect best, see ``pa10d.effects.portrait``
    motion: what the arm does meanwhile, see ``pa10d.effects.motions``
    joints: where the effect sits, numbered from 1; the first is the one that is drawn
    """

    coefficients: tuple[float, ...]
    against: str
    shape: Shape = field(default_factory=dict)
    motion: str = "swing"
    joints: tuple[int, ...] = (2,)


class Effect(ABC):
    """Base class; one instance serves every joint (it keeps no state).

    The docstring of a subclass says in plain words what the effect is: it opens its page.
    """

    id: ClassVar[str]
    title: ClassVar[str]
    noun: ClassVar[str] = ""  # what a joint "shows"; the title in small letters where empty
    plainly: ClassVar[str] = ""  # the same for somebody who has never heard the name
    equation: ClassVar[str]
    scope: ClassVar[Literal["joint", "pair", "robot"]] = "joint"
    question: ClassVar[Literal["textbook", "missing", "changed", "chosen"]] = "missing"
    sensing: ClassVar[bool] = False  # acts on the measured side: sensor, not mechanics
    reaches_other_joints: ClassVar[bool] = False  # columns in every joint's equation
    starts_by_own_equation: ClassVar[bool] = False  # which says best where a search begins
    feels_own_heat: ClassVar[bool] = False  # is friction that depends on the heat of friction
    rubs: ClassVar[bool] = False  # is friction that needs nothing but the motion, and heats
    smoothed_over: ClassVar[str] = ""  # shape parameter: the speed over which its sign is smoothed
    # (an identification asks the data for that of every joint's dry friction)
    carried: ClassVar[bool] = False  # friction of one coefficient, of which ``level`` tells the
    # size, against its joint's motion: bristles carry it, where the joint has any
    reads_as_load: ClassVar[bool] = False  # what of it goes one way only, as a share of the load,
    # bodies take in; its first coefficient is the share
    builds_up_over: ClassVar[str] = ""  # shape parameter: the way over which its joint's friction
    # builds up after a turn, and all that is carried with it
    damped_over: ClassVar[str] = ""  # shape parameter: the time by which that is damped
    is_rotor: ClassVar[bool] = False  # without it the rigid bodies take the rotor's inertia in
    picked_up: ClassVar[bool] = False  # may come, go or be another from one moment on
    also_changes: ClassVar[bool] = False  # asked for, too, where the question is what changed
    seen_by_shared_bodies: ClassVar[bool] = False  # a change that a new fit does not hide: the
    # equations of several joints ask different things of one body. Asked for where the question
    # is what is missing, too; any joint may show it, and it takes no rival's place on its own
    only_against_others: ClassVar[str] = ""  # what to know of its value where the model is fitted
    # anew and only what joints contradict each other in shows; {others}: those it is not named on
    turns_joint: ClassVar[bool] = False  # its joint stands elsewhere than its angle says
    follows_angle: ClassVar[bool] = False  # depends on its joint's angle and on nothing else
    series_spring: ClassVar[bool] = False  # the joint's whole torque passes through a spring with
    # the shapes K, zeta and, where the bodies have taken it in, rotor
    repeatable: ClassVar[bool] = False  # a joint may have several: another stop, a second spot
    below_zero: ClassVar[str] = ""  # what it means where the first coefficient is negative
    one_of_each: ClassVar[str] = ""  # shape parameter: a place may have one of each of its choices
    otherwise: ClassVar[str] = ""  # effect that it is where its shape is not its own any more
    line_order: ClassVar[str] = ""  # shape parameter that is a line's order in the spectrum
    # of the residual against the angle (cycles per turn): the search begins at such lines
    joint_property: ClassVar[Literal["", "armature", "damping", "friction"]] = ""  # what URDF
    # and MJCF have a place for, by what the effect comes to where the joint slides
    live: ClassVar[bool] = False  # the control loop evaluates it itself, in every cycle
    commanded: ClassVar[bool] = True  # a controller has to ask for this torque, too
    tells_sign: ClassVar[bool] = False  # of less than none of it somebody has to ask whether torque
    # or angle counts the other way: it would drive its joint
    remembers: ClassVar[str] = ""  # what its torque depends on beside this instant, and what is
    # taken for it where samples stand apart
    escapes_demo: ClassVar[str] = ""  # why the demo's experiments may not show it
    view: ClassVar[View | None] = None  # None: as the example is drawn
    derived: ClassVar[Mapping[str, tuple[str, ...]]] = {}  # of what it tells: from which of its
    # parameters, without which it is as unknown
    over: tuple[str, ...] = ()  # quantities of a map (only those have any)
    uses_model: bool = False  # columns change with the model's loads and torques
    coefficients: tuple[Coefficient, ...]
    shapes: tuple[ShapeParameter, ...] = ()
    signature: ClassVar[str]  # what its residual looks like, to a person
    confounders: ClassVar[Mapping[str, str]] = {}  # effect id -> why it looks alike
    experiment: ClassVar[str]  # what separates it, in words
    experiment_kind: ClassVar[str] = "excitation"  # the experiment kind that shows it best
    source: ClassVar[str]
    remedy: ClassVar[str] = ""  # what a technician may do about it
    example: ClassVar[Example | None] = None  # a typical case, for the picture on its page

    @property
    def named(self) -> str:
        """The effect within a sentence, with its article: "a spring"."""
        return self.noun or self.title.lower()

    @property
    def drawn(self) -> View:
        """How a finding of it is drawn."""
        return self.view or View(self.example.against if self.example else "dq")

    @property
    def meaning(self) -> str:
        """What the effect is, in plain words: the class's docstring as one paragraph."""
        return " ".join((inspect.getdoc(type(self)) or self.title).split())

    @abstractmethod
    def columns(self, context: Context, joints: Sequence[int], shape: Shape) -> Array:
        """Torque per unit coefficient at the raw sample rate.

        joints: 0-based; one for scope ``joint``, two for ``pair``, none for ``robot``.
        Returns (N, k) for the equation of ``joints[0]`` alone, or (N, n, k) where
        ``reaches_other_joints``; k = number of coefficients. N·m per unit.
        """

    def slips(self, context: Context, joints: Sequence[int], shape: Shape) -> Array | None:
        """(N,) rad/s at which surfaces slip past each other that are no joint's own, and stick
        where that is nothing; None: it has no such surfaces."""
        return None

    def level(self, context: Context, joints: Sequence[int], shape: Shape) -> Array:
        """(N,) size of its friction per unit of its coefficient, where it is ``carried``."""
        raise NotImplementedError

    def columns_of(
        self, context: Context, joints: Sequence[int], shapes: Sequence[Shape], own: bool = False
    ) -> Array:
        """``columns`` of several shapes side by side, k per shape; own: those of ``joints[0]``'s
        equation alone, (N, …), even where others feel the effect."""
        together = np.concatenate([self.columns(context, joints, s) for s in shapes], axis=-1)
        return together[:, joints[0]] if own and self.reaches_other_joints else together

    def as_property(self, coefficients: Array, shape: Shape) -> float:
        """What the place of ``joint_property`` holds of it."""
        return float(coefficients[0])

    def starts(self, context: Context, joints: Sequence[int]) -> list[Shape]:
        """Shapes from which the nonlinear search begins; one empty shape where there is none."""
        return [{}]

    def could_be(self, robot: Robot, coefficients: Array, covariance: Array) -> bool:
        """Can it be this effect on that robot, by coefficients (k,) and their covariance (k, k)?
        A nuisance that a fit may choose freely can be bound to what it comes from."""
        return True

    def penalty(self, shape: Shape) -> Array | None:
        """Rows R (r, k) in 1/(N·m): every fit keeps ‖R·coefficients‖² small beside the squared
        error in units of its noise; None: the data alone decide."""
        return None

    def outside(self, context: Context, shape: Shape) -> NDArray[np.bool_] | None:
        """(N,) samples beyond what the effect was fitted on; None: it holds anywhere."""
        return None

    def is_itself(self, shape: Shape, low: float, high: float) -> bool:
        """Not ``otherwise`` by its name, or nothing that was seen, where the joint was between two
        angles (rad, m)."""
        return True

    def relinearised(self, coefficients: Array, shape: Shape) -> dict[str, float]:
        """The shape at which columns are to be taken next, where they are a secant of a
        nonlinear law and the coefficients have become known better."""
        return dict(shape)

    def speaks_on(self, joints: Sequence[int]) -> list[int] | slice:
        """Joints whose error speaks for or against it: of an effect of one equation its own. What
        it shifts elsewhere, by way of parameters that joints share, is no evidence for it."""
        everywhere = self.reaches_other_joints or self.seen_by_shared_bodies
        return list(joints) if joints and not everywhere else slice(None)

    def shown_by(self, parameter: str) -> str:
        """The experiment, in words, that determines one of its parameters."""
        rounds = any(s.name == parameter and s.smoothing for s in self.shapes)
        return "Slow reversals" if rounds else self.experiment.rstrip(".")

    def never_shown(self, robot: Robot, joints: Sequence[int]) -> frozenset[str]:
        """Its parameters that no motion of this arm can show, on these joints."""
        return frozenset()

    def shapes_in(self, shape: Mapping[str, object]) -> list[ShapeParameter]:
        """The shape parameters that this case of the effect has."""
        return [s for s in self.shapes if not s.optional or s.name in shape]

    def bent(self, shape: Shape) -> bool:
        """Is a shape at the end of its range, where the effect has turned into another one?"""
        return any(s.at_edge(shape[s.name]) for s in self.shapes_in(shape))

    def values(
        self, coefficients: Array, covariance: Array, shape: Shape, shape_errors: Shape
    ) -> dict[str, Value]:
        """Parameters as a person wants them: name -> value, standard error, unit."""
        out = {
            c.name: fitted(float(v), float(np.sqrt(max(s, 0.0))), c.unit)
            for c, v, s in zip(self.coefficients, coefficients, np.diag(covariance), strict=True)
            if not c.nuisance
        }
        for c in self.coefficients:
            if c.whole_at_one:
                out[c.name] = out[c.name].whole_at(1.0)
        for s in self.shapes_in(shape):
            value, error = float(shape[s.name]), float(shape_errors.get(s.name, 0.0))
            known, means = s.determined(value, error), s.says.get(value, "")
            out[s.name] = Value(value, error, s.unit, determined=known, means=means)
        return out

    def beside_link(self, values: dict[str, Value], inertia: float) -> dict[str, Value]:
        """The same, and what follows from them and from the inertia that the joint moves, kg·m² of
        rotor and link."""
        return values


def fitted(value: float, std_error: float, unit: str) -> Value:
    """Nothing, known for sure, is what a fit leaves of a direction that the data do not show."""
    return Value(value, std_error, unit, determined=value != 0.0 or std_error > 0.0)


def speed_quantiles(context: Context, joint: int, shares: Sequence[float]) -> list[float]:
    """Speeds |q̇_j| (rad/s) below which the given shares of the moving samples lie."""
    speed = np.abs(context.dq[:, joint])
    moving = speed[speed > 0.01 * max(float(speed.max()), 1e-9)]
    if len(moving) == 0:
        return [1.0 for _ in shares]
    return [float(v) for v in np.quantile(moving, shares)]
