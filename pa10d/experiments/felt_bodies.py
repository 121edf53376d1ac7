"""The arm's bodies as a first motion felt them: what a URDF says, moved as far as torques ask.

A linear Gaussian estimate (Rasmussen & Williams, Gaussian Processes for Machine Learning, 2006,
section 2.1): the URDF is the prior mean and how rough URDFs are the prior spread, so that what the
small motions did not show stays as the URDF has it. What is left in doubt is kept as draws, and the
pre-check predicts tracking for each of them.

A base that leans against its profile is no matter of bodies: those that explain it in one pose are
far off in others. Where bodies leave much more than they do with a gravity that leans, too, they
are those beside it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.control.joint_figures import DRAWS, JointFigures
from pa10d.dynamics import Robot
from pa10d.dynamics.mass import mass_matrices
from pa10d.dynamics.regressor import regressor

Array = NDArray[np.float64]

SLOW = 2.0  # Hz below which torques are looked at
EVERY = 0.2  # s between samples
STANDS, SLIDES = 1e-3, 0.02  # rad/s: slower stands, faster slides
STEADY = 0.15  # s to either side in which it does the same
SHARE = 0.3  # of a body's mass, by which URDFs are wrong
SHIFTED = 0.15  # of a body's size, by which its centre of mass is elsewhere
TURNED = 0.6  # of its inertia
RUBS = 0.15  # of the dry friction that was measured, by which sliding friction differs
TRIFLE = 2e-3  # of the torque limit: currents, noise
ABOUT = 0.1  # of an inertia that was measured
ALIKE = 8.0  # samples of one place that err alike
LEANS = 0.2  # rad, by which a base may stand other than its profile says
ROUNDS = 3  # until what leans and what weighs agree
TIMES, SURE = 3.0, 6.0  # as much is left over without, and by so many standard errors
SOME = 200  # places of a motion that are looked at
WIDE = 3.0, 10.0  # times its link, and times the usual size, that a rotor may have

Row = tuple[Array, Array, Array]
Motion = tuple[Array, Array, float]


class FeltRows(NamedTuple):
    """bodies: regressor rows (M, 10n); wanted: N·m that bodies had to give (M,); error: its error
    N·m (M,); rise: rad/s² of each row's own joint, elsewhere 0, (M, n)."""

    bodies: Array
    wanted: Array
    error: Array
    rise: Array


@dataclass(frozen=True)
class ByWeight:
    """What slow torques tell of one joint: kg·m² of its link in P poses, and of its rotor, (P + 1,)
    in all, and their covariance (P + 1, P + 1)."""

    likeliest: Array
    spread: Array

    def of(self, poses: Sequence[int]) -> ByWeight:
        """In some of these poses alone."""
        kept = [*poses, len(self.likeliest) - 1]
        return ByWeight(self.likeliest[kept], self.spread[np.ix_(kept, kept)])


@dataclass(frozen=True)
class _Estimate:
    """likeliest: bodies (10n,), behind them angles of a gravity that leans, rad (2,), and what
    rotors have beyond what is known of them, kg·m² (n,), where these are asked; inner, root: of
    their covariance root·inner·rootᵀ; left: squared standard errors left over."""

    likeliest: Array
    inner: Array
    root: Array
    left: float


def felt_bodies(
    robot: Robot,
    figures: JointFigures,
    seen: Sequence[Motion],
    shaken: Sequence[tuple[int, Array]] = (),
) -> Array:
    """(1 + DRAWS, n, 10) standard parameters: the likeliest, then draws of what they may be.

    figures: friction, rotors, inertias; seen: angle rad and sent torque N·m (N, n), rate Hz, per
    motion; shaken: joints (0-based) and poses (n,) rad in which their inertia was measured.
    """
    measured = [_inertia_row(robot, figures, j, pose) for j, pose in shaken]
    found = _estimate(robot, figures, seen, measured)
    leaning = _leaning(robot, figures, seen, measured, found)
    found = found if leaning is None else leaning
    size, n = len(found.likeliest), robot.parameters.size
    apart = np.random.default_rng(0).standard_normal((DRAWS, n))
    apart = np.concatenate([apart, np.zeros((DRAWS, size - n))], axis=1)
    inner = np.linalg.cholesky(0.5 * (found.inner + found.inner.T))
    draws = found.likeliest + apart @ inner.T @ found.root.T
    return np.concatenate([found.likeliest[None], draws])[:, :n].reshape(-1, robot.n, 10)


def told_by_weight(
    robot: Robot,
    figures: JointFigures,
    seen: Sequence[Motion],
    poses: Mapping[int, Sequence[Array]],
) -> dict[int, ByWeight]:
    """Of joints (0-based) in some poses (n,) rad each. A link weighs, a rotor does not: what slow
    torques held and lifted tells the link, what they accelerated beyond it the rotor. figures:
    friction, and rotors as they are presumed."""
    straight = _estimate(robot, figures, seen, [], apart=True)
    leaning = _leaning(robot, figures, seen, [], straight, apart=True)
    found = straight if leaning is None else leaning
    spread = found.root @ found.inner @ found.root.T
    out = {}
    for j, some in poses.items():
        rows = np.zeros((len(some) + 1, len(found.likeliest)))
        for k, pose in enumerate(some):
            rows[k, : robot.parameters.size] = _inertia_of(robot, j, pose)
        rows[-1, len(found.likeliest) - robot.n + j] = 1.0
        likeliest = rows @ found.likeliest
        likeliest[-1] += figures.rotor[j]
        out[j] = ByWeight(likeliest, rows @ spread @ rows.T)
    return out


def gravity_felt(
    robot: Robot,
    figures: JointFigures,
    seen: Sequence[Motion],
    shaken: Sequence[tuple[int, Array]] = (),
) -> Array | None:
    """(3,) m/s² in the base frame, by what the joints weigh; None where it may as well be the
    profile's."""
    measured = [_inertia_row(robot, figures, j, pose) for j, pose in shaken]
    found = _estimate(robot, figures, seen, measured)
    leaning = _leaning(robot, figures, seen, measured, found)
    if leaning is None:
        return None
    leant = robot.gravity + leaning.likeliest[-2:] @ _across(robot)
    return np.asarray(leant * (np.linalg.norm(robot.gravity) / np.linalg.norm(leant)))


def _leaning(
    robot: Robot,
    figures: JointFigures,
    seen: Sequence[Motion],
    measured: Sequence[Row],
    straight: _Estimate,
    apart: bool = False,
) -> _Estimate | None:
    """The same with a gravity that leans; None where that explains little more."""
    if not robot.gravity.any():
        return None
    size = robot.parameters.size
    found, bodies, angle = straight, straight.likeliest[:size], np.zeros(2)
    for _ in range(ROUNDS):
        found = _estimate(robot, figures, seen, measured, (bodies, angle), apart)
        bodies, angle = found.likeliest[:size], found.likeliest[size : size + 2]
    more = straight.left - found.left
    return found if more >= SURE**2 and straight.left >= TIMES**2 * found.left else None


def _across(robot: Robot) -> Array:
    """(2, 3) m/s² per rad, by which gravity leans."""
    strength = float(np.linalg.norm(robot.gravity))
    return np.asarray(strength * np.linalg.svd(robot.gravity[None])[2][1:])


def _estimate(
    robot: Robot,
    figures: JointFigures,
    seen: Sequence[Motion],
    measured: Sequence[Row],
    near: tuple[Array, Array] | None = None,
    apart: bool = False,
) -> _Estimate:
    """measured: rows beside those of ``seen``; near: bodies and a leaning gravity (2,) rad about
    which it is linear; apart: rotors are asked as well."""
    mean, spread = robot.parameters.ravel(), _prior(robot)
    here, sides = robot, np.zeros((0, 3))
    bodies, angle = (mean, np.zeros(0)) if near is None else near
    if near is not None:
        sides = _across(robot)
        here = robot.with_gravity(robot.gravity + angle @ sides)
        spread = scipy.linalg.block_diag(spread, LEANS**2 * np.eye(2))
    if apart:
        spread = scipy.linalg.block_diag(spread, np.diag(_rotors(robot, figures, seen) ** 2))
    mean = np.append(mean, np.zeros(len(spread) - len(mean)))
    tables = []
    for one in seen:
        felt = rows_felt(here, figures, *one)
        rows, wanted = felt.bodies, felt.wanted
        for k, side in enumerate(sides):
            more = rows_felt(here.with_gravity(here.gravity + side), figures, *one).bodies
            leans = (more - felt.bodies) @ bodies
            wanted = wanted + leans * angle[k]
            rows = np.column_stack([rows, leans])
        rows = np.column_stack([rows, felt.rise]) if apart else rows
        tables.append((rows, wanted, felt.error))
    wide = [(np.pad(rows, ((0, 0), (0, len(mean) - rows.shape[1]))), *rest)
            for rows, *rest in measured]  # fmt: skip
    information, pull = np.zeros_like(spread), np.zeros_like(mean)
    for rows, wanted, error in (*tables, *wide):
        weighed = rows / error[:, None] ** 2
        information += weighed.T @ rows
        pull += weighed.T @ (wanted - rows @ mean)
    root = np.asarray(np.linalg.cholesky(spread), dtype=float)
    inner = np.asarray(np.linalg.inv(np.eye(len(mean)) + root.T @ information @ root), dtype=float)
    likeliest = mean + root @ inner @ root.T @ pull
    left = sum(float((((w - r @ likeliest) / e) ** 2).sum()) for r, w, e in tables)
    return _Estimate(likeliest, inner, root, left)


def _rotors(robot: Robot, figures: JointFigures, seen: Sequence[Motion]) -> Array:
    """(n,) kg·m² that rotors may have beside links as they are where the arm has been."""
    places = np.concatenate([q[:: max(1, len(q) // SOME)] for q, _, _ in seen])
    own = np.diagonal(mass_matrices(robot, places), axis1=1, axis2=2).max(axis=0)
    return np.asarray(WIDE[0] * np.maximum(own, 1e-9) + WIDE[1] * figures.rotor)


def _prior(robot: Robot) -> Array:
    """(10n, 10n) covariance: a body heavier as a whole, its centre elsewhere, its inertia wrong."""
    out = np.zeros((10 * robot.n, 10 * robot.n))
    least = 1e-6 * max(float(np.abs(robot.parameters).max()), 1e-6)
    for j, body in enumerate(robot.parameters):
        mass, first, turning = body[0], body[1:4], body[4:10]
        around = max(turning[0] + turning[2] + turning[5], 0.0)
        size = np.sqrt(around / mass) if mass > 0 else 0.0
        own = np.zeros(10)
        own[1:4] = SHIFTED * mass * max(size, float(np.linalg.norm(first)) / max(mass, least))
        own[4:10] = TURNED * around
        at = slice(10 * j, 10 * j + 10)
        out[at, at] = SHARE**2 * np.outer(body, body) + np.diag(own**2 + least**2)
    return out


def _inertia_row(
    robot: Robot, figures: JointFigures, j: int, pose: Array
) -> tuple[Array, Array, Array]:
    """One row: what the bodies have about joint j in this pose."""
    row = _inertia_of(robot, j, pose)
    measured = figures.link[j] * float(row @ robot.parameters.ravel())
    return row[None], np.array([measured]), np.array([ABOUT * (figures.rotor[j] + measured)])


def _inertia_of(robot: Robot, j: int, pose: Array) -> Array:
    """(10n,) that standard parameters are multiplied by to be the inertia about joint j."""
    weightless, unit = robot.with_gravity(np.zeros(3)), np.eye(robot.n)[j][None]
    return np.asarray(regressor(weightless, pose[None], 0.0 * unit, unit)[0, j])


def rows_felt(
    robot: Robot, figures: JointFigures, q: Array, torque: Array, rate: float
) -> FeltRows:
    """Of a motion (N, n) rad with its sent torque N·m, where each joint stands or slides."""
    low = scipy.signal.butter(2, min(SLOW, 0.1 * rate), fs=rate, output="sos")
    angle, effort = (scipy.signal.sosfiltfilt(low, x, axis=0) for x in (q, torque))
    speed = np.gradient(angle, 1.0 / rate, axis=0)
    rise = np.gradient(speed, 1.0 / rate, axis=0)
    width = max(1, round(STEADY * rate))
    lowest = scipy.ndimage.minimum_filter1d(speed, 2 * width + 1, axis=0)
    highest = scipy.ndimage.maximum_filter1d(speed, 2 * width + 1, axis=0)
    slides = (lowest > SLIDES) | (highest < -SLIDES)
    stands = (lowest > -STANDS) & (highest < STANDS)
    at = np.arange(width, len(q) - width, max(1, round(EVERY * rate)))
    friction = slides * (figures.coulomb * np.sign(speed) + figures.viscous * speed)
    wanted = effort - friction - figures.rotor * rise
    trifle = TRIFLE * np.where(np.isfinite(robot.effort), robot.effort, 1.0)
    error = np.sqrt(ALIKE) * (np.where(slides[at], RUBS, 0.7) * figures.coulomb + trifle)
    known = (slides | stands)[at]
    rows = regressor(robot, angle[at], speed[at], rise[at])
    own = rise[at][:, :, None] * np.eye(robot.n)
    return FeltRows(rows[known], wanted[at][known], error[known], own[known])
