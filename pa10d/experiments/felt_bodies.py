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

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from pa10d.control.joint_figures import DRAWS, JointFigures
from pa10d.dynamics import Robot
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

Row = tuple[Array, Array, Array]
Motion = tuple[Array, Array, float]


@dataclass(frozen=True)
class _Estimate:
    """likeliest: bodies (10n,), with a gravity that leans its angles, rad (2,), behind them; inner,
    root: of their covariance root·inner·rootᵀ; left: squared standard errors left over."""

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
) -> _Estimate | None:
    """The same with a gravity that leans; None where that explains little more."""
    if not robot.gravity.any():
        return None
    found, bodies, angle = straight, straight.likeliest, np.zeros(2)
    for _ in range(ROUNDS):
        found = _estimate(robot, figures, seen, measured, (bodies, angle))
        bodies, angle = found.likeliest[:-2], found.likeliest[-2:]
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
) -> _Estimate:
    """measured: rows beside those of ``seen``; near: bodies and a leaning gravity (2,) rad about
    which it is linear."""
    mean, spread = robot.parameters.ravel(), _prior(robot)
    size, here, sides = len(mean), robot, np.zeros((0, 3))
    bodies, angle = (mean, np.zeros(0)) if near is None else near
    if near is not None:
        sides = _across(robot)
        here = robot.with_gravity(robot.gravity + angle @ sides)
        mean = np.append(mean, np.zeros(2))
        spread = scipy.linalg.block_diag(spread, LEANS**2 * np.eye(2))
    tables = []
    for one in seen:
        rows, wanted, error = rows_felt(here, figures, *one)
        for k, side in enumerate(sides):
            more = rows_felt(here.with_gravity(here.gravity + side), figures, *one)[0]
            leans = (more - rows[:, :size]) @ bodies
            wanted = wanted + leans * angle[k]
            rows = np.column_stack([rows, leans])
        tables.append((rows, wanted, error))
    wide = [(np.pad(rows, ((0, 0), (0, len(sides)))), *rest) for rows, *rest in measured]
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
    weightless = robot.with_gravity(np.zeros(3))
    unit = np.eye(robot.n)[j][None]
    row = regressor(weightless, pose[None], 0.0 * unit, unit)[0, j]
    own = float(row @ robot.parameters.ravel())
    measured = figures.link[j] * own
    return row[None], np.array([measured]), np.array([ABOUT * (figures.rotor[j] + measured)])


def rows_felt(
    robot: Robot, figures: JointFigures, q: Array, torque: Array, rate: float
) -> tuple[Array, Array, Array]:
    """Regressor rows (M, 10n), N·m that bodies had to give (M,), and its error N·m."""
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
    return rows[known], wanted[at][known], error[known]
