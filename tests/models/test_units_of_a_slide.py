"""A joint that slides is told in newtons and metres, whatever its effects are called."""

from dataclasses import replace

import model_examples as examples
import numpy as np
import pytest

from pa10d.control.gains import PidGains
from pa10d.control.joint_figures import JointFigures
from pa10d.effects import Value, all_effects
from pa10d.experiments.measured_joints import sentences
from pa10d.model import in_units_of
from pa10d.model.impossible import impossible

SLIDES = replace(examples.ROBOT, prismatic=np.array([False, True, False, True]))


@pytest.mark.parametrize(
    ("turning", "sliding"),
    [
        ("N·m", "N"), ("N·m·s/rad", "N·s/m"), ("N·m/rad", "N/m"), ("rad/s", "m/s"), ("rad", "m"),
        ("kg·m²", "kg"), ("cycles/rev", "1/m"), ("1/(N·m)²", "1/(N)²"), ("s", "s"), ("1", "1"),
    ],
)  # fmt: skip
def test_units(turning, sliding):
    assert Value(1.5, 0.1, turning).of_a_slide() == Value(1.5, 0.1, sliding)


@pytest.mark.parametrize("effect_id", sorted(all_effects()))
def test_every_effect_of_a_slide_is_told_without_angles(effect_id):
    term = examples.some_term(effect_id)
    k = len(term.coefficients)
    values = term.effect.values(term.coefficients, np.eye(k), term.shape, {})
    told = in_units_of(SLIDES, replace(term, joints=term.joints and (1,)), values)
    if not term.joints:
        assert told == values
    else:
        assert not any("rad" in v.unit or "N·m" in v.unit for v in told.values())
    assert in_units_of(SLIDES, replace(term, joints=(0,)), values) == values


def test_what_cannot_exist_is_told_in_newtons():
    model = examples.textbook()
    light = tuple(replace(t, coefficients=-abs(t.coefficients)) for t in model.terms)
    said = impossible(replace(model, robot=SLIDES, terms=light))
    of_slide = [line for line in said if line.startswith("coulomb J2: Fc = ")]
    assert len(of_slide) == 1
    assert " N in the free fit" in of_slide[0]


def test_what_a_first_motion_found_of_a_slide_is_told_in_kilograms():
    """ "inertia 22 … 35 kg·m², friction 0.048 N·m" of a slide."""
    one = np.ones(4)
    figures = JointFigures(one, one, one, one, 0 * one, 50 * one, one, one, 0 * one)
    turning, sliding = sentences(SLIDES, figures, PidGains(one, one, one, one))[:2]
    for line, units in ((turning, ("kg·m²", "N·m", "N·m·s/rad")), (sliding, ("kg", "N", "N·s/m"))):
        assert f" {units[0]}, friction 1 {units[1]} + 1 {units[2]}, a spring of 50 " in line
    assert not any(turns in sliding for turns in ("N·m", "m²", "rad"))


def test_heads_of_columns():
    turns = replace(SLIDES, prismatic=np.zeros(4, bool))
    assert turns.torque_units() == "N·m"
    assert SLIDES.torque_units() == "N or N·m"
    assert [SLIDES.angle_unit(j) for j in range(2)] == ["rad", "m"]
