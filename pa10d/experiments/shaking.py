"""Small torques on top of a first motion: many frequencies at once, while the joint slides.

A joint that slides has friction of one sign, so what the small torques do shows inertia, viscous
friction, delay and springs alone; at rest it would stick. Amplitudes are such that the joint never
turns round, be it three times as light as is thought, or its rotor alone on a spring. Half of what
its viscous friction takes is added: a light joint that rubs would hardly move else, and a
neighbour's sway be taken for its own. A light joint further out may be flung about by it: then it
is shaken less. Schroeder phases keep the peaks low (Schroeder, Synthesis of
low-peak-factor signals, IEEE Trans. Inf. Theory 16, 1970).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pa10d.control.gains import WORN
from pa10d.control.held_friction import CREPT
from pa10d.control.joint_figures import JointFigures
from pa10d.dynamics import Robot, inverse_dynamics
from pa10d.dynamics.mass import mass_matrices
from pa10d.experiments.wound_springs import FORGETS, links_of
from pa10d.trajectory.kinds.first_motion import PERIOD, shaken_joint
from pa10d.trajectory.motions import MotionSamples
from pa10d.trajectory.plan import Plan

Array = NDArray[np.float64]

LOWEST, HIGHEST = 2.0, 60.0  # Hz
OF_RATE = 0.125  # of the loop's rate: highest frequency
LINES = 16
APART = 2  # lines of a window's spectrum: Hann's, so that slow drift stays out of the others
SWING = 0.8  # of the joint's steady speed, that the small torques may take from it or add
FLUNG = 0.8  # of its speed limit, that another joint may be given by it, were it free
SOFT, SOFT_MOST = 0.024, 12.0  # of the loop's rate, Hz: above it a spring may hide the link
SHARP = 0.02  # rad/s at which friction of the reference has its full size, at once


def lines_of(rate: float) -> Array:
    """(K,) Hz that are looked at, whole periods of the window each."""
    top = min(HIGHEST, OF_RATE * rate)
    kept: list[float] = []
    for line in np.round(np.geomspace(LOWEST, top, LINES) * PERIOD):
        if not kept or line - kept[-1] >= APART:
            kept.append(float(line))
    return np.array(kept) / PERIOD


def torque_ahead(
    robot: Robot,
    figures: JointFigures,
    motion: MotionSamples,
    as_felt: int = 0,
    loss: float = FORGETS,
) -> Array:
    """(N, n) N·m of what was measured, along a desired motion (N, n) that begins at rest: friction,
    own inertia, gravity and coupling of the bodies as they were felt (``as_felt``: which of them);
    gravity without what holds the arm at the beginning. loss: of critical damping, of springs."""
    bodies = figures.bodies[as_felt] if len(figures.bodies) else robot.parameters
    friction = figures.coulomb * sliding(motion.q, motion.dq) + figures.viscous * motion.dq
    _, q, dq, ddq = links_of(robot, figures, bodies, motion, loss)
    if len(figures.bodies):
        felt = inverse_dynamics(robot, bodies, q, dq, ddq)
        links = felt - felt[0]
    else:
        own = np.diagonal(mass_matrices(robot, q), axis1=1, axis2=2)
        links = figures.link * own * ddq
    return np.asarray(friction + figures.rotor * motion.ddq + links)


def sliding(q: Array, dq: Array) -> Array:
    """(N, n) share of dry friction, with its sign, that joints slide against along a path (N, n):
    all of it where they are fast, or farther than ``CREPT`` from where they stand or turn round. On
    a slow path a joint has to slide, too: what is not given ahead the servo has to give, and one
    that is soft beside friction would not."""
    sense, last = np.sign(dq), len(q) - 1
    rows, turns = np.arange(len(q))[:, None], sense[1:] != sense[:-1]
    begun = np.vstack([np.zeros((1, q.shape[1])), np.where(turns, rows[:-1], 0)]).astype(int)
    ended = np.vstack([np.where(turns, rows[1:], last), np.full((1, q.shape[1]), last)])
    since = np.maximum.accumulate(begun, axis=0)
    until = np.minimum.accumulate(ended[::-1], axis=0)[::-1]
    ways = [np.abs(q - np.take_along_axis(q, end, axis=0)) for end in (since, until)]
    share = np.minimum(np.minimum(*ways) / CREPT, 1.0)
    return np.asarray(sense * np.maximum(np.abs(np.tanh(dq / SHARP)), share))


def small_torques(plan: Plan, robot: Robot, figures: JointFigures, t: Array, rate: float) -> Array:
    """(N, n) N·m at times t (N,) s of the plan."""
    out = np.zeros((len(t), robot.n))
    for span in plan.spans:
        j = shaken_joint(span.label)
        if j is None:
            continue
        middle = np.array([0.5 * (span.begin + span.end)])
        q, dq, _ = plan.at(middle)
        mass = mass_matrices(robot, q)[0]
        link = figures.link[j] * mass[j, j]
        lines, soft = lines_of(rate), min(SOFT * rate, SOFT_MOST)
        if np.isfinite(figures.stiffness[j]):  # above its swing the link stays where it is
            soft = min(soft, float(np.sqrt(figures.stiffness[j] / link)) / (2.0 * np.pi))
        inertia = figures.rotor[j] + link / (1.0 + (lines / soft) ** 2)
        inside = (t >= span.begin) & (t <= span.end)
        rubs = WORN * float(figures.viscous[j])
        shape = multisine(t[inside], lines, inertia / figures.doubt[j], rubs)
        swings = SWING * abs(float(dq[0, j]))
        out[inside, j] = min(swings, _calm(robot, figures, mass, j)) * shape
    return out


def _calm(robot: Robot, figures: JointFigures, mass: Array, j: int) -> float:
    """rad/s by which joint j may be shaken until another one is given ``FLUNG`` by it. mass: (n, n)
    kg·m² of the links."""
    free = figures.rotor + figures.link * np.diagonal(mass)
    given = np.abs(mass[:, j]) / np.maximum(free * robot.velocity, 1e-12)
    given[j] = 0.0
    return FLUNG / max(float(given.max()), 1e-12)


def multisine(t: Array, lines: Array, inertia: Array, viscous: float = 0.0) -> Array:
    """(N,) N·m that swing free inertias, (K,) kg·m² at each line, by 1 rad/s at the peak against
    viscous friction, N·m·s/rad; all lines alike."""
    k, w = np.arange(len(lines)), 2.0 * np.pi * lines
    phase = np.outer(t, w) - np.pi * k * (k - 1) / len(lines)
    fine = np.outer(np.arange(0.0, PERIOD, 1e-3), w) - np.pi * k * (k - 1) / len(lines)
    peak = np.abs(np.cos(fine).sum(axis=1)).max()
    torque = viscous * np.cos(phase) - inertia * w * np.sin(phase)
    return np.asarray(torque.sum(axis=1) / peak)
