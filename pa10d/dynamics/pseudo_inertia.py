"""Pseudo-inertias: the matrices that tell whether a body with such parameters can exist."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LIGHTEST, SMALLEST = 0.1, 0.02  # kg, m: sizes below which a link's scale is not taken


def pseudo_inertia(parameters: Array) -> Array:
    """(..., 4, 4) of standard parameters (..., 10)."""
    p = np.asarray(parameters, dtype=float)
    return np.tensordot(p, pseudo_basis(), axes=1)


def definiteness(parameters: Array) -> Array:
    """(n,) smallest eigenvalue of each link's pseudo-inertia, in sizes of that link: > 0 is
    feasible. parameters: (n, 10)"""
    p = np.asarray(parameters, dtype=float)
    length = np.array([size(link)[1] for link in p])
    unit = scaled(pseudo_inertia(p), length)
    trace = np.trace(unit, axis1=1, axis2=2)
    smallest = np.linalg.eigvalsh(unit)[:, 0]
    return np.asarray(smallest / np.maximum(np.abs(trace), 1e-300))


def pseudo_basis() -> Array:
    """(10, 4, 4): pseudo-inertia of each unit parameter."""
    basis = np.zeros((10, 4, 4))
    basis[0, 3, 3] = 1.0
    for axis in range(3):
        basis[1 + axis, axis, 3] = basis[1 + axis, 3, axis] = 1.0
    for k, (i, j) in enumerate([(0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2)], start=4):
        if i == j:
            basis[k, :3, :3] = 0.5 * np.eye(3)
            basis[k, i, i] -= 1.0
        else:
            basis[k, i, j] = basis[k, j, i] = -1.0
    return basis


def size(link: Array) -> tuple[float, float]:
    """Mass and length that make a link's parameters numbers near one."""
    mass = max(abs(float(link[0])), LIGHTEST)
    moments = abs(link[4]) + abs(link[6]) + abs(link[9])
    return mass, max(float(np.sqrt(moments / 2 / mass)), SMALLEST)


def scales(link: Array) -> Array:
    """(10,) the sizes of a link's parameters."""
    mass, length = size(link)
    return np.array([mass] + [mass * length] * 3 + [mass * length**2] * 6)


def scaled(pseudo: Array, length: Array) -> Array:
    """Pseudo-inertias (n, 4, 4) with lengths in units of ``length`` (n,)."""
    d = np.ones((len(pseudo), 4))
    d[:, :3] /= length[:, None]
    return np.asarray(pseudo * d[:, :, None] * d[:, None, :])
