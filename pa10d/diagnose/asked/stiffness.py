"""How stiff a smooth map is to be: what the data themselves say, by restricted likelihood.

A penalised least-squares map is the mean of a random surface given the data; how rough that
surface is drawn is the ratio of two variances, which are estimated as in any mixed model (Wood,
Fast stable restricted maximum likelihood, J. R. Statist. Soc. B 73, 2011). Unlike cross-validation
over single samples this is not led astray by coloured noise (Krivobokova & Kauermann, A note on
penalized spline smoothing with correlated errors, J. Am. Statist. Assoc. 102, 2007).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from pa10d.diagnose.constants import STIFFNESS_ROUNDING, STIFFNESSES

Array = NDArray[np.float64]


@dataclass(frozen=True)
class NormalEquations:
    """What the data say of k coefficients, in units of the noise, the model projected out.

    gram (k, k), rhs (k,): normal equations; power: squares of the target; rows: how many
    penalty (k, k): of the coefficients at stiffness 1, of full rank
    """

    gram: Array
    rhs: Array
    power: float
    rows: int
    penalty: Array


@dataclass(frozen=True)
class Stiffness:
    """ratio: penalty per squared error; variance: of the noise, in the problem's units; theta (k,):
    the map; freedom: how many independent coefficients the map amounts to"""

    ratio: float
    variance: float
    theta: Array
    freedom: float


def stiffness(problem: NormalEquations, alike: float) -> Stiffness:
    """The most likely one; alike: how many neighbouring samples say the same thing, as the noise
    is correlated."""
    root = scipy.linalg.cholesky(problem.penalty, lower=True)
    half = scipy.linalg.solve_triangular(root, problem.gram, lower=True)
    strength, turn = np.linalg.eigh(scipy.linalg.solve_triangular(root, half.T, lower=True))
    strength = np.maximum(strength, 0.0)
    along = turn.T @ scipy.linalg.solve_triangular(root, problem.rhs, lower=True)
    samples = max(problem.rows / alike, 2.0)
    floor = max(STIFFNESS_ROUNDING * problem.power, 1e-300)
    tried = STIFFNESSES * max(float(np.mean(strength)), 1e-300)

    def left(ratio: float) -> float:
        return max(problem.power - float(np.sum(along**2 / (strength + ratio))), floor)

    def unlikelihood(ratio: float) -> float:
        roughness = float(np.sum(np.log1p(strength / ratio)))
        return samples * np.log(left(ratio)) + roughness

    best = float(min(tried, key=unlikelihood))
    theta = scipy.linalg.solve_triangular(root.T, turn @ (along / (strength + best)), lower=False)
    return Stiffness(
        ratio=best,
        variance=left(best) / problem.rows,
        theta=np.asarray(theta),
        freedom=float(np.sum(strength / (strength + best))),
    )
