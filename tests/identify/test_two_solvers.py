"""Identification and search, given one problem and the same samples, give the same answer."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from synthetic import fourier, pa10_truth, recording

from pa10d.diagnose.evidence.errors_of import honest_covariance
from pa10d.diagnose.regression.side import Side
from pa10d.diagnose.regression.state import SearchState
from pa10d.identify import identify
from pa10d.identify.blocks import Pieces
from pa10d.identify.fit import weighted_fit
from pa10d.identify.prior import Prior
from pa10d.identify.smoothing import Smoothing, with_smoothing
from pa10d.regression.layout import textbook
from pa10d.regression.problem import LinearProblem

RATE, SECONDS, CUTOFF = 200.0, 20.0, 10.0


def noise(colour: str, shape: tuple[int, int], q: np.ndarray) -> np.ndarray:
    """White, or with what nobody models beside it."""
    white = np.random.default_rng(3).normal(size=shape)
    return white if colour == "white" else white + 3.0 * np.sin(5.0 * q[:, ::-1])


@pytest.mark.parametrize("colour", ["white", "lacking"])
@pytest.mark.parametrize("percent", [None, 20.0])
def test_two_solvers_of_one_problem_agree(colour, percent):
    truth = pa10_truth(2)
    motion = fourier(2, SECONDS, RATE, 1)
    run = recording(truth, motion, noise(colour, motion[1].shape, motion[1]))
    model = identify([run], truth.robot, name="m", cutoff=CUTOFF)
    v0 = np.array([t.shape["v0"] for t in model.terms if "v0" in t.shape])
    known = Smoothing(v0, np.zeros(2, dtype=bool), np.full(2, np.inf))  # no v0 is one more unknown
    layout = with_smoothing(textbook(truth.robot), known)
    sigma = np.array([1.0, 0.7])
    prior = None if percent is None else Prior.of(layout, percent).beside().whole()
    problem = LinearProblem(layout, prior, sigma)
    pieces = Pieces([run], truth.robot, layout, CUTOFF)
    streamed = weighted_fit(pieces, problem, known)

    side = Side.of([replace(piece.equation, keep=piece.moving) for piece in pieces])
    searched = SearchState.start(replace(model, terms=layout.terms), side, side)
    searched.problem = problem
    searched.refit()
    np.testing.assert_allclose(searched.fit.beta, streamed.solution.beta, rtol=1e-6, atol=1e-9)
    both = searched.fit.covariance(), streamed.solution.covariance()
    np.testing.assert_allclose(*both, rtol=1e-5, atol=1e-9 * np.abs(both[1]).max())
    assert searched.fit.rank == streamed.solution.rank
    errors = np.sqrt(np.diag(streamed.uncertainty.covariance))
    np.testing.assert_allclose(np.sqrt(np.diag(honest_covariance(searched))), errors, rtol=1e-5)
