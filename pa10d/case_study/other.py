"""The other trajectory, on which models are judged: work at full speed, no excitation design.

Every joint goes to and fro with a nearly constant speed, each at its own rate, as transfer motions
do. It has nothing in common with the exciting trajectory but the arm.
"""

from __future__ import annotations

import numpy as np

from pa10d.common.errors import UserError
from pa10d.trajectory.excitation.optimise import excitation_problem
from pa10d.trajectory.excitation.problem import ExcitationProblem
from pa10d.trajectory.kinds.excitation import Array, Excitation

FUNDAMENTAL = 0.05  # Hz
RATES = (2, 3, 4, 5)  # of the joints, in fundamentals: all different
ODD = (1, 3, 5)  # a triangle wave of position, cut off: speed stays near its top in between
TRIES = 60


def other_motion(problem: ExcitationProblem, periods: int, seed: int) -> Excitation:
    """As large as limits, bodies and floor allow."""
    asked = excitation_problem(
        problem.robot, fundamental=FUNDAMENTAL, harmonics=max(RATES) * max(ODD),
        samples=4 * max(RATES) * max(ODD),
    )  # fmt: skip
    rng = np.random.default_rng([seed, 5])
    for share in np.repeat(np.linspace(1.0, 0.3, TRIES // 4), 4):
        x = asked.repaired(_to_and_fro(asked, rng))
        x[1:] *= share
        if asked.excess(x) == 0.0:
            return Excitation.of(asked, x, periods)
    raise UserError(
        f"no transfer motion keeps the arm clear of itself and {problem.robot.environment}"
    )


def _to_and_fro(problem: ExcitationProblem, rng: np.random.Generator) -> Array:
    joints, h = len(problem.joints), problem.harmonics
    x = np.zeros((1 + 2 * h, joints))
    x[0] = problem.room.middle + problem.room.half * rng.uniform(-0.6, 0.6, joints)
    for j, rate in enumerate(rng.permutation(np.resize(RATES, joints))):
        phase = rng.uniform(0, 2 * np.pi)
        for k, order in enumerate(ODD):
            # sin(m(θ + φ)) = cos(mφ)·sin(mθ) + sin(mφ)·cos(mθ), and b counts -cos
            size = 10.0 * (-1) ** k / order**2
            x[rate * order, j] = size * np.cos(order * phase)
            x[h + rate * order, j] = -size * np.sin(order * phase)
    return x
