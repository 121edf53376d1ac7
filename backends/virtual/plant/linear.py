"""Inverse of a small symmetric positive definite matrix, in compiled code, without allocation."""

from __future__ import annotations

import math

from backends.virtual.plant.compiled import inner
from backends.virtual.plant.records import Array


@inner
def invert(a: Array, out: Array) -> None:
    """out = a⁻¹ by Cholesky; the lower triangle of a is overwritten by the inverse factor."""
    n = a.shape[0]
    for j in range(n):
        pivot = a[j, j]
        for k in range(j):
            pivot -= a[j, k] * a[j, k]
        root = math.sqrt(pivot)
        a[j, j] = 1.0 / root
        for i in range(j + 1, n):
            value = a[i, j]
            for k in range(j):
                value -= a[i, k] * a[j, k]
            a[i, j] = value / root
    for j in range(n):
        for i in range(j + 1, n):
            value = 0.0
            for k in range(j, i):
                value -= a[i, k] * a[k, j]
            a[i, j] = value * a[i, i]
    for i in range(n):
        for j in range(i + 1):
            value = 0.0
            for k in range(i, n):
                value += a[k, i] * a[k, j]
            out[i, j] = value
            out[j, i] = value
