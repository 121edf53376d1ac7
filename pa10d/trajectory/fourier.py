"""Equation 13 of the paper as matrices: motion is linear in its Fourier coefficients."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def fourier_basis(fundamental: float, harmonics: int, t: Array) -> tuple[Array, Array, Array]:
    """(N, 1 + 2·harmonics) matrices for q, q̇, q̈ at times t (N,) s; fundamental in Hz.

    Coefficients are [q0, a_1 … a_H, b_1 … b_H] as in q0 + Σ a_l sin(ω l t) - b_l cos(ω l t).
    """
    order = 2.0 * np.pi * fundamental * np.arange(1.0, harmonics + 1)
    sine, cosine = np.sin(np.outer(t, order)), np.cos(np.outer(t, order))
    one, zero = np.ones((len(t), 1)), np.zeros((len(t), 1))
    return (
        np.hstack([one, sine, -cosine]),
        np.hstack([zero, cosine * order, sine * order]),
        np.hstack([zero, -sine * order**2, cosine * order**2]),
    )
