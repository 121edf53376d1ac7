"""A model's parameters, one line each, as a person and a program want them."""

from __future__ import annotations

from dataclasses import dataclass

from pa10d.common.jsonable import JsonObject
from pa10d.dynamics.base import parameter_name
from pa10d.dynamics.rotors import Rotors, rotors_within
from pa10d.effects import Value
from pa10d.effects.smooth_map import EXPLAINS_NOTHING
from pa10d.model.model import TorqueModel

WEAK = 0.3  # of a value: a standard error above that
ROUNDING = 1e-6
UNCHANGED = 0.9  # of the standard error before the data: they told next to nothing
WITH_ROTOR = "with a rotor, of which the URDF says nothing"
NEAR = 1e-6  # of a range: as good as at its end


@dataclass(frozen=True)
class ParameterLine:
    """One parameter. meaning: in words; urdf: the same base parameter of the bodies that the URDF
    has, None for effects; flags: what is to be known of the value, in words."""

    name: str
    value: Value
    meaning: str
    urdf: float | None
    flags: list[str]

    @property
    def doubtful(self) -> bool:
        """Whether anything that is to be known puts the value in doubt; a rotor that is in it is
        only what it is made of."""
        return any(flag != WITH_ROTOR for flag in self.flags)

    def document(self) -> JsonObject:
        """As JSON: the value and its errors stand beside the rest."""
        return {
            "name": self.name,
            **self.value.document(),
            "meaning": self.meaning,
            "urdf": self.urdf,
            "flags": self.flags,
            "doubtful": self.doubtful,
        }


def parameter_list(model: TorqueModel) -> list[ParameterLine]:
    """One line per parameter, base parameters first."""
    urdf = model.base.of(model.robot.parameters)
    rotors = rotors_within(model.robot, model.base)
    sentences = model.base.sentences()
    known = model.notes.prior
    before = [*(known.std_errors if known else ())]
    before = [*before, *[None] * (sum(t.width for t in model.terms) + len(urdf) - len(before))]
    places = iter(before[len(urdf) :])
    found = [
        ParameterLine(
            name=parameter_name(int(k)),
            value=value,
            meaning=sentences[i] + (turning := rotor_words(rotors, i)),
            urdf=float(urdf[i]),
            flags=flags(value, before=before[i]) + ([WITH_ROTOR] if turning else []),
        )
        for i, (k, value) in enumerate(zip(model.base.kept, model.base_values, strict=True))
    ]
    for i, term in enumerate(model.terms):
        shapes = [shape for shape in term.effect.shapes if shape.scale != "choice"]
        bounds = {shape.name: (shape.lower, shape.upper) for shape in shapes}
        doubts = {c.name: next(places) for c in term.effect.coefficients}
        found += [
            ParameterLine(
                name=term.named(name),
                value=value,
                meaning=EXPLAINS_NOTHING if term.over else term.effect.equation,
                urdf=None,
                flags=flags(value, bounds.get(name), doubts.get(name)),
            )
            for name, value in model.term_values(i).items()
        ]
    return found


def rotor_words(rotors: Rotors, index: int) -> str:
    """`` - 2.22222·rotor 2``: what a base parameter takes in of rotors that bodies hide."""
    said = []
    for joint, factor in zip(rotors.joints, rotors.share[index], strict=True):
        if abs(factor) > ROUNDING:
            size = "" if abs(abs(factor) - 1.0) < ROUNDING else f"{abs(factor):.6g}·"
            said.append(f" {'+' if factor > 0 else '-'} {size}rotor {joint + 1}")
    return "".join(said)


def flags(
    value: Value, bounds: tuple[float, float] | None = None, before: float | None = None
) -> list[str]:
    """``not determined``, ``at its bound``, ``weak`` (a standard error above 30 % of the value),
    ``from the prior``: as unsure as before any data.

    before: standard error that the value had then; the torque constants' own is not the data's"""
    said = [] if value.determined else ["not determined"]
    if bounds is not None and min(abs(value.value - bound) for bound in bounds) <= NEAR * (
        bounds[1] - bounds[0]
    ):
        said.append("at its bound")
    rounding = ROUNDING * value.std_error  # of a difference of squares
    own = value.std_error_random + rounding
    if value.determined and before is not None and own >= UNCHANGED * before:
        said.append("from the prior")
    elif value.determined and value.std_error > WEAK * abs(value.value):
        said.append("weak")
    return said
