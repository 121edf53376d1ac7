"""What known weights tell of an arm's torques: values, as programs and people get them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class JointScale:
    """One joint, from 1. gain: measured over true torque, None where it is not determined
    (``why``); its error from noise and from the weight; between: bounds that friction with the load
    leaves; asked: N·m (rms) of the weight; map: what mends a recording."""

    joint: int
    name: str
    gain: float | None
    std_error: float | None
    of_noise: float | None
    of_weight: float | None
    between: tuple[float, float] | None
    friction_with_load: float | None
    disagree: bool
    asked: float | None
    why: str | None
    map: str

    @property
    def left_open(self) -> bool:
        """Whether friction with the load leaves more open than the error says."""
        if self.gain is None or self.std_error is None or self.friction_with_load is None:
            return False
        return self.friction_with_load * abs(self.gain) > 2 * self.std_error

    @property
    def row(self) -> list[str]:
        """Joint, name, gain, bounds, what mends a recording."""
        return [str(self.joint), self.name, self.gain_in_words, self.bounds_in_words, self.map]

    @property
    def gain_in_words(self) -> str:
        """``1.1203 ± 0.0041``, or why it is not determined."""
        if self.gain is None:
            return f"not determined: {self.why}"
        said = " (recordings disagree)" if self.disagree else ""
        return f"{self.gain:.4f} ± {self.std_error:.4f}{said}"

    @property
    def bounds_in_words(self) -> str:
        """What friction with the load leaves open, or nothing."""
        return "" if self.between is None else "{:.3g} … {:.3g}".format(*self.between)


@dataclass(frozen=True)
class WeightProspect:
    """What a weight at hand would bring. weight: as it was given; std_error: of each joint's gain,
    worst: the largest; too_much: the joint, from 1, that it would overload; aside: joints that it
    would tell of, hung to the side along ``axis``; next: whether it is the one to hang."""

    weight: str
    mass: float
    std_error: tuple[float | None, ...]
    worst: float | None
    too_much: int | None
    aside: tuple[int, ...]
    axis: str | None
    next: bool

    @property
    def row(self) -> list[str]:
        """Mass, and to what it would tell each joint's gain."""
        errors = ("-" if error is None else f"{error:.2%}" for error in self.std_error)
        return [f"{self.mass:g} kg{' (next)' if self.next else ''}", *errors]


@dataclass(frozen=True)
class TorqueScale:
    """Of all joints, and what to hang next. next_mass: kg that is not at hand."""

    joints: tuple[JointScale, ...]
    prospects: tuple[WeightProspect, ...]
    next_mass: float | None
    advice: str
