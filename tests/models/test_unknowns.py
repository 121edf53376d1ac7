"""What stands where in the vector of unknowns, for models and fits alike."""

import numpy as np

from pa10d.dynamics import robot_from_profile
from pa10d.effects import all_effects
from pa10d.model import Term, Unknowns, vector_of
from pa10d.profile import load_profile
from pa10d.regression.layout import has_sign, textbook


def layout(extra=()):
    return textbook(robot_from_profile(load_profile("pa10-sim")), extra)


def test_every_unknown_has_one_place_one_name_and_an_owner():
    unknowns = layout(["torque_offset", "stribeck"])
    filled = np.zeros(unknowns.size, dtype=int)
    filled[: len(unknowns.base)] += 1
    for place in unknowns.places:
        filled[place] += 1
    assert np.all(filled == 1)
    assert len(set(unknowns.names())) == len(unknowns.owners()) == unknowns.size


def test_terms_take_their_coefficients_and_give_them_back():
    unknowns = layout(["torque_offset"])
    beta = np.random.default_rng(1).normal(size=unknowns.size)
    terms = unknowns.fitted(beta)
    assert np.array_equal(vector_of(unknowns.rigid(beta), terms), beta)
    first = Unknowns(unknowns.base, terms).places[0]
    assert np.array_equal(terms[0].coefficients, beta[first])


def test_a_coefficient_stands_in_the_equations_that_see_it():
    found = layout(["torque_offset", "payload"])
    for j, index in enumerate(found.of_joint):
        for term, place in zip(found.terms, found.places, strict=True):
            inside = np.isin(np.arange(place.start, place.stop), index)
            assert inside.all() if term.touches(j) else not inside.any()


def test_the_textbook_is_what_says_so_of_itself():
    found = layout()
    kinds = {name for name, kind in all_effects().items() if kind.question == "textbook"}
    assert {term.effect_id for term in found.terms} == kinds
    signs = [term for term in found.terms for j in range(found.robot.n) if has_sign(term, j)]
    assert len(signs) == found.robot.n


def test_a_term_that_is_not_fitted_yet_has_no_torque():
    term = Term.of("viscous", (2,))
    assert term.width == 1
    assert not term.coefficients.any()
    assert term.touches(2)
    assert not term.touches(1)
