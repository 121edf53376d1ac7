"""The model that most samples agree on, where some of them are knocked to one side."""

from __future__ import annotations

import numpy as np
import pytest
from bare_sides import bare_side

from pa10d.diagnose.regression.least_squares import least_squares
from pa10d.diagnose.regression.majority import agreed

TRUE = np.array([2.0, -1.0, 0.5])
NOISE = 0.05


def fitted(knocked: float):
    """A fit of one joint; that share of its samples is pushed up by a hundred times the noise."""
    rng = np.random.default_rng(4)
    columns = rng.standard_normal((4000, 3))
    columns[:, 2] = 1.0  # an offset, which a push to one side bends first
    tau = columns @ TRUE + NOISE * rng.standard_normal(4000)
    tau[rng.random(4000) < knocked] += 100 * NOISE
    return least_squares(bare_side([tau[:, None]]), {0: columns}, np.array([NOISE]))


@pytest.mark.parametrize("knocked", [0.05, 0.2])
def test_knocks_do_not_bend_what_most_samples_say(knocked):
    fit = fitted(knocked)
    few = 5 * NOISE / np.sqrt(2000)  # five standard errors
    assert abs(fit.beta[2] - TRUE[2]) > 10 * few  # least squares is bent
    np.testing.assert_allclose(agreed(fit), TRUE, atol=few)


def test_without_knocks_it_is_the_fit():
    fit = fitted(0.0)
    np.testing.assert_allclose(agreed(fit), fit.beta, atol=NOISE / np.sqrt(2000))
