"""Single parameters that somebody knows, weighed against the data as the textbooks do."""

from __future__ import annotations

import numpy as np
import pytest
from synthetic import estimates, fourier, pa10_truth, recording

from pa10d.common.errors import UserError
from pa10d.dynamics.rotors import rotors_within
from pa10d.identify import identify
from pa10d.identify.blocks import Pieces
from pa10d.identify.fit import weighted_fit
from pa10d.identify.given import placed, read_given
from pa10d.identify.prior import Prior
from pa10d.identify.smoothing import Smoothing, with_smoothing
from pa10d.model.parameters import parameter_list
from pa10d.regression.layout import textbook
from pa10d.regression.problem import LinearProblem

TRUTH = pa10_truth(3)
FC3 = "coulomb J3: Fc"


def recorded(moving=(1.0, 1.0, 1.0)):
    t, q, dq, ddq = fourier(3, 12.0, 250.0, seed=3)
    motion = t, q * moving, dq * moving, ddq * moving
    return recording(TRUTH, motion, 0.3 * np.random.default_rng(3).normal(size=q.shape))


@pytest.fixture(scope="module")
def run():
    return recorded()


@pytest.fixture(scope="module")
def free(run):
    return fitted(run)


def fitted(run, *given, **how):
    return identify([run], TRUTH.robot, name="m", cutoff=10.0, given=given, **how)


def place(model, name: str = FC3) -> int:
    return model.parameter_names().index(name)


def errors(model):
    return np.sqrt(np.diag(model.covariance))[: len(estimates(model))]


@pytest.fixture(scope="module")
def problem(run):
    """Pieces, layout, smoothing and what the data alone say."""
    known = Smoothing(np.full(3, 0.01), np.zeros(3, dtype=bool), np.full(3, np.inf))
    layout = with_smoothing(textbook(TRUTH.robot), known)
    pieces = Pieces([run], TRUTH.robot, layout, 10.0)
    return pieces, layout, known, weighted_fit(pieces, LinearProblem(layout), known)


@pytest.mark.parametrize("percent", [None, 20.0])
def test_least_squares_with_what_is_known_is_bayes_in_closed_form(problem, percent):
    pieces, layout, smoothing, data = problem
    said = [("Fc3", 6.0, 0.1), ("Fv1", 12.0, 0.5), ("Izz3", 0.1, 0.01), ("link J2: m", 12.0, 0.1)]
    known = Prior.of(layout, percent, said).beside(data).whole()
    found = weighted_fit(pieces, LinearProblem(layout, known), smoothing)
    normal = data.solution.triangle.T @ data.solution.triangle
    right = data.solution.triangle.T @ data.solution.target
    scale = 1 / np.sqrt(np.diag(normal + known.rows.T @ known.rows))
    whole = (normal + known.rows.T @ known.rows) * np.outer(scale, scale)
    closed = scale * np.linalg.solve(whole, scale * (right + known.rows.T @ known.target))
    size = np.sqrt(np.diag(found.uncertainty.covariance))
    assert np.abs((found.solution.beta - closed) / size).max() < 1e-6


def test_bodies_say_of_base_parameters_what_a_gaussian_in_all_of_them_says():
    """By the covariance of all standard parameters, of which base parameters are sums."""
    layout = textbook(TRUTH.robot)
    base = layout.base
    prior = Prior.of(layout, 20.0, [("link J3: m", 7.0, 0.5)])
    bodies = prior.beside().bodies
    spread = 1 / np.diag(bodies.rows)
    covariance = base.matrix() @ np.diag(spread**2) @ base.matrix().T
    mean = base.of(bodies.target * spread)
    whole = prior.beside().whole()
    rows = whole.rows[:, : len(base)]
    free = [k for k in range(len(base)) if np.isfinite(prior.std_errors[k])]
    np.testing.assert_allclose(
        prior.std_errors[free], np.sqrt(np.diag(covariance))[free], rtol=1e-6
    )
    np.testing.assert_allclose(rows @ mean, whole.target, atol=1e-6)


def test_one_value_is_the_mean_of_both_by_their_stated_errors(run, free):
    """Precision-weighted, whatever least squares takes its samples for."""
    i = place(free)
    data, doubt = estimates(free)[i], errors(free)[i]
    told = fitted(run, ("Fc3", data + 2.0 * doubt, doubt))
    assert estimates(told)[i] == pytest.approx(data + doubt, abs=0.05 * doubt)
    assert errors(told)[i] == pytest.approx(doubt / np.sqrt(2.0), rel=0.1)


def test_a_vanishing_error_fixes_the_value_in_every_fit(run, free):
    i = place(free)
    value = estimates(free)[i] + 10.0 * errors(free)[i]
    for how in ({}, {"robust": True}):
        told = fitted(run, ("Fc3", value, 0.0), **how)
        assert estimates(told)[i] == pytest.approx(value, rel=1e-6)
        assert told.notes.feasible.coefficients[FC3] == pytest.approx(value, rel=1e-3)
        flags = {one.name: one.flags for one in parameter_list(told)}
        assert flags[FC3] == ["from the prior"]


def test_an_endless_error_changes_nothing(run, free):
    told = fitted(run, ("Fc3", 1.0, np.inf), ("link J2: m", 3.0, np.inf))
    np.testing.assert_array_equal(estimates(told), estimates(free))
    far = fitted(run, ("Fc3", 1.0, 1e9), ("Izz3", 1.0, 1e9))
    assert np.abs((estimates(far) - estimates(free)) / errors(free)).max() < 1e-9
    np.testing.assert_allclose(errors(far), errors(free), rtol=1e-6)


def test_what_the_motion_does_not_show_is_what_was_given():
    poor = recorded((0.0, 1.0, 0.0))
    told = fitted(poor, ("rotor_inertia J3: Ia", 0.25, 0.05))
    (found,) = (one for one in parameter_list(told) if one.name == "rotor_inertia J3: Ia")
    value = found.value
    assert (value.value, value.std_error_random) == pytest.approx((0.25, 0.05), rel=1e-3)
    assert found.flags == ["from the prior"]


def test_feasible_bodies_have_the_mass_that_was_given(run, free):
    """Torque does not show it; and where nothing is at its bound, both programmes agree."""
    link = TRUTH.robot.parameters[2, 0]
    told = fitted(run, ("link J3: m", 1.5 * link, 0.01 * link))
    assert told.standard[2, 0] == pytest.approx(1.5 * link, rel=0.02)
    np.testing.assert_allclose(estimates(told), estimates(free), rtol=1e-9, atol=1e-12)
    within = rotors_within(TRUTH.robot, told.base)
    rotors = np.array(told.notes.feasible.rotors)[list(within.joints)]
    possible = told.base.of(told.standard) + within.share @ rotors
    off = (possible - told.h) / errors(told)[: len(told.h)]
    assert np.abs(off).max() < 0.5


def test_a_contradiction_is_said_in_one_line(run, free):
    i = place(free)
    value, doubt = estimates(free)[i], errors(free)[i]
    gain = TRUTH.robot.gain_share((2,)) * value
    off = value + 4.0 * np.hypot(doubt, gain)
    told = fitted(run, ("Fc3", off, 0.0))
    (said,) = [w for w in told.notes.warnings if "contradict" in w]
    assert said.startswith(f"{FC3} was given as {off:.4g} ± 0, the data alone say {value:.4g} ±")
    near = fitted(run, ("Fc3", value + 2.0 * np.hypot(doubt, gain), 0.0))
    assert not [w for w in near.notes.warnings if "contradict" in w]


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("Fc3=12±2", ("Fc3", 12.0, 2.0)),
        ("Fc3 = -1.2e1 +- .5", ("Fc3", -12.0, 0.5)),
        ("coulomb J3: Fc=12+/-10%", ("coulomb J3: Fc", 12.0, 1.2)),
        ("link J7: m = 1.5 ± 0", ("link J7: m", 1.5, 0.0)),
        ("m7=2±inf", ("m7", 2.0, np.inf)),
    ],
)
def test_how_it_may_be_written(text, found):
    assert read_given(text) == found


@pytest.mark.parametrize("text", ["Fc3", "Fc3=12", "Fc3=±2", "=12±2", "Fc3=12±-2", "Fc3=a±2", ""])
def test_what_is_no_statement_says_how_one_is_written(text):
    with pytest.raises(UserError, match=r"expected NAME=VALUE±ERROR, such as Fc3=12±2"):
        read_given(text)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        (
            "Fd3",
            r"no parameter of this model; did you mean F[cv]3\?; expected one of .*Fc1–3, Fv1–3",
        ),
        ("Ia1", "joint 1's rotor is one with its link, torque shows their sum"),
        ("v03", "a shape, which is searched for before the least squares"),
        ("Fc9", "no parameter of this model; did you mean Fc"),
    ],
)
def test_an_unknown_name_is_told_which_there_are(name, said):
    with pytest.raises(UserError, match=rf"^prior {name}: {said}") as caught:
        placed(textbook(TRUTH.robot), [(name, 1.0, 0.1)])
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 300


def test_a_name_may_be_long_or_short_and_a_links_own():
    layout = textbook(TRUTH.robot)
    said = [("fc3", 1.0, 0.1), ("coulomb J2: Fc", 1.0, 0.1), ("link j3:m", 1.0, 0.1)]
    first, second, third = placed(layout, said)
    assert (first.name, second.name, third.name) == (FC3, "coulomb J2: Fc", "link J3: m")
    assert (third.unknown, third.body) == (None, 20)
    with pytest.raises(UserError, match=r"coulomb J3: Fc is given twice"):
        placed(layout, [("Fc3", 1.0, 0.1), (FC3, 2.0, 0.1)])
    with pytest.raises(UserError, match=r"expected a value and an error of at least 0"):
        placed(layout, [("Fc3", 1.0, -0.1)])
