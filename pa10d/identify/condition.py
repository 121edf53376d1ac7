"""The condition number of the textbook problem, always of the same matrix.

2-norm, SI units, unweighted, all samples; columns: the numerical base of inertial parameters and
rotor inertia (pivoted from the right-hand link inwards), and for each joint's friction
2/π·atan(50·q̇) and q̇. 32 columns for the first four joints of a PA10, 62 for seven.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from pa10d.dynamics import Robot, regressor
from pa10d.regression.layout import Layout, textbook
from pa10d.regression.triangle import Triangle

Array = NDArray[np.float64]
Motion = tuple[Array, Array, Array]

BLOCK = 20_000  # samples at a time
IN_CACHE = 2_000
GRAM_LIMIT = 1e6  # beyond this the Gram matrix has lost too many digits


def condition_number(
    robot: Robot, motions: Sequence[Motion], layout: Layout | None = None
) -> float:
    """Of all samples of some motions: q, q̇, q̈ each (N, n) in rad, rad/s, rad/s²."""
    layout = layout or textbook(robot)
    gram = np.zeros((len(layout.base) + 3 * robot.n,) * 2)
    for q, dq, ddq in motions:
        for start in range(0, len(q), BLOCK):
            part = slice(start, start + BLOCK)
            raw = np.zeros((robot.n, len(layout.base), len(q[part])))
            regressor(
                robot, q[part], dq[part], ddq[part], layout.base.kept, out=raw.transpose(2, 0, 1)
            )
            gram += textbook_gram(layout, raw, dq[part], ddq[part])
    found = condition_of_gram(layout, gram)
    return found if found < GRAM_LIMIT else by_triangle(layout, motions)


def textbook_gram(layout: Layout, rigid: Array, dq: Array, ddq: Array) -> Array:
    """Gram matrix of [base, rotor inertia, Coulomb, viscous] (b+3n) from raw regressor columns
    (n, b, N), all rotor inertias included."""
    n, b = layout.robot.n, len(layout.base)
    gram = np.zeros((b + 3 * n, b + 3 * n))
    for j in range(n):
        seen = np.flatnonzero(layout.seen[j])
        index = np.concatenate([seen, b + j + n * np.arange(3)])
        own = _own(dq[:, j], ddq[:, j])
        for start in range(0, rigid.shape[2], IN_CACHE):
            part = slice(start, start + IN_CACHE)
            rows = np.concatenate([rigid[j, seen, part], own[:, part]])
            gram[np.ix_(index, index)] += rows @ rows.T
    return gram


def condition_of_gram(layout: Layout, gram: Array) -> float:
    """Condition number from the Gram matrix of all textbook columns, redundant ones left out."""
    kept = _kept(layout)
    values = np.linalg.eigvalsh(gram[np.ix_(kept, kept)])
    if values[0] <= values[-1] * 1e-15:
        return float("inf")
    return float(np.sqrt(values[-1] / values[0]))


def by_triangle(layout: Layout, motions: Iterable[Motion]) -> float:
    """The same where a Gram matrix has lost the digits: by orthogonal reduction."""
    n, b = layout.robot.n, len(layout.base)
    triangle = Triangle(b + 3 * n)
    for q, dq, ddq in motions:
        for start in range(0, len(q), BLOCK):
            part = slice(start, start + BLOCK)
            rigid = regressor(layout.robot, q[part], dq[part], ddq[part], layout.base.kept)
            for j in range(n):
                rows = np.zeros((len(rigid), b + 3 * n))
                rows[:, :b] = rigid[:, j]
                rows[:, b + j + n * np.arange(3)] = _own(dq[part, j], ddq[part, j]).T
                triangle.add(rows)
    values = np.linalg.svd(triangle.r[:, _kept(layout)], compute_uv=False)
    return float(values[0] / values[-1]) if values[-1] > values[0] * 1e-15 else float("inf")


def _own(dq: Array, ddq: Array) -> Array:
    return np.stack([ddq, 2.0 / np.pi * np.arctan(50.0 * dq), dq])


def _kept(layout: Layout) -> NDArray[np.int64]:
    n, b = layout.robot.n, len(layout.base)
    rotors = [t.joints[0] for t in layout.terms if t.effect.is_rotor]
    return np.concatenate(
        [np.arange(b), b + np.array(rotors, dtype=np.int64), b + n + np.arange(2 * n)]
    )
