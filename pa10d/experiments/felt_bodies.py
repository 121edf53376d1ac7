"""The arm's bodies as a first motion felt them: what a URDF says, moved as far as torques ask.

A linear Gaussian estimate (Rasmussen & Williams, Gaussian Processes for Machine Learning, 2006,
section 2.1): the URDF is the prior mean and how rough URDFs are the prior spread, so that what the
small motions did not show stays as the URDF has it. What is left in doubt is kept as draws, and the
pre-check predicts tracking for each of them.
"""

from __future__ import annotations

from collections.abc import Sequence

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


def felt_bodies(
    robot: Robot,
    figures: JointFigures,
    seen: Sequence[tuple[Array, Array, float]],
    shaken: Sequence[tuple[int, Array]] = (),
) -> Array:
    """(1 + DRAWS, n, 10) standard parameters: the likeliest, then draws of what they may be.

    figures: friction, rotors, inertias; seen: angle rad and sent torque N·m (N, n), rate Hz, per
    motion; shaken: joints (0-based) and poses (n,) rad in which their inertia was measured.
    """
    mean, spread = robot.parameters.ravel(), _prior(robot)
    information, pull = np.zeros_like(spread), np.zeros_like(mean)
    tables = [rows_felt(robot, figures, *one) for one in seen]
    tables += [_inertia_row(robot, figures, j, pose) for j, pose in shaken]
    for rows, wanted, error in tables:
        weighed = rows / error[:, None] ** 2
        information += weighed.T @ rows
        pull += weighed.T @ (wanted - rows @ mean)
    root = np.linalg.cholesky(spread)
    inner = np.linalg.inv(np.eye(len(mean)) + root.T @ information @ root)
    after = root @ inner @ root.T
    likeliest = mean + after @ pull
    apart = np.random.default_rng(0).standard_normal((DRAWS, len(mean)))
    draws = likeliest + apart @ np.linalg.cholesky(0.5 * (inner + inner.T)).T @ root.T
    return np.concatenate([likeliest[None], draws]).reshape(-1, robot.n, 10)


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
