"""A base parameter that takes a rotor in says so: it is no mistake of the URDF's bodies."""

import model_examples as examples
import numpy as np

from pa10d.dynamics.rotors import Rotors, rotors_within
from pa10d.model.parameters import WITH_ROTOR, parameter_list, rotor_words


def test_words():
    rotors = Rotors(np.ones((2, 2), bool), (0, 1), np.array([[1.0, 0.0], [0.0, -2.2222222]]))
    assert [rotor_words(rotors, k) for k in (0, 1)] == [" + rotor 1", " - 2.22222·rotor 2"]


def test_lines_that_take_one_in_say_so():
    model = examples.textbook()
    within = rotors_within(model.robot, model.base)
    lines = parameter_list(model)[: len(model.h)]
    told = [WITH_ROTOR in line.flags for line in lines]
    assert told == (np.abs(within.share) > 1e-6).any(axis=1).tolist()
    assert any(told)
    assert [line.doubtful for line in lines] == [
        line.flags not in ([], [WITH_ROTOR]) for line in lines
    ]
    assert any(line.document()["doubtful"] is False for line in lines if WITH_ROTOR in line.flags)
    assert all(("rotor" in line.meaning) == flag for line, flag in zip(lines, told, strict=True))
